"""Thicker filaments stretch further before they break, by every criterion: where a stretched loop first fails."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.results.wire_history import WireHistory
from loadcases.judging import break_strain, judge_for, marked_strain
from loadcases.reader import load_case
from loadcases.schema import Case
from loadcases.wire_material import load_wire_material
from wires.failure import CRITERIA
from wires.layout import lay_out


SLACK = 0.02
STEPS = np.linspace(0.0, 0.3, 3001)


def stretched() -> WireHistory:
    """One straight loop with the coupons' slack and span, its fabric strained to 30 % in 3000 steps."""
    layout = lay_out(
        length_mm=60, width_mm=6, wire_spacing_mm=6.0, loop_spacing_mm=60.0, loop_length_mm=4.0, loop_slack=SLACK
    )
    span = np.repeat(STEPS[:, None], layout.n_loops, axis=1)
    return WireHistory(
        displacement_mm=STEPS,
        span_strain=span,
        wire_strain=np.maximum((1.0 + span) / (1.0 + SLACK) - 1.0, 0.0),
        element_wire=np.zeros(0, dtype=np.int64),
        element_warp_mm=np.zeros(0),
        element_strain=np.zeros((len(STEPS), 0)),
        layout=layout,
    )


def case(criterion: str, diameter_mm: float) -> Case:
    overrides = [f"failure.criterion={criterion}", f"wires.filament_diameter={diameter_mm}"]
    return load_case("elbow", overrides=overrides).case


def breaks_at(criterion: str, diameter_mm: float) -> float:
    """The wire's own strain at which the typical loop loses its first filament, seen on the history."""
    judge = judge_for(case(criterion, diameter_mm))
    at = float(judge.criterion.evaluate(stretched(), judge.parameters).first_failure_mm[0])
    return (1.0 + at) / (1.0 + SLACK) - 1.0


@pytest.mark.parametrize("criterion", ["calibrated", "span_strain", "wire_strain"])
def test_the_wire_s_own_strain_at_the_first_break_follows_the_elongation_of_its_filaments(criterion: str) -> None:
    """Elongation at break grows with the diameter to the power of the shipped copper, read from its file."""
    copper = load_wire_material("copper_soft")
    ratio = (0.05 / 0.03) ** copper.elongation_exponent.value
    assert ratio > 1.4
    assert breaks_at(criterion, 0.05) / breaks_at(criterion, 0.03) == pytest.approx(ratio, rel=1e-3)


def test_a_bundle_of_thicker_filaments_breaks_later_though_they_bend_more() -> None:
    """Bending takes d/2 of curvature away, so the gain is less than that of the elongation, but a gain."""
    assert 1.2 < breaks_at("filament_bundle", 0.05) / breaks_at("filament_bundle", 0.03) < 1.6


def test_no_criterion_is_left_out() -> None:
    assert set(CRITERIA) == {"calibrated", "span_strain", "wire_strain", "filament_bundle"}


@pytest.mark.parametrize("criterion", ["calibrated", "wire_strain"])
def test_maps_mark_the_strain_at_which_the_judge_sees_the_break(criterion: str) -> None:
    thick = case(criterion, 0.05)
    judge = judge_for(thick)
    assert marked_strain(thick, judge) == pytest.approx(breaks_at(criterion, 0.05), rel=1e-3)
    assert break_strain(thick, judge) == marked_strain(thick, judge)
    assert marked_strain(case("span_strain", 0.05), judge_for(case("span_strain", 0.05))) is None
