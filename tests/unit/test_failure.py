"""The facts of the paper about failing wires, and the arithmetic of loops and wires."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.results.wire_history import WireHistory
from etextile.types import Array
from etextile.vocabulary import INTACT, OPEN, PARTIAL, PLASTIC, STATES
from wires.damage import FailureResult
from wires.failure import evaluate as evaluate_by
from wires.failure import resolve
from wires.history import first_crossing
from wires.layout import Portion, WireLayout, lay_out


def evaluate(
    case: WireHistory, criterion: str = "span_strain", *, parameters: dict[str, float] | None = None
) -> FailureResult:
    """What the paper's own reading says of typical wires, unless another criterion is asked."""
    return evaluate_by(case, criterion, parameters=parameters)


def two_wires(portion: Portion = "whole") -> WireLayout:
    """Two wires of three loops each (half: of a halved and a whole loop each)."""
    return lay_out(
        length_mm=60,
        width_mm=12,
        portion=portion,
        wire_spacing_mm=6.0,
        first_offset_mm=3.0,
        loop_spacing_mm=20.0,
        loop_length_mm=4.0,
        loop_slack=0.02,
    )


def history(span: Array, displacement: Array | None = None, layout: WireLayout | None = None) -> WireHistory:
    """History of the two wires under the given span strains (S, L), wires straight after their slack."""
    layout = layout or two_wires()
    steps = span.shape[0]
    wire = np.maximum((1 + span) / (1 + layout.loop_slack) - 1, 0.0)
    none = np.zeros(0, dtype=np.int64)
    return WireHistory(
        displacement_mm=np.arange(float(steps)) if displacement is None else displacement,
        span_strain=span,
        wire_strain=wire,
        element_wire=none,
        element_warp_mm=np.zeros(0),
        element_strain=np.zeros((steps, 0)),
        layout=layout,
    )


def uniform(strain: float, criterion: str = "span_strain") -> FailureResult:
    """Result when all loops are stretched to one strain."""
    return evaluate(history(np.array([np.zeros(6), np.full(6, strain)])), criterion)


@pytest.mark.parametrize(
    ("strain", "state"), [(0.0, INTACT), (0.015, INTACT), (0.03, PLASTIC), (0.06, PLASTIC), (0.0699, PLASTIC)]
)
def test_wires_are_whole_below_seven_per_cent(strain: float, state: int) -> None:
    result = uniform(strain)
    assert (result.loop_state == state).all()
    assert (result.loop_broken == 0.0).all()
    assert np.isnan(result.first_failure_mm).all()


def test_the_site_at_three_per_cent_certainly_conducts_and_the_one_at_eight_is_broken_in_part() -> None:
    at_three, at_eight = uniform(0.03), uniform(0.08)
    assert at_three.failure_probability.max() < 1e-6
    assert (at_eight.loop_state == PARTIAL).all()
    assert 1 / 7 < at_eight.loop_broken[0] < 4 / 7
    assert at_eight.failure_probability.min() > 0.95
    assert at_eight.open_probability.max() < 0.01


def test_filaments_begin_to_break_at_seven_per_cent_and_all_are_broken_near_thirteen() -> None:
    assert (uniform(0.07).loop_state == PARTIAL).all()
    assert uniform(0.07).failure_probability == pytest.approx(0.5)
    assert (uniform(0.12).loop_state == PARTIAL).all()
    assert (uniform(0.14).loop_state == OPEN).all()


def test_the_mean_filament_breaks_at_the_elongation_of_thin_soft_copper() -> None:
    """9 % is what 41 um wire reaches; the mean of the bundle's law is integral of (1 - share)."""
    strains = np.linspace(0, 0.5, 200_001)
    shares = evaluate(history(np.repeat(strains[:, None], 6, axis=1))).filaments_broken[:, 0]
    mean = np.trapezoid(1.0 - shares, strains)
    assert mean == pytest.approx(0.09, abs=0.006)


def test_the_share_follows_its_weibull_law() -> None:
    parameters = {"onset": 0.05, "scale": 0.02, "shape": 2.0}
    result = evaluate(history(np.array([np.zeros(6), np.full(6, 0.07)])), parameters=parameters)
    assert result.loop_broken == pytest.approx(1 - np.exp(-1.0))


def test_more_filaments_need_more_strain_to_open() -> None:
    span = np.array([np.zeros(6), np.full(6, 0.13)])
    few, many = (evaluate(history(span), parameters={"filaments": n}).loop_state[0] for n in (7, 100))
    assert STATES[few] == "open"
    assert STATES[many] == "partial"


def test_first_failure_is_interpolated_between_steps() -> None:
    span = np.array([0.0, 0.06, 0.10])[:, None] * np.ones(6)
    result = evaluate(history(span, np.array([0.0, 10.0, 20.0])))
    assert result.first_failure_mm == pytest.approx(12.5)


