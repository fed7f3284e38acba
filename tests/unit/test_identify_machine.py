"""What the machine gives and a toe that hides in the noise: found where it can be, in the intervals where it cannot."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.identify.coupon import loading_curve, pull, straightened
from etextile.identify.curves import CouponSize, TensileCurve, read_curve
from etextile.identify.fit import DirectionFit, fit_direction
from etextile.identify.rivals import second_moment
from etextile.laws.powerlaw import PowerLaw
from etextile.studies.identify.identify import curves_of


WARP = PowerLaw(3000.0, 0.2, 9960.0, 1.5), 0.0561 / 0.0155, 0.12
BIAS = PowerLaw(1500.0, 0.2, 1550.0, 2.2), 0.0489 / 0.0155, 0.45
AREA = 29.0 * 0.35


def measured(
    of: tuple[PowerLaw, float, float], *, noise: float, seed: int, per_stress: float = 0.0, toe: float = 0.0
) -> TensileCurve:
    """A curve whose strain holds what the machine gave, with slack at its start; noise as a share of the peak."""
    law, ratio, top = of
    strain, stress = pull(law, top, area_ratio=ratio)
    quiet = np.arange(0.0, toe, strain[1])
    strain = np.r_[quiet, (1.0 + toe) * (1.0 + strain) - 1.0]
    stress = np.r_[0.0 * quiet, stress]
    loud = stress + np.random.default_rng(seed).normal(0.0, noise * stress.max(), len(stress))
    return TensileCurve.of(f"s{seed}", strain + per_stress * stress, loud)


def misses(fit: DirectionFit, law: PowerLaw) -> np.ndarray:
    """How many deviations E, H and n are off."""
    off = [np.log(fit.law.E / law.E), np.log(fit.law.H / law.H), fit.law.n - law.n]
    return np.abs(off) / np.sqrt(np.diag(fit.covariance))


@pytest.mark.parametrize("per_stress", [5e-5, 1e-4, 2e-4])
def test_a_compliance_that_one_curve_cannot_tell_is_in_the_interval(per_stress: float) -> None:
    """2e-4 per MPa lowers E by 12 %, which was claimed to be known within 1.5 %."""
    fit = fit_direction([measured(WARP, noise=0.005, seed=1, per_stress=per_stress)], WARP[1])
    assert misses(fit, WARP[0]).max() < 1.96
    assert any("strain not known to be measured on the specimen" in note for note in fit.notes)
    if per_stress == 2e-4:
        assert pytest.approx(0.88, abs=0.02) == fit.law.E / WARP[0].E


def test_strain_measured_on_the_specimen_keeps_its_narrow_interval() -> None:
    curve = measured(WARP, noise=0.005, seed=1)
    wide, narrow = (fit_direction([replace(curve, on_specimen=known)], WARP[1]) for known in (False, True))
    assert narrow.law == wide.law
    assert 4.0 * np.sqrt(narrow.covariance[0, 0]) < np.sqrt(wide.covariance[0, 0])
    assert not any("specimen" in note for note in narrow.notes)


def test_two_gauge_lengths_tell_the_machine() -> None:
    """846 N/mm: at 60 mm E would be 12 % too low, at 200 mm 4 %."""
    stiffness, curves = 846.0, []
    for seed, length in enumerate((60.0, 60.0, 200.0, 200.0)):
        curve = measured(WARP, noise=0.002, seed=seed, per_stress=AREA / length / stiffness)
        curves.append(replace(curve, size=CouponSize(29.0, 0.35, length)))
    fit = fit_direction(curves, WARP[1])
    assert pytest.approx(WARP[0].E, rel=0.05) == fit.law.E
    assert misses(fit, WARP[0]).max() < 1.96
    (said,) = [note for note in fit.notes if note.startswith("the machine gives by")]
    assert "gauge lengths" in said
    alone = fit_direction(curves[:2], WARP[1])
    assert alone.law.E < 0.9 * WARP[0].E
    assert misses(alone, WARP[0])[0] < 1.96


@pytest.mark.parametrize("toe", [0.0025, 0.005, 0.01, 0.02])
@pytest.mark.parametrize("noise", [0.005, 0.01])
def test_a_toe_is_taken_out_or_in_the_interval(toe: float, noise: float) -> None:
    """1 % in a bias curve with 1 % noise left n off by 5 %."""
    for seed in range(2):
        curve = replace(measured(BIAS, noise=noise, seed=seed, toe=toe), on_specimen=True)
        fit = fit_direction([curve], BIAS[1])
        assert misses(fit, BIAS[0])[1:].max() < 2.2
        if fit.specimens[0].hardening.datum == 0.0 and toe >= 0.01:
            assert any("would not be seen in the noise" in note for note in fit.notes)


@pytest.mark.parametrize("strain", [0.0, 1e-4, 0.005, 0.02, 0.12])
@pytest.mark.parametrize("toe", [0.002, 0.02])
def test_a_progressive_toe_is_taken_off_the_strain_that_holds_it(strain: float, toe: float) -> None:
    """e_fabric + toe (1 - exp(-s / c)) is the strain of the test, with s of the law at e_fabric."""
    over = 4.0
    x = straightened(WARP[0], np.array([strain]), toe=toe, over=over)
    stress = loading_curve(WARP[0], x).stress
    assert x + toe * (1.0 - np.exp(-stress / over)) == pytest.approx(strain, abs=1e-12)


def straightening(
    of: tuple[PowerLaw, float, float], taken: Callable[[np.ndarray], np.ndarray], seed: int
) -> TensileCurve:
    """A curve with 0.5 % noise whose yarns take up the Hencky strain `taken` of the stress before they are strained."""
    law, ratio, top = of
    strain, stress = pull(law, top, area_ratio=ratio)
    loud = stress + np.random.default_rng(seed).normal(0.0, 0.005 * stress.max(), len(stress))
    curve = TensileCurve.of(f"s{seed}", np.expm1(np.log1p(strain) + taken(stress / stress.max())), loud)
    return replace(curve, on_specimen=True)


@pytest.mark.parametrize(("toe", "over"), [(0.005, 0.04), (0.01, 0.02), (0.015, 0.08)])
def test_yarns_that_straighten_one_by_one_do_not_pass_for_a_steeper_law(toe: float, over: float) -> None:
    """N was off by 7 to 25 % and more than 2.5 of its claimed deviations, with only a misfit to show for it."""
    for seed in range(2):
        curve = straightening(WARP, lambda s: toe * (1.0 - np.exp(-s / over)), seed)
        fit = fit_direction([curve], WARP[1])
        assert misses(fit, WARP[0]).max() < 2.2
        assert any("a progressive toe of" in note and "taken out" in note for note in fit.notes)
        assert pytest.approx(WARP[0].n, abs=0.15) == fit.law.n


def test_a_toe_of_another_form_is_in_the_interval() -> None:
    """Taken up as s / (s + c), which the exponential does not follow to the end."""
    for seed in range(2):
        fit = fit_direction([straightening(WARP, lambda s: 0.01 * s / (s + 0.03), seed)], WARP[1])
        assert misses(fit, WARP[0])[2] < 2.2


def zeroed(of: tuple[PowerLaw, float, float], share: float, seed: int) -> TensileCurve:
    """A curve with 0.5 % noise whose strain and stress were set to zero at a share of the peak stress."""
    law, ratio, top = of
    strain, stress = pull(law, top, area_ratio=ratio)
    turn, preload = int(np.argmax(strain)), share * stress.max()
    start = float(np.interp(preload, stress[: turn + 1], strain[: turn + 1]))
    kept = np.r_[strain[: turn + 1] > start, stress[turn + 1 :] > preload]
    left = np.r_[preload, stress[kept]] - preload
    loud = left + np.random.default_rng(seed).normal(0.0, 0.005 * left.max(), len(left))
    curve = TensileCurve.of(f"s{seed}", (1.0 + np.r_[start, strain[kept]]) / (1.0 + start) - 1.0, loud)
    return replace(curve, on_specimen=True)


@pytest.mark.parametrize("of", [WARP, BIAS])
@pytest.mark.parametrize("share", [0.005, 0.02])
def test_a_preload_that_was_set_to_zero_is_noticed_or_in_the_interval(
    of: tuple[PowerLaw, float, float], share: float
) -> None:
    """H and n were off by more than they claimed in half of such fits."""
    fit = fit_direction([zeroed(of, share, seed) for seed in range(3)], of[1])
    assert misses(fit, of[0]).max() < 2.0
    assert fit.covariance[2, 2] < (0.08 * of[0].n) ** 2


def test_specimens_together_tell_a_preload_from_the_law_alone() -> None:
    """Three specimens without one leave less of the doubt than each of them alone, and it does not average out."""
    curves = [replace(measured(WARP, noise=0.005, seed=seed), on_specimen=True) for seed in range(3)]
    together = fit_direction(curves, WARP[1])
    alone = [fit_direction([curve], WARP[1]).specimens[0] for curve in curves]
    shared, own = (np.mean([fit.doubt[2, 2] for fit in fits]) for fits in (together.specimens, alone))
    assert 0.0 < shared < 0.5 * own
    assert together.covariance[2, 2] > shared


@pytest.mark.parametrize("mean", [-3.0, -0.5, 0.0, 2.0])
def test_a_strain_that_cannot_be_negative_has_the_moment_of_a_cut_normal(mean: float) -> None:
    x = np.linspace(0.0, mean + 12.0, 200001)
    density = np.exp(-0.5 * (x - mean) ** 2)
    assert second_moment(mean, 1.0) == pytest.approx(float((x**2 * density).sum() / density.sum()), rel=1e-3)


def test_machine_stiffness_is_taken_off_the_displacement(tmp_path: Path) -> None:
    law, ratio, top = WARP
    strain, stress = pull(law, top, area_ratio=ratio)
    travel, force = 60.0 * strain + AREA * stress / 1500.0, AREA * stress
    rows = "\n".join(f"{a:.9f},{b:.9f}" for a, b in zip(travel, force, strict=True))
    (tmp_path / "w.csv").write_text(f"displacement_mm,force_N\n{rows}\n", encoding="utf-8")
    head = "title: one\nchannels:\n  tensile:\n    machine_stiffness: 1500 N/mm\n    warp: [w.csv]\n"
    (tmp_path / "measured.yaml").write_text(head, encoding="utf-8")
    with pytest.raises(BadInput, match="give width, thickness and gauge_length too"):
        curves_of(tmp_path)
    sized = f"{head}    width: 29 mm\n    thickness: 0.35 mm\n    gauge_length: 60 mm\n"
    (tmp_path / "measured.yaml").write_text(sized, encoding="utf-8")
    (curve,) = curves_of(tmp_path)[1]["warp"]
    np.testing.assert_allclose(curve.strain, strain, atol=1e-9)
    assert pytest.approx(law.E, rel=1e-3) == fit_direction([curve], ratio).law.E
    plain = read_curve(tmp_path / "w.csv", size=CouponSize(29.0, 0.35, 60.0))
    assert fit_direction([plain], ratio).law.E < 0.96 * law.E
