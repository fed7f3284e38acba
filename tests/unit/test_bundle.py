"""The bundle of filaments: closed forms, a simulated bundle, the paper's onset, bending at the ends of loops."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.types import Array
from etextile.vocabulary import OPEN, PARTIAL, PLASTIC
from wires.bending import CELL_MM, exit_angle, exit_strain, stress_raiser
from wires.bundle import Bundle
from wires.coupon import stretched
from wires.criteria.filament_bundle import PARAMETERS, bundle_of


SOFT = Bundle(filaments=7, elongation=0.07, shape=15.0, spread=0.05, scatter=0.005)
COUPON_LOOPS = 23
"""Loops of a coupon of 100 x 29 mm: 4.9 wires with a loop every 20 mm."""


def simulated(bundle: Bundle, strain: float, bending: float, *, loops: int, seed: int) -> Array:
    """Return the counts (loops,) of broken filaments of bundles drawn one by one."""
    rng = np.random.default_rng(seed)
    own = strain + bundle.scatter * rng.normal(size=(loops, 1))
    taken = own - bundle.spread * rng.random((loops, bundle.filaments))
    # whole when mounted, so its elongation is beyond the bending strain: inverse of the conditional Weibull law
    units = rng.random(taken.shape)
    power = (bending / bundle.scale) ** bundle.shape - np.log(units)
    elongation = bundle.scale * power ** (1.0 / bundle.shape)
    return np.asarray(((taken > 0.0) & (taken + bending > elongation)).sum(axis=1))


@pytest.mark.parametrize(("strain", "bending"), [(0.04, 0.018), (0.06, 0.018), (0.08, 0.018), (0.09, 0.0)])
def test_probabilities_are_those_of_bundles_drawn_one_by_one(strain: float, bending: float) -> None:
    drawn = simulated(SOFT, strain, bending, loops=40_000, seed=4)
    expected = SOFT.counts(np.array(strain), bending)
    assert expected.sum() == pytest.approx(1.0)
    assert np.bincount(drawn, minlength=8) / 40_000 == pytest.approx(expected, abs=0.01)
    assert (drawn > 0).mean() == pytest.approx(SOFT.failure_probability(np.array(strain), bending), abs=0.01)
    assert (drawn == 7).mean() == pytest.approx(SOFT.open_probability(np.array(strain), bending), abs=0.01)


def test_equally_long_filaments_break_by_the_weibull_law() -> None:
    taut = Bundle(filaments=7, elongation=0.07, shape=15.0, spread=0.0, scatter=0.0)
    strains = np.linspace(0.0, 0.2, 20_001)
    share = taut.broken_share(strains)
    assert share[np.searchsorted(strains, taut.scale)] == pytest.approx(1.0 - np.exp(-1.0), abs=1e-3)
    assert np.trapezoid(1.0 - share, strains) == pytest.approx(0.07, rel=1e-3)  # the mean elongation at break
    assert taut.strain_at(0.5, np.zeros(1)) == pytest.approx(taut.scale * np.log(2.0) ** (1 / 15))


def test_survivors_carry_the_bundle_so_that_its_force_peaks_before_all_are_broken() -> None:
    """Under strain control each survivor carries its own share: the bundle's force is e (1 - broken share)."""
    strains = np.linspace(0.0, 0.15, 1501)
    force = strains * (1.0 - SOFT.broken_share(strains))
    peak = strains[force.argmax()]
    assert 0.05 < peak < 0.09
    assert force[-1] == pytest.approx(0.0, abs=1e-6)


def test_the_paper_s_onset_comes_out_without_being_fitted() -> None:
    """Section 2.3: whole at 0, 2 and 6 % fabric strain, first filaments broken at 7 %, more beyond, some wires open.

    Per coupon of 23 loops less than one has lost a filament at 6 %, some have at 7 %, most at 8 %, and those at 7 %
    have lost one or two. Only the spread of the filaments' lengths is fitted, and it is not to this but to 13 %.
    """
    strain = np.array([0.0, 0.02, 0.06, 0.07, 0.08, 0.10, 0.13])
    found = stretched(strain, "filament_bundle")
    damaged = COUPON_LOOPS * found.failure_probability
    assert damaged[:2].max() < 1e-3
    assert damaged[2] < 1.0
    assert 2.0 < damaged[3] < 8.0
    assert damaged[4] > 0.5 * COUPON_LOOPS
    assert found.loop_state[[2, 4, 5, 6]].tolist() == [PLASTIC, PARTIAL, PARTIAL, OPEN]
    assert found.broken_counts is not None
    few = found.broken_counts[3, 1:3].sum() / found.failure_probability[3]
    assert few > 0.9
    opened = 1.0 - (1.0 - found.open_probability) ** COUPON_LOOPS
    assert opened[4] < 0.01 < 0.2 < opened[5] < 0.8 < opened[6]


def test_what_the_onset_rests_on() -> None:
    """Slack puts the typical loop's first break off one to one, the bending that comes with it brings it forward."""
    defaults = bundle_of({parameter.name: parameter.default for parameter in PARAMETERS})
    first = 0.5 / defaults.filaments

    def onset(slack: float, *, bent: bool) -> float:
        bending = exit_strain(np.array([slack]), filament_diameter_mm=0.03) if bent else np.zeros(1)
        return float((1.0 + defaults.strain_at(first, bending)[0]) * (1.0 + slack) - 1.0)

    usual = onset(0.02, bent=True)
    assert usual == pytest.approx(0.0755, abs=0.001)
    assert onset(0.02, bent=False) - usual == pytest.approx(0.018, abs=0.003)
    assert onset(0.0, bent=True) == pytest.approx(usual, abs=0.004)


def test_a_slack_loop_leaves_the_weave_at_the_angle_of_its_arc() -> None:
    slack = np.array([0.0, 0.005, 0.02, 0.1, 0.4])
    angle = exit_angle(slack)
    assert angle[0] == 0.0
    assert angle[1:] / np.sin(angle[1:]) == pytest.approx(1.0 + slack[1:])
    assert angle[1] == pytest.approx(np.sqrt(6.0 * 0.005), rel=0.01)  # a shallow arc
    assert exit_strain(slack, filament_diameter_mm=0.03)[2] == pytest.approx(0.5 * 0.03 * angle[2] / CELL_MM)


def test_wires_break_at_clearances_because_they_are_bent_there() -> None:
    """At equal stretch the exit of a loop is strained a third more than the woven-in wire, which has no turn."""
    bending = exit_strain(np.array([0.02]), filament_diameter_mm=0.03)
    raised = stress_raiser(np.array([0.055]), bending)
    assert raised == pytest.approx(1.33, abs=0.03)
    assert stress_raiser(np.array([0.0]), bending) == 1.0
    at_loop = SOFT.failure_probability(np.array([0.055]), bending)
    woven_in = SOFT.failure_probability(np.array([0.055]), 0.0)
    assert at_loop[0] > 0.3 > 0.1 > woven_in[0]