def test_unloading_heals_nothing() -> None:
    span = np.array([0.0, 0.09, 0.0])[:, None] * np.ones(6)
    result = evaluate(history(span, np.array([0.0, 10.0, 0.0])))
    assert (result.loop_state == PARTIAL).all()
    assert result.max_strain == pytest.approx(0.09)
    assert result.first_failure_mm == pytest.approx(10 * 7 / 9)


def test_a_wire_is_as_bad_as_its_worst_loop() -> None:
    span = np.zeros((2, 6))
    span[1] = [0.01, 0.10, 0.03, 0.0, 0.0, 0.04]
    result = evaluate(history(span))
    assert result.wire_state.tolist() == [PARTIAL, PLASTIC]
    assert result.wire_max_strain == pytest.approx([0.10, 0.04])
    assert result.wire_first_failure_mm[0] == pytest.approx(0.7)
    assert np.isnan(result.wire_first_failure_mm[1])


def test_loops_of_a_wire_fail_independently() -> None:
    result = uniform(0.07)
    assert result.wire_failure_probability == pytest.approx(1 - 0.5**3)


def test_half_a_specimen_gives_the_wire_probability_of_the_whole() -> None:
    whole = np.array([np.zeros(6), [0.06, 0.068, 0.06, 0.05, 0.07, 0.05]])
    half = whole[:, [1, 2, 4, 5]]
    expected = evaluate(history(whole)).wire_failure_probability
    assert evaluate(history(half, layout=two_wires("half"))).wire_failure_probability == pytest.approx(expected)


def test_a_wire_without_loops_is_intact() -> None:
    layout = lay_out(
        length_mm=7, width_mm=12, wire_spacing_mm=6.0, loop_spacing_mm=20.0, loop_length_mm=4.0, loop_slack=0.0
    )
    result = evaluate(history(np.zeros((2, 0)), layout=layout))
    assert result.wire_state.tolist() == [INTACT]
    assert result.wire_failure_probability.tolist() == [0.0]
    assert np.isnan(result.wire_first_failure_mm).all()


def test_slack_delays_failure_for_the_wire_strain_but_not_for_the_paper_s_criterion() -> None:
    assert (uniform(0.08, "span_strain").loop_state == PARTIAL).all()
    assert (uniform(0.08, "wire_strain").loop_state == PLASTIC).all()
    # 7 % in the wire after 2 % slack: 1.07 * 1.02 - 1 in the fabric.
    assert (uniform(0.0915, "wire_strain").loop_state == PARTIAL).all()


def test_scatter_of_the_onset_sets_the_probability() -> None:
    span = np.array([np.zeros(6), np.full(6, 0.065)])
    assert evaluate(history(span)).failure_probability == pytest.approx(0.1587, abs=1e-4)
    assert evaluate(history(span), parameters={"scatter": 0.0}).failure_probability.max() == 0.0


def test_open_probability_is_the_mean_over_specimens() -> None:
    """Against sampling of onsets and filaments."""
    rng = np.random.default_rng(7)
    strain, filaments = 0.11, 7
    onsets = rng.normal(0.07, 0.005, 200_000)
    strengths = onsets[:, None] + 0.026 * rng.weibull(1.2, (onsets.size, filaments))
    sampled = (strengths.max(axis=1) < strain).mean()
    assert uniform(strain).open_probability[0] == pytest.approx(sampled, abs=0.004)


def test_wrong_parameters_are_all_named() -> None:
    with pytest.raises(BadInput) as caught:
        resolve("span_strain", {"onse": 0.07, "scale": 0.0, "filaments": float("nan")})
    text = str(caught.value)
    assert "failure.onse: criterion 'span_strain' takes" in text
    assert "did you mean 'onset'?" in text
    assert "failure.scale: must be finite and greater than 0 (got 0)" in text
    assert "failure.filaments" in text
    with pytest.raises(BadInput, match=r"unknown failure criterion 'span_strian'.*did you mean 'span_strain'"):
        resolve("span_strian", {})


def test_history_until_ends_exactly_there() -> None:
    full = history(np.array([0.0, 0.06, 0.10])[:, None] * np.ones(6), np.array([0.0, 10.0, 20.0]))
    part = full.until(15.0)
    assert part.displacement_mm.tolist() == [0.0, 10.0, 15.0]
    assert part.max_span_strain == pytest.approx(0.08)
    assert full.until(20.0).n_steps == 3
    assert full.until(0.0).max_span_strain.max() == 0.0
    assert full.max_wire_strain == pytest.approx(1.10 / 1.02 - 1)


def test_history_refuses_arrays_that_do_not_fit() -> None:
    with pytest.raises(ValueError, match="span_strain has shape"):
        replace(history(np.zeros((2, 6))), span_strain=np.zeros((2, 5)))


def test_first_crossing_handles_start_jump_and_never() -> None:
    values = np.array([[0.5, 0.0, 0.0], [0.6, 0.2, 0.1]])
    crossing = first_crossing(np.array([1.0, 3.0]), values, 0.15)
    assert crossing[0] == 1.0
    assert crossing[1] == pytest.approx(2.5)
    assert np.isnan(crossing[2])
