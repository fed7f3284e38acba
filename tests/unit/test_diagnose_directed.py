"""Directed tests: faults of a test are seen where they show, and are not seen where there are none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support.finalists import NOTHING, OTHER, SURE, contender, finalist

from etextile.diagnose.data.noise import NoiseScatter, SignalShape, WeightedScatter
from etextile.diagnose.data.points import Points, Series, Thinning
from etextile.diagnose.decide.directed import Check, Fault, checks, faults, in_words
from etextile.diagnose.decide.rank import Contender, Kind, Ranking
from etextile.diagnose.decide.verdict import Answer, decide
from etextile.diagnose.infer.fit import judge
from etextile.diagnose.infer.whitened import Workbench
from etextile.types import Array
from etextile.vocabulary import EDGE, FORCE


STEPS = np.linspace(1.0, 40.0, 40)
BASE = 1700.0 * (STEPS / 40.0) ** 2.6
FORM = np.zeros((120, 1))
NOISE = 5.0


def forces(residual: Array) -> Workbench:
    """Three force curves to 40 mm with white noise and a scatter in gain of 0.5 %; `residual` (120,)."""
    nowhere, base = np.full(120, np.nan), np.tile(BASE, 3)
    points = Points(
        tuple(Series(FORCE, "force", "N", n, f"punch_{n + 1}") for n in range(3)), np.repeat([0, 1, 2], 40),
        np.tile(STEPS, 3), nowhere, nowhere, base + residual, nowhere,
    )  # fmt: skip
    white = np.full(120, NOISE)
    return Workbench(
        points, Thinning(np.arange(120), np.ones(120)), points, base, residual, white, white,
        SignalShape(base, np.gradient(base), base), (WeightedScatter(1.0, NoiseScatter(0.005, 1e-6, 1e-6)),),
        np.zeros((120, 1)), np.zeros(120),
    )  # fmt: skip


def noise(seed: int = 0) -> Array:
    return NOISE * np.random.default_rng(seed).standard_normal(120)


def test_a_drift_of_the_load_cell_and_a_weft_of_another_make_are_told_by_their_patterns() -> None:
    """The weft carries a share of the force that grows with depth; a drift is there before the fabric carries any."""
    weft = np.tile(BASE * (STEPS / 40.0) ** 2, 3)
    jacobian = np.zeros((120, 9))
    jacobian[:, 4] = weft
    drift = np.tile(12.0 + 30.0 * STEPS / 40.0, 3)
    for hidden, expected in ((drift, "load_cell_drift"), (-0.2 * weft, "other_weft")):
        bench = forces(hidden + noise())
        found = faults(bench, FORM, jacobian, exponents=(1.5, 1.5, 2.5))
        likeliest = max(found, key=lambda item: item.contender.score)
        assert likeliest.id == expected
        assert likeliest.contender.evidence.log_evidence > judge(bench.samples, (), FORM).log_evidence + 20.0
    bench = forces(noise(1))
    nothing = judge(bench.samples, (), FORM).log_evidence
    assert all(
        item.contender.evidence.log_evidence < nothing
        for item in faults(bench, FORM, jacobian, exponents=(1.5, 1.5, 2.5))
    )


def test_a_specimen_that_stands_out_of_the_others_is_named_by_its_file() -> None:
    own = np.repeat([0.0, 1.0, 0.0], 40)
    even = checks(forces(0.01 * np.tile(BASE, 3) * own + noise()))
    odd = checks(forces(-0.25 * np.tile(BASE, 3) * own + noise()))
    assert [item.failed for item in even] == [False]
    assert [item.failed for item in odd] == [True]
    assert "punch_2 is -24.9 % off the others' " in odd[0].words


def edges(apart: float, seed: int = 0) -> Workbench:
    """Heights of a free edge at nine places left and right of the centre, the right half `apart` mm higher."""
    places = np.array([-40.0, -30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0, 40.0])
    steps, warp0 = (axis.ravel() for axis in np.meshgrid(np.arange(5.0, 41.0, 5.0), places, indexing="ij"))
    height = 0.3 * steps * (1.0 - (warp0 / 50.0) ** 2)
    count = len(steps)
    value = height + apart * (warp0 > 0.0) + 0.05 * np.random.default_rng(seed).standard_normal(count)
    points = Points(
        (Series(EDGE, "height", "mm", 0, "free_edge"),), np.zeros(count, dtype=np.int64), steps, warp0,
        np.full(count, np.inf), value, np.full(count, 0.05),
    )  # fmt: skip
    white = np.full(count, 0.05)
    return Workbench(
        points, Thinning(np.arange(count), np.ones(count)), points, height, value - height, white, white,
        SignalShape(height, 0.0 * height, height), (WeightedScatter(1.0, NoiseScatter(1e-6, 1e-6, 1e-6)),),
        np.zeros((count, 1)), np.zeros(count),
    )  # fmt: skip


def test_halves_that_move_unlike_fail_the_test_of_symmetry_and_no_others() -> None:
    assert [item.failed for seed in range(20) for item in checks(edges(0.0, seed))] == [False] * 20
    (found,) = checks(edges(0.5))
    assert found.failed
    assert found.id == "symmetry_free_edge"
    assert "mirrored points of the free edge differ by 0.5 mm" in found.words


def fault(probability: float) -> Fault:
    bare = contender("free", probability=probability)
    return Fault(
        "other_weft", "a weft law that is not the one of the coupons", "Cut coupons.",
        Contender(Kind.FAULT, bare.evidence, bare.log_prior, fault="other_weft"), "weft",
    )  # fmt: skip


def test_laws_of_several_families_are_told_in_one_phrase() -> None:
    weft = fault(0.1)
    drift = replace(weft, id="load_cell_drift", family="", words="a drift of the load cell")
    both = [
        replace(weft, id="other_warp", family="warp", words="a warp law that is not the one of the coupons"),
        drift,
        weft,
    ]
    assert in_words(both) == "a warp or weft law that is not the one of the coupons or a drift of the load cell"
    assert in_words([drift]) == "a drift of the load cell"


@pytest.mark.parametrize(("odds", "kind"), [(300.0, Answer.AMBIGUOUS), (3000.0, Answer.NAMED)])
def test_a_name_needs_decisive_odds_against_a_fault_of_the_test(odds: float, kind: str) -> None:
    wrong = fault(0.97 / odds)
    ranking = Ranking.of([SURE, OTHER, NOTHING, wrong.contender])
    found = decide(ranking, [finalist(SURE, 0.97)], detected=True, lattice_doubt=False, faults=[wrong])
    assert found.kind == kind
    assert ("the one of the coupons" in found.sentence) == (kind == Answer.AMBIGUOUS)


def test_a_fault_that_leads_leaves_nothing_to_name() -> None:
    wrong, weak = fault(0.99), contender("one", "clamp_slip", probability=0.005)
    ranking = Ranking.of([weak, NOTHING, wrong.contender])
    found = decide(ranking, [finalist(weak, 0.005)], detected=True, lattice_doubt=False, faults=[wrong])
    assert (found.kind, found.effects) == (Answer.UNEXPLAINED, ())
    assert "a fault of the test explains it better" in found.sentence


def test_a_failed_check_takes_the_name_and_says_why() -> None:
    for p_value, kind in ((1e-5, Answer.AMBIGUOUS), (0.1, Answer.NAMED)):
        check = Check("odd_specimen", p_value, "the force of punch_2 is -25.0 % off the others'")
        found = decide(
            Ranking.of([SURE, OTHER, NOTHING]), [replace(finalist(SURE, 0.97))], detected=True, lattice_doubt=False,
            checks=[check],
        )  # fmt: skip
        assert found.kind == kind
        assert ("punch_2" in found.sentence) == (kind == Answer.AMBIGUOUS)
