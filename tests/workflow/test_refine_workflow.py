"""Refinement from curves to fabric file, the coupon in a report, the nylon in a direction not used to identify it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.nylon import predictions, under_assumptions

from etextile.app.verbs_identify import identify as verb
from etextile.errors import BadInput
from etextile.identify.coupon import pull
from etextile.identify.curves import TensileCurve
from etextile.identify.virtual import Coupon, coupon_stress, in_bias
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.studies.identify.found import Identification
from etextile.studies.identify.identify import identify_curves, write
from etextile.studies.identify.refine import BIAS_LIMIT, refined, work
from etextile.studies.run.coupon import is_coupon
from etextile.studies.run.run import run
from etextile.text.refine import refinement_text
from etextile.text.run import report_text
from loadcases.fabric import load_fabric
from loadcases.reader import load_case


WEAVE = Weave(0.2849, 0.1603, 0.35, 0.0155, 11.0, 8.9)
MID = (PowerLaw(3000.0, 0.2, 9960.0, 1.5), PowerLaw(4500.0, 0.2, 4230.0, 1.1), PowerLaw(1500.0, 0.2, 1550.0, 2.2))
SIZE, COARSENING = (60.0, 29.0), 14.0


def coupon_tests() -> dict[str, list[TensileCurve]]:
    """Curves as coupons of known fabric return them: the loading simulated, the unloading that of the element."""
    curves = {}
    for number, (direction, angle, top) in enumerate((("warp", 0.0, 0.12), ("bias", 45.0, BIAS_LIMIT))):
        family = 2 * number
        laws = in_bias(MID) if family == 2 else MID
        strain = np.linspace(0.0, top, 61)
        stress = coupon_stress(WEAVE, laws, Coupon(SIZE, angle, COARSENING), strain=strain[1:], increments=12)
        down, slack = pull(MID[family], top, area_ratio=WEAVE.nominal_area[family] / WEAVE.truss_area)
        unloading = slice(101, None)
        scale = stress[-1] / slack[100]
        curves[direction] = [
            TensileCurve.of(
                direction,
                np.concatenate([strain, down[unloading]]),
                np.concatenate([[0.0], stress, scale * slack[unloading]]),
            )
        ]
    return curves


@pytest.fixture(scope="module")
def results() -> tuple[Identification, Identification, list[str]]:
    """The direct identification, the refined one, and what was said on the way."""
    said: list[str] = []
    direct = identify_curves(coupon_tests(), title="simulated coupons")
    base = load_fabric("estimated_mid")
    after = refined(direct, base, coarsening=COARSENING, watch=lambda done, text: said.append(f"{done:g} {text}"))
    return direct, after, said


def test_refined_laws_return_curves_that_direct_laws_do_not(
    results: tuple[Identification, Identification, list[str]],
) -> None:
    _, after, said = results
    found = after.refinement
    assert found is not None
    assert found.refined.converged
    assert found.refined.misfit < 0.02
    assert set(found.targets) == {"warp", "diagonal"}
    for family in found.targets:
        target, off = found.direct[family]
        before = np.linalg.norm(off * target.stress) / np.linalg.norm(target.stress)
        target, off = found.targets[family], found.refined.after[family]
        after_all = np.linalg.norm(off * target.stress) / np.linalg.norm(target.stress)
        assert before > 0.03, "the direct use of the curve is off"
        assert after_all < 0.4 * before
    assert 0 < len(said) <= work(2)
    assert said[0].startswith("1 warp coupon")


def test_refinement_comes_closer_to_the_fabric_that_was_tested(
    results: tuple[Identification, Identification, list[str]],
) -> None:
    direct, after, _ = results
    strain = np.array([0.04, 0.08, 0.12])

    def law(result: Identification) -> PowerLaw:
        item = result.fabric.warp
        return PowerLaw(item.E.value, item.sigma_y0.value, item.H.value, item.n.value, e0=item.e0)

    true = MID[0].loading_curve(strain)
    before, now = (np.abs(law(item).loading_curve(strain) / true - 1.0) for item in (direct, after))
    assert before[-1] > 0.03
    assert now[-1] < 0.5 * before[-1]


def test_the_file_says_that_it_was_refined_and_keeps_the_scatter(
    results: tuple[Identification, Identification, list[str]], tmp_path: Path
) -> None:
    direct, after, _ = results
    written = write(after, tmp_path / "fabric.yaml")
    fabric = load_fabric(tmp_path / "fabric.yaml")
    assert fabric.warp.source.endswith("refined by virtual coupons of 60 x 29 mm")
    assert "refined" not in fabric.weft.source
    assert fabric.warp.E == direct.fabric.warp.E
    h, before = fabric.warp.H, direct.fabric.warp.H
    assert h.std is not None
    assert before.std is not None
    assert h.std / h.value == pytest.approx(before.std / before.value, rel=1e-4)
    assert fabric.warp.covariance is not None
    assert np.sqrt(fabric.warp.covariance.matrix[1][1]) == pytest.approx(h.std, rel=1e-4)
    assert tmp_path / "fabric_refined.png" in written.figures
    text = refinement_text(after)
    assert max(map(len, text.splitlines())) <= 80
    for word in ("direct use of a curve", "warp", "bias", "coarsening 14"):
        assert word in text
    assert refinement_text(direct) == ""


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"strips": 3}, "add --refine"),
        ({"coarsening": 5.0}, "add --refine"),
        ({"refine": True, "strips": 0}, r"--strips: out of range \(got 0\)"),
        ({"refine": True, "coarsening": 0.5}, r"--coarsening: out of range \(got 0\.5\)"),
        ({"refine": True, "coarsening": float("nan")}, "--coarsening: out of range"),
    ],
)
def test_options_of_refinement_are_checked_first(arguments: dict[str, object], message: str, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=message):
        verb(tmp_path / "nothing", output=tmp_path / "fabric.yaml", **arguments)  # type: ignore[arg-type]


def test_a_coupon_too_small_for_its_lattice_is_said(tmp_path: Path) -> None:
    direct = identify_curves({"bias": coupon_tests()["bias"]}, title="one direction")
    with pytest.raises(BadInput, match="leaves no whole cell"):
        refined(direct, load_fabric("estimated_mid"), coarsening=200.0)


def test_the_report_of_a_coupon_holds_its_curve_centre_and_zones(tmp_path: Path) -> None:
    loaded = load_case("bias_extension", overrides=["fabric.coarsening=12", "motion.steps=4", "outputs.maps=[]"])
    assert is_coupon(loaded.case)
    outcome = run(loaded, tmp_path / "out")
    coupon = json.loads((tmp_path / "out" / "report.json").read_text(encoding="utf-8"))["coupon"]
    assert coupon["strain"] == pytest.approx([0.07, 0.14, 0.21, 0.28])
    force = np.array(outcome.report["punch"]["force_N"])
    assert coupon["stress_MPa"] == pytest.approx(force / (29.0 * 0.35))
    assert coupon["single_element_MPa"][1] == pytest.approx(coupon["stress_MPa"][1], rel=0.12)
    assert coupon["centre"]["strain"][0] > 0.07 > coupon["centre"]["strain_across"][0]
    shear = coupon["centre"]["shear_angle_deg"][2]
    assert shear == pytest.approx(coupon["trellis"]["shear_angle_deg"][2], rel=0.05)
    assert list(coupon["zones"]) == ["A", "B", "C"]
    zones = [zone["shear_angle_deg"][2] for zone in coupon["zones"].values()]
    assert zones[0] < 0.4 * zones[2] < zones[1] < zones[2]
    text = report_text(outcome.report)
    assert "Coupon of 60 x 29 mm, warp at 45 deg" in text
    assert max(map(len, text.splitlines())) <= 80
    assert not is_coupon(load_case("punch").case)


def test_the_nylon_is_predicted_at_30_degrees_within_12_per_cent() -> None:
    """Identified at 0, 90 and 45 degrees. 5 to 9 % too stiff is what is found; no orthotropic sheet comes closer."""
    found = predictions((30, 45), coarsening=2.0)
    assert 0.02 < found[30].mean_error < 0.12
    assert found[30].mean_absolute_error < 0.12
    assert found[30].rms < 0.12
    assert found[45].mean_absolute_error < 0.03, "the direction it was identified in"


@pytest.mark.slow
def test_the_shipped_nylon_returns_the_curves_it_was_identified_from() -> None:
    found = predictions((0, 30, 45, 90))
    for angle in (0, 45, 90):
        assert found[angle].mean_absolute_error < 0.02
        assert found[angle].rms < 0.02
    assert found[30].mean_error == pytest.approx(0.076, abs=0.015)


def test_why_the_nylon_is_predicted_too_stiff() -> None:
    """The more compression is carried, the better; linear orthotropy, which no lattice enters, is off as far."""
    found = {name: item.mean_error for name, item in under_assumptions().items()}
    bonded, half, tenth, slack, sheet = found.values()
    assert 0.0 < bonded < half < tenth < slack
    assert bonded < 0.1
    assert sheet > 0.1
