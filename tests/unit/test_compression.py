"""Compression ratios: one for all or one per family, by case or by fabric, and what is said against wrong ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.laws.powerlaw import PowerLaw, respond, stored_energy
from loadcases.build import build
from loadcases.compression import PerFamily, ratios
from loadcases.fabric import load_fabric
from loadcases.reader import dump_case, load_case


COARSE = ("fabric.coarsening=14", "motion.steps=1")


def built_ratios(*overrides: str, case: str = "tension_warp") -> tuple[float, ...]:
    model = build(load_case(case, overrides=[*COARSE, *overrides]).case).model
    return tuple(law.compression_ratio for law in model.lattice_block.laws)


def test_a_number_holds_for_all_families_and_a_mapping_for_each() -> None:
    assert ratios(0.1) == (0.1, 0.1, 0.1)
    assert ratios(PerFamily(warp=1.0, weft=0.5)) == (1.0, 0.5, 0.0)
    assert built_ratios() == (0.0, 0.0, 0.0)
    assert built_ratios("fabric.compression_ratio=0.1") == (0.1, 0.1, 0.1)
    assert built_ratios(case="bias_extension") == (1.0, 1.0, 0.0)
    assert built_ratios("fabric.compression_ratio.weft=0.3", case="bias_extension") == (1.0, 0.3, 0.0)


def test_the_larger_of_case_and_fabric_counts() -> None:
    assert {getattr(load_fabric("nylon_woven"), name).compression_ratio for name in ("warp", "weft", "diagonal")} == {
        1.0
    }
    nylon = ("fabric.set=nylon_woven", "fabric.coarsening=10")
    assert built_ratios(*nylon) == (1.0, 1.0, 1.0)
    assert built_ratios(*nylon, case="bias_extension") == (1.0, 1.0, 1.0)


def test_both_forms_are_written_back_as_they_were_read() -> None:
    for case in ("bias_extension", "tension_warp"):
        loaded = load_case(case)
        assert "compression_ratio" in dump_case(loaded.case)
    assert "diagonal: 0.0" in dump_case(load_case("bias_extension").case)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("2", r"compression_ratio: out of range \(got 2\), must be at least 0 and at most 1"),
        ("{warp: 1, wefft: 0.1}", r"compression_ratio\.wefft: unknown key, .*, did you mean 'weft'"),
        ("{diagonal: -1}", r"compression_ratio\.diagonal: out of range \(got -1\)"),
        ("[1, 1, 0]", "compression_ratio: not a number"),
        ("half", r"compression_ratio: text, not a number \(got 'half'\)"),
    ],
)  # fmt: skip
def test_wrong_ratios_get_one_clear_message(value: str, message: str) -> None:
    with pytest.raises(BadInput, match=message) as caught:
        load_case("bias_extension", overrides=[f"fabric.compression_ratio={value}"])
    assert len(caught.value.problems) == 1


def test_a_truss_that_starts_at_rest_has_a_finite_tangent_for_every_exponent() -> None:
    for n in (0.8, 1.0, 1.5):
        row = PowerLaw(1500.0, 0.2, 1550.0, n, compression_ratio=1.0).row()
        tau, slope, plastic = respond(row, 0.0, 0.0)
        assert (tau, plastic) == (0.0, 0.0)
        assert np.isfinite(slope)
        assert respond(row, -0.01, 0.0)[0] < 0.0


def in_tension(law: PowerLaw, strain: float) -> float:
    """Force over A0 (MPa) of a virgin truss at a Hencky strain by bisection of E (strain - p) = s(p), plain Python."""
    low, high = 0.0, strain
    for _ in range(200):
        p = 0.5 * (low + high)
        s = law.sigma_y0 * p / (p + law.e0) + law.H * p**law.n
        low, high = (p, high) if law.E * (strain - p) > s else (low, p)
    return float(s * np.exp(-p))


@pytest.mark.parametrize("strain", [0.001, 0.02, 0.1, 0.3])
@pytest.mark.parametrize("law", [PowerLaw(3000.0, 0.2, 9960.0, 1.5), PowerLaw(4500.0, 0.2, 4230.0, 1.1)])
def test_force_in_compression_is_the_ratio_of_the_force_in_tension(law: PowerLaw, strain: float) -> None:
    """With E (eps - p) = s(p) solved; s(eps) itself would be 1.68 (2 %) to 2.52 (10 %) times too stiff in the warp."""
    exact = in_tension(law, strain)
    for ratio in (0.1, 1.0):
        row = replace(law, compression_ratio=ratio).row()
        pull, push = (respond(row, sign * strain, 0.0)[0] * np.exp(-sign * strain) for sign in (1.0, -1.0))
        assert pull == pytest.approx(exact, rel=1e-9)
        assert push == pytest.approx(-ratio * exact, rel=1e-9)


@pytest.mark.parametrize("n", [0.8, 1.1, 2.2])
def test_energy_force_and_tangent_in_compression_agree(n: float) -> None:
    """The energy is the integral of the force along the way (own Simpson rule), the slope its difference quotient."""
    row = PowerLaw(1500.0, 0.2, 1550.0, n, compression_ratio=0.7).row()
    ways = np.linspace(0.0, np.sqrt(0.2), 2001) ** 2
    tau = np.array([respond(row, -way, 0.0)[0] for way in ways])
    t, f = np.sqrt(ways), -2.0 * np.sqrt(ways) * tau
    simpson = (t[1] - t[0]) / 3.0 * (f[0] + f[-1] + 4.0 * f[1:-1:2].sum() + 2.0 * f[2:-1:2].sum())
    assert stored_energy(row, -0.2, 0.0) == pytest.approx(simpson, rel=1e-6)
    h = 1e-6
    slope = (respond(row, -0.05 + h, 0.0)[0] - respond(row, -0.05 - h, 0.0)[0]) / (2 * h)
    assert respond(row, -0.05, 0.0)[1] == pytest.approx(slope, rel=1e-6)
