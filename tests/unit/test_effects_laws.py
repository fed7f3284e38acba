"""Effects on the yarn laws against closed forms: tail, damage, compression, rate, pretension."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.effects.change import lattice_block, plastic_part
from etextile.effects.compression_carry import CompressionCarry
from etextile.effects.pretension import Pretension
from etextile.effects.rate_dependence import RateDependence, strain_rate
from etextile.effects.registry import build_effect
from etextile.effects.yarn_damage import YarnDamage
from etextile.effects.yarn_tail import YarnTail
from etextile.errors import BadInput
from etextile.lattice.weave import DIAGONAL, WARP, WEFT
from etextile.laws.powerlaw import PowerLaw, respond
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussResponse
from loadcases.build import build
from loadcases.reader import load_case


def model(name: str = "punch", *overrides: str) -> Model:
    return build(load_case(name, overrides=["wires=null", "fabric.coarsening=60", *overrides]).case).model


def laws(changed: Model) -> tuple[PowerLaw, ...]:
    return lattice_block(changed).laws


def true_stress(law: PowerLaw, strain: float) -> float:
    """Loading from the virgin state to an engineering strain, from sigma = E (eps - p) = s(p) by bisection."""
    low, high = 0.0, np.log1p(strain)
    for _ in range(200):
        p = 0.5 * (low + high)
        s = law.sigma_y0 * p / (p + law.e0) + law.H * p**law.n
        low, high = (p, high) if law.E * (np.log1p(strain) - p) > s else (low, p)
    return law.E * (np.log1p(strain) - p)


def stress(law: PowerLaw, strain: float) -> float:
    """True stress of a law as the simulation has it: tau = sigma exp(eps_e)."""
    tau, _, p = respond(law.row(), np.log1p(strain), 0.0)
    return tau * np.exp(p - np.log1p(strain))


@pytest.mark.parametrize("change", [-0.7, 0.5])
def test_the_yield_stress_rises_by_the_changed_slope_beyond_the_onset_only(change: float) -> None:
    base, tail = laws(model())[WARP], laws(YarnTail(change, 0.12).apply(model()))[WARP]
    assert stress(tail, 0.10) == pytest.approx(true_stress(base, 0.10), rel=1e-9)
    assert stress(tail, 0.10) == pytest.approx(stress(base, 0.10), rel=1e-14)
    assert stress(tail, 0.1199) == pytest.approx(stress(base, 0.1199), rel=1e-12)
    onset = plastic_part(base, 0.12)
    for p in (0.15, 0.3):
        s = base.sigma_y0 * p / (p + base.e0) + base.H * p**base.n
        start = base.sigma_y0 * onset / (onset + base.e0) + base.H * onset**base.n
        wanted = start + (1.0 + change) * (s - start)
        found = respond(tail.row(), p + wanted / tail.E, 0.0)
        assert found[2] == pytest.approx(p, rel=1e-9)
        assert found[0] * np.exp(-wanted / tail.E) == pytest.approx(wanted, rel=1e-9)


def test_a_tail_leaves_the_diagonals_alone() -> None:
    before, after = laws(model()), laws(YarnTail(-0.5).apply(model()))
    assert after[DIAGONAL] == before[DIAGONAL]
    assert after[WEFT].tail_factor == -0.5


def test_damage_takes_its_share_of_stress_and_of_the_unloading_modulus() -> None:
    base, damaged = laws(model())[WARP], laws(YarnDamage(3.0, 0.12).apply(model()))[WARP]
    assert stress(damaged, 0.11) == stress(base, 0.11)
    eps = np.log1p(0.2)
    _, _, p = respond(damaged.row(), eps, 0.0)
    left = np.exp(-3.0 * (p - plastic_part(base, 0.12)))
    assert 0.85 < left < 0.95
    assert stress(damaged, 0.2) == pytest.approx(left * stress(base, 0.2), rel=1e-12)
    unload = [respond(damaged.row(), p + e, p)[0] * np.exp(-e) for e in (1e-3, 2e-3)]
    assert (unload[1] - unload[0]) / 1e-3 == pytest.approx(left * damaged.E, rel=1e-9)


def test_a_compressed_yarn_carries_its_share_of_the_mirrored_loading_curve() -> None:
    base, carrying = laws(model())[WEFT], laws(CompressionCarry(0.1).apply(model()))[WEFT]
    for flowed in (0.005, 0.05):
        s = base.sigma_y0 * flowed / (flowed + base.e0) + base.H * flowed**base.n
        strain = flowed + s / base.E
        tau, _, p = respond(carrying.row(), -strain, 0.0)
        assert tau == pytest.approx(-0.1 * s * np.exp(-flowed - strain), rel=1e-12)
        assert p == 0.0
        assert respond(base.row(), -strain, 0.0)[0] == 0.0
    assert stress(carrying, 0.1) == stress(base, 0.1)


def test_compression_adds_to_what_the_case_has() -> None:
    given = model("punch", "fabric.compression_ratio=0.05")
    assert laws(CompressionCarry(0.1).apply(given))[WARP].compression_ratio == pytest.approx(0.15)


def test_the_rate_of_the_paper_is_found() -> None:
    """Beex et al., section 5: 8.3e-3 /s on average at 1 mm/s; a pulled strip strains at speed over length."""
    assert strain_rate(model()) == pytest.approx(8.3e-3, rel=3e-3)
    assert strain_rate(replace(model(), speed=10.0)) == pytest.approx(8.3e-2, rel=3e-3)
    pulled = model("tension_warp")
    assert strain_rate(pulled) == pytest.approx(pulled.speed / np.ptp(pulled.points[:, 0]), rel=1e-12)


def test_a_decade_of_rate_scales_every_stress() -> None:
    fast = replace(model(), speed=1.67e-3 / 8.284e-3 * 10.0)
    before, after = laws(fast), laws(RateDependence(0.06).apply(fast))
    for old, new in zip(before, after, strict=True):
        assert stress(new, 0.08) / stress(old, 0.08) == pytest.approx(1.06, abs=1e-5)


def test_a_rate_that_leaves_no_stress_is_refused() -> None:
    slow = replace(model(), speed=1e-30)
    with pytest.raises(BadInput, match="leaves no stress"):
        RateDependence(0.1).apply(slow)


@pytest.mark.parametrize("strain", [0.02, -0.02])
def test_mounted_taut_the_warp_bears_its_loading_curve_and_slack_nothing(strain: float) -> None:
    mounted = Pretension(strain).apply(model())
    block = lattice_block(mounted)
    found = block.respond(mounted.points, 0.0, block.initial_state())
    assert isinstance(found, TrussResponse)
    law = block.laws[WARP]
    warp = block.family == WARP
    expected = max(true_stress(law, strain), 0.0) if strain > 0.0 else 0.0
    np.testing.assert_allclose(found.stress[warp], expected, rtol=1e-9)
    assert not found.force[block.family == WEFT].any()
    np.testing.assert_allclose(found.strain, 0.0, atol=1e-14)


def test_the_mounted_diagonal_has_the_free_length_of_the_shrunken_cell() -> None:
    base, mounted = model(), Pretension(0.02).apply(model())
    block = lattice_block(mounted)
    diagonal = block.family == DIAGONAL
    d = base.points[block.nodes[diagonal, 1]] - base.points[block.nodes[diagonal, 0]]
    np.testing.assert_allclose(block.rest_length[diagonal], np.hypot(d[:, 0] / 1.02, d[:, 1]), rtol=1e-12)


def test_a_piece_that_was_laid_in_taut_both_ways_has_the_weft_shortened_by_its_share() -> None:
    base, mounted = model(), Pretension(0.02, across=0.5).apply(model())
    block = lattice_block(mounted)
    for family, ratio in ((WARP, 1.02), (WEFT, 1.01)):
        own = block.family == family
        np.testing.assert_allclose(lattice_block(base).rest_length[own] / block.rest_length[own], ratio, rtol=1e-12)


def test_pretension_needs_clamps() -> None:
    free = replace(model(), fixed=np.zeros_like(model().fixed))
    with pytest.raises(BadInput, match="needs clamped edges"):
        Pretension(0.01).apply(free)


@pytest.mark.parametrize("effect", ["yarn_tail", "yarn_damage"])
def test_the_onset_has_a_default_at_the_end_of_the_coupons(effect: str) -> None:
    main = {"yarn_tail": {"slope_change": 0.5}, "yarn_damage": {"rate": 1.0}}[effect]
    assert build_effect(effect, main).values["onset"] == 0.12


def test_the_loading_curve_bends_at_the_onset() -> None:
    base, tail = laws(model())[WARP], laws(YarnTail(-0.5).apply(model()))[WARP]
    strain = np.array([0.05, 0.11, 0.2])
    np.testing.assert_array_equal(tail.loading_curve(strain) < base.loading_curve(strain), [False, False, True])
