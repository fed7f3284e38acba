"""Slack for loops: the inverse of judging them, against the closed form of a loop that straightens first."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.results.wire_history import WireHistory
from etextile.studies import sizing
from etextile.types import Array
from wires.failure import evaluate, judge_of
from wires.layout import lay_out
from wires.sizing import Per, reached, size_loops, surely, with_slack


def history(span: Array, *, component: float = 0.0) -> WireHistory:
    """Loops of 4 mm on one wire, each under its own span strain (L,)."""
    layout = lay_out(
        length_mm=20.0 * len(span),
        width_mm=6,
        wire_spacing_mm=6.0,
        loop_spacing_mm=20.0,
        loop_length_mm=4.0,
        loop_slack=0.0,
        loop_rigid_mm=component,
        loop_offset_mm=10.0 * (len(span) - 1),
    )
    both = np.stack([np.zeros(len(span)), span])
    none = np.zeros(0, dtype=np.int64)
    return WireHistory(np.array([0.0, 1.0]), both, both, none, np.zeros(0), np.zeros((2, 0)), layout)


@pytest.mark.parametrize("component", [0.0, 2.0])
def test_half_the_loops_fail_when_the_slack_leaves_the_onset_in_the_wire(component: float) -> None:
    """Target 1/2 means wire strain = onset: (1 + e - c) / (1 + s - c) = 1.07, c the component's share of the span."""
    span = np.array([0.03, 0.10, 0.20])
    found = size_loops(history(span, component=component), 0.5, judge=judge_of("wire_strain"))
    share = component / 4.0
    needed = np.maximum((1.0 + span - share) / 1.07 + share - 1.0, 0.0)
    assert found.slack == pytest.approx(needed, abs=1e-9)
    assert found.everywhere == pytest.approx(needed.max(), abs=1e-9)


@pytest.mark.parametrize("criterion", ["wire_strain", "filament_bundle"])
def test_loops_of_that_size_meet_the_target_and_shorter_ones_do_not(criterion: str) -> None:
    case = history(np.array([0.01, 0.09, 0.15]))
    found = size_loops(case, 0.01, judge=judge_of(criterion))
    assert found.slack[0] == 0.0
    assert (found.probability <= 0.01).all()
    shorter = evaluate(with_slack(case, np.maximum(found.slack - 1e-3, 0.0)), criterion)
    assert (shorter.failure_probability[1:] > 0.01).all()
    assert (np.diff(found.slack) > 0.0).all()


def test_what_no_slack_can_save_is_said() -> None:
    found = size_loops(history(np.array([0.05, 0.9])), 0.01, judge=judge_of("wire_strain"))
    assert np.isfinite(found.slack[0])
    assert np.isnan(found.slack[1])
    assert np.isnan(found.everywhere)


def test_a_criterion_that_looks_at_the_fabric_alone_cannot_size_loops() -> None:
    with pytest.raises(BadInput, match="does not ask for the slack"):
        size_loops(history(np.array([0.10])), 0.01, judge=judge_of("span_strain"))
    with pytest.raises(BadInput, match="between 0 and 1"):
        size_loops(history(np.array([0.10])), 1.0, judge=judge_of("wire_strain"))


@pytest.mark.parametrize("per", ["garment", "loop"])
def test_the_slack_that_surely_does_keeps_the_upper_end_of_the_interval_and_less_does_not(per: Per) -> None:
    case, judge = history(np.array([0.01, 0.09, 0.15])), judge_of("calibrated")
    by_value = size_loops(case, 0.01, judge=judge, per=per).everywhere
    slack, crimp = surely(case, 0.01, judge=judge, per=per)
    assert slack > by_value + 0.002
    for share, kept in ((0.0, True), (-2e-3, False)):
        event = reached(judge.judge(with_slack(case, slack + share, crimp=crimp)), per)
        assert event.low <= event.value <= event.high
        assert (event.high <= 0.01 * (1.0 + 1e-6)) is kept
        assert event.value < 0.005


def test_a_continuation_under_which_no_slack_is_enough_is_told_in_words() -> None:
    assert sizing._slack_words(0.125) == "12.5 %"
    assert sizing._slack_words(float("nan")) == "none up to 50 %"
