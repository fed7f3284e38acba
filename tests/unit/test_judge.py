"""The judge against numpy of its own: calibration on the paper's facts, weakest link, shared scatter, true counts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.results.wire_history import WireHistory
from etextile.types import Array
from etextile.vocabulary import INTACT, OPEN, PARTIAL, PLASTIC, STATES
from wires.coupon import stretched
from wires.criteria.calibrated import PARAMETERS, own_onset, woven_onset
from wires.dependence import LogGrid, Spread, Survival
from wires.failure import evaluate, judge_of, resolve
from wires.layout import lay_out
from wires.sizing import NetStretch, size_loops
from wires.weakest_link import BreakLaw, on_gauge
from wires.woven import WovenPieces


def history(
    span: Array, woven: float = 0.0, *, loop_mm: float = 4.0, slack: float = 0.02, cells: int = 4
) -> WireHistory:
    """Wires with the span strains (W, 3) at their three loops, woven evenly strained by `woven`, cut into cells."""
    wires = len(span)
    layout = lay_out(
        length_mm=340,
        width_mm=10.0 * wires,
        wire_spacing_mm=10.0,
        first_offset_mm=5.0 * (1 - wires % 2),
        loop_spacing_mm=100.0,
        loop_length_mm=loop_mm,
        loop_slack=slack,
    )
    assert layout.n_loops == 3 * wires
    wire, middle = [], []
    for one in range(wires):
        own = layout.loop_wire == one
        ends = zip(
            np.append(layout.start_mm[one], layout.loop_entry_mm[own]),
            np.append(layout.loop_exit_mm[own], layout.end_mm[one]),
            strict=True,
        )
        for start, end in ends:
            edges = np.linspace(start, end, cells + 1)
            middle.append(0.5 * (edges[1:] + edges[:-1]))
            wire += [one] * cells
    final = np.ravel(span)
    both = np.stack([np.zeros_like(final), final])
    elements = np.stack([np.zeros(len(wire)), np.full(len(wire), woven)])
    return WireHistory(
        displacement_mm=np.array([0.0, 1.0]),
        span_strain=both,
        wire_strain=np.maximum((1.0 + both) / (1.0 + slack) - 1.0, 0.0),
        element_wire=np.array(wire, dtype=np.int64),
        element_warp_mm=np.concatenate(middle),
        element_strain=elements,
        layout=layout,
    )


SHARP = {
    "coupon_slack_std": 0.0, "coupon_crimp_std": 0.0, "stress_raiser_std": 0.0, "garment_scatter": 0.0,
    "wire_scatter": 0.0,
}  # fmt: skip


def test_the_onsets_are_those_of_the_coupons() -> None:
    values = resolve("calibrated", {})
    assert own_onset(values) == pytest.approx(0.05 / 1.02)
    assert woven_onset(values) == pytest.approx(1.37 * 0.05 / 1.02)
    more = resolve("calibrated", {"coupon_slack": 0.03})
    assert own_onset(more) == pytest.approx(0.04 / 1.03)
    with pytest.raises(BadInput, match=r"failure.coupon_slack: must be below the onset 0.07 of the coupons"):
        resolve("calibrated", {"coupon_slack": 0.08})


@pytest.mark.parametrize("slack", [0.0, 0.01, 0.02, 0.03])
def test_coupon_loops_lose_their_first_filament_at_seven_per_cent_whatever_their_slack(slack: float) -> None:
    at = {"coupon_slack": slack, "coupon_crimp": slack}
    layout = history(np.zeros((1, 3)), slack=slack)
    strain = np.full((2, 3), 0.07) * np.array([[0.0], [1.0]])
    case = replace(layout, span_strain=strain, wire_strain=np.maximum((1.0 + strain) / (1.0 + slack) - 1.0, 0.0))
    found = evaluate(case, parameters=at)
    assert found.failure_probability == pytest.approx(0.5, abs=1e-12)
    assert found.first_failure_mm == pytest.approx(1.0)


def test_two_and_six_per_cent_break_nothing_seven_the_first_filaments_eight_a_part() -> None:
    found = stretched(np.array([0.02, 0.06, 0.07, 0.08]), "calibrated")
    assert [STATES[k] for k in found.loop_state] == ["plastic" if e > 0.021 else "intact" for e in (0.02, 0.06)] + [
        "partial",
        "partial",
    ]
    assert found.failure_probability[:2].max() < 0.05
    assert found.failure_probability[2] == pytest.approx(0.5, abs=0.03)
    assert 1 / 7 < found.loop_broken[3] < 4 / 7
    assert found.open_probability[3] < 0.02


def test_breaks_come_at_the_loops_first() -> None:
    for strain in (0.06, 0.07, 0.08):
        found = stretched(np.array([strain]), "calibrated")
        assert found.woven is not None
        assert found.woven.failure_probability.max() < 0.35 * found.failure_probability[0]


def test_the_wire_in_the_weave_breaks_too() -> None:
    """At 12.5 % of its own strain it is broken for certain, with loops that hardly stretch."""
    found = judge_of().judge(history(np.full((1, 3), 0.03), 0.125))
    assert found.woven is not None
    assert found.failure_probability.max() < 1e-3
    assert found.woven.failure_probability.min() > 0.999
    assert found.wire_state.tolist() == [OPEN]
    assert found.wire_failure_probability[0] > 0.999
    assert found.wire_max_strain[0] == pytest.approx(0.125)


def test_a_wire_is_plastic_where_its_weave_flows_though_its_loops_are_slack() -> None:
    """At 0.05 % of the weave it is elastic; `span_strain` does not look there."""
    slack = np.full((1, 3), 0.03)
    found = [judge_of().judge(history(slack, woven, slack=0.085)) for woven in (0.0005, 0.03)]
    assert [int(one.wire_state[0]) for one in found] == [INTACT, PLASTIC]
    assert found[1].loop_state.tolist() == [INTACT] * 3
    assert judge_of("span_strain").judge(history(slack, 0.03, slack=0.085)).wire_state.tolist() == [INTACT]


def test_pieces_do_not_depend_on_how_the_lattice_cuts_them() -> None:
    coarse, fine = (judge_of().judge(history(np.full((1, 3), 0.03), 0.05, cells=n)) for n in (2, 40))
    assert coarse.woven is not None
    assert fine.woven is not None
    assert fine.woven.failure_probability == pytest.approx(coarse.woven.failure_probability, rel=1e-9)
    mean = WovenPieces.of(history(np.zeros((1, 3)), cells=2)).mean(np.array([[0.02, 0.06] * 4]), 15.0)
    assert mean == pytest.approx((0.5 * (0.02**15 + 0.06**15)) ** (1 / 15))


@pytest.mark.parametrize("exponent", [0.0, 1.0, 2.28])
def test_longer_loops_break_earlier_by_the_weakest_link(exponent: float) -> None:
    """1 - (1 - p)^(n) of links as long as the reference; with the exponent 0 no length counts."""
    p = {
        mm: judge_of("calibrated", {**SHARP, "length_exponent": exponent})
        .judge(history(np.full((1, 3), 0.055), loop_mm=mm))
        .failure_probability[0]
        for mm in (4.0, 16.0, 64.0)
    }
    for mm in (16.0, 64.0):
        assert p[mm] == pytest.approx(1.0 - (1.0 - p[4.0]) ** ((mm / 4.0) ** exponent), rel=1e-9)


def test_an_elongation_measured_on_a_long_gauge_is_larger_on_a_short_one() -> None:
    assert on_gauge(0.07, measured_mm=200.0, gauge_mm=4.0, shape=15.0) == pytest.approx(0.07 * 50 ** (1 / 15))


def test_chances_of_opening_against_sampled_bundles() -> None:
    rng = np.random.default_rng(4)
    law = BreakLaw(15.0, 0.52, 1.2, 7)
    first = (rng.exponential(size=(200_000, 1)) / np.log(2.0)) ** (1 / 15)
    for ratio in (1.3, 1.8, 2.4):
        share = -np.expm1(-((np.maximum(ratio / first - 1.0, 0.0) / 0.52) ** 1.2))
        broken = rng.random((200_000, 7)) < share
        assert law.opened(np.array(ratio)) == pytest.approx(broken.all(axis=1).mean(), abs=0.004)
        assert law.share(np.array(ratio)) == pytest.approx(broken.mean(), abs=0.003)


def test_what_is_shared_against_sampled_garments() -> None:
    """Three parts of scatter: sampled garments give the same chances of wires, of any wire, and the same range."""
    spread = {"garment_scatter": 0.08, "wire_scatter": 0.05, **{k: 0.0 for k in SHARP if k.endswith("std")}}
    case = history(np.array([[0.058, 0.062, 0.05], [0.066, 0.05, 0.05], [0.05, 0.055, 0.06]]), 0.04)
    found = judge_of("calibrated", spread).judge(case)
    assert found.woven is not None
    assert found.reliability is not None
    rng = np.random.default_rng(11)
    n = 100_000
    shared = 0.08 * rng.standard_normal((n, 1)) + 0.05 * rng.standard_normal((n, 3))
    own = case.wire_strain[-1].reshape(3, 3)[None] / (0.05 / 1.02) / np.exp(shared)[..., None]
    length = found.woven.pieces.length_mm.reshape(3, 4) / 4.0
    woven = (0.04 / (1.37 * 0.05 / 1.02) / np.exp(shared))[..., None]
    hazard = np.log(2.0) * ((own**15).sum(axis=2) + (length * woven**15).sum(axis=2))
    lost = rng.random((n, 3)) < -np.expm1(-hazard)
    garment = found.reliability.garment("broken")
    assert found.wire_failure_probability == pytest.approx(lost.mean(axis=0), abs=0.006)
    assert garment.anything.value == pytest.approx(lost.any(axis=1).mean(), abs=0.006)
    assert garment.expected.value == pytest.approx(lost.sum(axis=1).mean(), abs=0.012)
    assert garment.counts == pytest.approx(np.bincount(lost.sum(axis=1), minlength=4) / n, abs=0.006)
    independent = 1.0 - np.prod(1.0 - found.wire_failure_probability)
    assert garment.anything.value < independent - 0.03


def test_doubt_about_the_coupons_widens_intervals_and_is_no_scatter() -> None:
    case = history(np.full((1, 3), 0.06), 0.03)
    sure = judge_of("calibrated", {"coupon_slack_std": 0.0, "coupon_crimp_std": 0.0, "stress_raiser_std": 0.0})
    known, doubted = (judge.judge(case).reliability for judge in (sure, judge_of()))
    assert known is not None
    assert doubted is not None
    event = known.garment("broken").anything
    assert event.low == pytest.approx(event.value)
    assert event.high == pytest.approx(event.value)
    wide = doubted.garment("broken").anything
    assert wide.low < event.value < wide.high
    assert wide.high - wide.low > 0.2
    values = {item.name: item.default for item in PARAMETERS}
    step = own_onset({**values, "coupon_slack": 0.021}) / own_onset({**values, "coupon_slack": 0.019})
    assert doubted.spread.loops == pytest.approx(-np.log(step) / 0.002 * 0.005, rel=1e-3)


@pytest.mark.parametrize("strain", [0.05, 0.06, 0.065])
def test_interval_ends_where_the_doubt_is_at_its_quantiles(strain: float) -> None:
    """Of one loop whose onset alone is in doubt the ends are the chance at an onset 1.96 deviations higher, lower."""
    alone = {"garment_scatter": 0.0, "wire_scatter": 0.0}
    found = judge_of("calibrated", alone).judge(history(np.full((1, 3), strain)))
    assert found.reliability is not None
    event, doubt = found.reliability.loop(0), found.reliability.spread.loops
    ratio = ((1.0 + strain) / 1.02 - 1.0) / (1.07 / 1.02 - 1.0)
    low, high = (-np.expm1(-np.log(2.0) * (ratio * np.exp(1.959964 * s * doubt)) ** 15) for s in (-1, 1))
    assert event.low == pytest.approx(low, rel=0.01)
    assert event.high == pytest.approx(high, rel=0.01)


def test_states_follow_from_probabilities() -> None:
    """No wire is called whole that is broken with 5 %, none conducting that is open with 50 %, by any criterion."""
    for name in ("calibrated", "span_strain", "wire_strain", "filament_bundle"):
        for strain in np.linspace(0.04, 0.2, 30):
            found = judge_of(name).judge(history(np.full((2, 3), strain), strain / 3))
            for state, broken, opened in (
                *zip(found.wire_state, found.wire_failure_probability, found.wire_open_probability, strict=True),
                *zip(found.loop_state, found.failure_probability, found.open_probability, strict=True),
            ):
                assert (state <= PLASTIC) == (broken < 0.05)
                assert (state == OPEN) == (opened >= 0.5)
                assert state >= PARTIAL or broken < 0.05


def test_the_grid_is_exact_for_a_smooth_function() -> None:
    """E[exp(z)] over a normal z is exp(s^2 / 2)."""
    grid = Spread(0.05, 0.03, 0.1, 0.1).grid
    assert grid.full(0.05) @ grid.factors == pytest.approx(np.exp(0.05**2 / 2), rel=1e-6)
    assert Spread().grid == LogGrid(0, 0.02)
    alone = Survival(np.array([[0.7]]), np.array([[0.9]]), LogGrid(0, 0.02), Spread())
    assert alone.of_wires() == pytest.approx([1 - 0.63])
    assert alone.garment(np.array([2])).anything.value == pytest.approx(1 - 0.63**2)


@pytest.mark.parametrize("per", ["garment", "net", "loop"])
def test_sizes_keep_the_target_of_what_it_is_for(per: str) -> None:
    case = history(np.array([[0.15, 0.12, 0.08], [0.10, 0.03, 0.09]]), 0.10)
    nets = (NetStretch(0, -100.0, 100.0), NetStretch(1, -100.0, 0.0))
    judge = judge_of()
    found = size_loops(case, 0.01, judge=judge, per=per, nets=nets, crimp=0.02)  # type: ignore[arg-type]
    assert found.crimp > 0.04
    assert found.reached_now > 0.99
    assert 0.005 < found.reached <= 0.01
    looser = size_loops(case, 0.1, judge=judge, per=per, nets=nets, crimp=0.02)  # type: ignore[arg-type]
    assert looser.everywhere < found.everywhere


def test_a_target_of_the_garment_asks_for_more_than_one_of_a_loop() -> None:
    case = history(np.array([[0.15, 0.15, 0.15], [0.15, 0.15, 0.15]]), 0.03)
    loop, garment = (size_loops(case, 0.01, judge=judge_of(), per=per, crimp=0.02) for per in ("loop", "garment"))
    assert garment.everywhere > loop.everywhere


def test_slack_where_the_probability_does_not_fall_with_it() -> None:
    """Bending grows with slack: the least slack that is enough is found, though more would not do."""
    case = history(np.full((1, 3), 0.10))
    judge = judge_of("filament_bundle")
    found = size_loops(case, 0.01, judge=judge)

    def at(slack: float) -> float:
        return float(judge.judge(history(np.full((1, 3), 0.10), slack=slack)).failure_probability.max())

    assert at(found.everywhere) <= 0.01 < at(found.everywhere - 0.002)


def test_thicker_filaments_stand_more() -> None:
    case = history(np.full((1, 3), 0.07))
    thin, thick = (judge_of("calibrated", {"strength_factor": f}).judge(case) for f in (1.0, 1.437))
    assert thick.failure_probability.max() < 0.05 < thin.failure_probability.min()
    own = [evaluate(case, "wire_strain", parameters={"strength_factor": f}).failure_probability[0] for f in (0.7, 1.0)]
    assert own[0] > own[1]


def test_wires_of_different_crimp_are_sized_together() -> None:
    """Under one fabric strain the wire with less crimp asks for as much as if all had as little."""
    fabric, crimps = 0.12, np.array([0.02, 0.30])
    case = history(np.full((2, 3), 0.10), 0.0)
    own = np.maximum((1.0 + fabric) / (1.0 + crimps) - 1.0, 0.0)
    alike, mixed = (
        replace(case, element_strain=np.stack([0.0 * strain, strain])[:, case.element_wire])
        for strain in (np.full(2, own[0]), own)
    )
    together = size_loops(alike, 0.01, judge=judge_of(), crimp=0.02)
    apart = size_loops(mixed, 0.01, judge=judge_of(), crimp=crimps)
    assert together.crimp > 0.03
    assert apart.crimp == pytest.approx(together.crimp, rel=1e-6)
