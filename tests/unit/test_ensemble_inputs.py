"""Distributions of scattered inputs: their ends, moments and where they come from."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.ensemble.inputs import CovarianceScatter, Input, SpanScatter, normal, root
from etextile.ensemble.sample import unit_rows
from etextile.errors import BadInput
from etextile.studies.ensemble.plan import ensemble_case, moved, plan_of
from loadcases.build_wires import wire_layout
from loadcases.fabric import load_fabric
from loadcases.judging import judge_for
from loadcases.reader import load_case, read_case
from loadcases.schema import Case
from wires import dependence


LOW, HIGH = np.array([0.5, 0.6, 0.9]), np.array([2.0, 1.5, 1.2])


def case(*overrides: str) -> Case:
    return load_case("punch", overrides=overrides).case


def test_the_normal_distribution_is_symmetric_and_cut_off() -> None:
    assert normal(0.5, 3.0) == 0.0
    assert normal(0.0, 3.0) == -3.0
    assert normal(1.0, 2.0) == 2.0
    assert normal(0.3, 3.0) == pytest.approx(-normal(0.7, 3.0))


def test_an_input_has_the_standard_deviation_it_states() -> None:
    item = Input("strength", "strength", "", 0.05, "")
    values = [item.value({"strength": unit}) for unit in (np.arange(4000) + 0.5) / 4000]
    assert np.std(values) == pytest.approx(0.05, rel=0.02)  # the cut takes off 1.3 %
    assert np.mean(values) == pytest.approx(0.0, abs=1e-12)


def test_strength_scatters_as_a_run_integrates_over_it() -> None:
    """Normal is its logarithm, as far as the judge of a run reaches, by the deviation that this judge has."""
    for overrides, std in (((), 0.05), (("failure.garment_scatter=0.1",), 0.1)):
        asked = case("failure.criterion=calibrated", *overrides)
        item = next(item for item in plan_of(asked).inputs if item.name == "strength")
        assert (item.std, item.reach) == (std, dependence.REACH)
        assert item.std == judge_for(asked).spread.garment


def test_nets_keep_their_loops_where_a_quarter_becomes_whole() -> None:
    """Wire 0 of the quarter is in the middle, wire 8 of 17 of the whole; its loops are counted from the other end."""
    net = 'wires.nets=[{"name": "a", "wire": 0, "from_loop": 1, "to_loop": 2}]'
    quarter = case("scatter.punch_position=0.4 mm", net)
    whole, _ = ensemble_case(quarter)
    assert whole.wires is not None
    places = []
    for one in (quarter, whole):
        layout = wire_layout(one, load_fabric(one.fabric.set))
        assert layout is not None
        assert one.wires is not None
        (item,) = one.wires.nets
        on = [(layout.loop_wire == item.wire) & (layout.loop_index == k) for k in (item.from_loop, item.to_loop)]
        places.append([(float(layout.loop_warp_mm[k][0]), float(layout.loop_weft_mm[k][0])) for k in on])
    assert np.allclose(places[0], places[1], atol=1e-9)
    assert whole.wires.nets[0].wire == 8


def test_the_span_ends_at_the_estimates_and_has_the_middle_in_the_middle() -> None:
    scatter = SpanScatter(LOW, HIGH)
    assert list(scatter.factors([0.5, 0.1, 0.9]).values()) == [1.0, 1.0, 1.0]
    assert list(scatter.factors([0.0, 0.1, 0.9]).values()) == pytest.approx(LOW)
    assert list(scatter.factors([1.0, 0.1, 0.9]).values()) == pytest.approx(HIGH)


def test_half_the_width_goes_half_of_the_way_in_logarithms() -> None:
    assert SpanScatter(LOW, HIGH, width=0.5).factors([1.0])["E"] == pytest.approx(np.sqrt(2.0))


def test_sampled_laws_have_the_covariance_of_the_file() -> None:
    values = np.array([900.0, 12000.0, 1.7])
    deviations = np.diag([0.0, 600.0, 0.05])
    correlation = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.9], [0.0, 0.9, 1.0]])
    covariance = deviations @ correlation @ deviations
    scatter = CovarianceScatter(values, covariance)
    found = np.array([list(scatter.factors(row[:3]).values()) for row in unit_rows(1024, seed=3)]) * values
    assert np.ptp(found[:, 0]) == 0.0
    assert np.cov(found[:, 1:].T) == pytest.approx(covariance[1:, 1:], rel=0.1)


def test_the_root_of_a_covariance_squares_to_it() -> None:
    covariance = np.array([[4.0, 1.2], [1.2, 1.0]])
    assert root(covariance) @ root(covariance) == pytest.approx(covariance)


def test_the_law_of_every_family_stays_within_low_and_high() -> None:
    plan = plan_of(case())
    middle = load_fabric("estimated_mid")
    for end, name in ((0.0, "estimated_low"), (1.0, "estimated_high")):
        other = load_fabric(name)
        for family, scatter in plan.families.items():
            factors = scatter.factors([end, 0.5, 0.5])
            for parameter in ("E", "H", "n"):
                expected = getattr(getattr(other, family), parameter).value
                value = getattr(getattr(middle, family), parameter).value * factors[parameter]
                assert value == pytest.approx(expected)


def test_an_identified_fabric_scatters_by_its_covariance() -> None:
    plan = plan_of(case("fabric.set=nylon_woven", "wires.filaments=1", "wires.filament_diameter=0.01"))
    warp = plan.families["warp"]
    assert isinstance(warp, CovarianceScatter)
    stated = load_fabric("nylon_woven").warp.covariance
    assert stated is not None
    assert stated.parameters == ("H", "n")
    assert warp.covariance[1:, 1:] == pytest.approx(np.array(stated.matrix))
    assert warp.covariance[0, 0] == 0.0  # E was not identified there


def test_a_factor_of_zero_leaves_the_fabric_alone() -> None:
    assert plan_of(case("scatter.fabric=0")).families == {}


def test_a_quarter_keeps_its_symmetry_and_says_so() -> None:
    plan = plan_of(case())
    assert {item.name for item in plan.inputs} == {"strength", "mounting"}
    assert "fabric.portion=whole" in plan.notes[0]


def test_a_whole_specimen_scatters_in_place_but_a_ball_does_not_turn() -> None:
    names = {item.name for item in plan_of(case("fabric.portion=whole")).inputs}
    assert names == {"strength", "mounting", "wire_offset", "loop_offset", "punch_x", "punch_y"}


def test_an_elbow_turns() -> None:
    names = {item.name for item in plan_of(load_case("elbow").case).inputs}
    assert {"tilt_x", "tilt_y", "tilt_z"} <= names


def test_asking_for_places_makes_the_specimen_whole() -> None:
    asked = case("scatter.punch_position=0.4 mm")
    whole, notes = ensemble_case(asked)
    assert whole.fabric.portion == "whole"
    assert "punch_position" in notes[0]
    assert ensemble_case(case())[0].fabric.portion == "quarter"


def test_a_case_without_wires_is_refused() -> None:
    with pytest.raises(BadInput, match="no wires"):
        ensemble_case(case("wires=null"))


def test_the_comb_is_never_shifted_so_far_that_a_wire_is_lost() -> None:
    # the outermost wires of 17 stand 2.7 mm from the edge
    plan = plan_of(case("fabric.portion=whole", "scatter.wire_offset=2 mm"))
    shift = next(item for item in plan.inputs if item.name == "wire_offset")
    assert shift.reach * shift.std < 2.73
    assert any("cut off" in note for note in plan.notes)


def test_moves_add_to_what_the_case_says() -> None:
    start = case("fabric.portion=whole", "wires.first_offset=1", "body.position=[2, 0]")
    found = moved(start, {"wire_offset": 0.25, "loop_offset": -0.5, "punch_x": 0.5, "punch_y": -0.5})
    assert found.wires is not None
    assert found.wires.loops is not None
    assert found.body is not None
    assert found.wires.first_offset == 1.25
    assert found.wires.loops.offset == -0.5
    assert found.body.position == (2.5, -0.5)
    assert moved(start, {"strength": 0.1}) is start


def test_the_scatter_section_is_read_with_units_and_checked() -> None:
    assert case("scatter.punch_angle=0.5 deg", "scatter.loop_slack=10 %").scatter.loop_slack == pytest.approx(0.1)
    with pytest.raises(BadInput, match=r"scatter\.mounting"):
        case("scatter.mounting=0.2")
    with pytest.raises(BadInput, match="did you mean 'strength'"):
        read_case(
            "schema_version: 1\ntitle: a\nfabric: {size: [10, 10]}\nmotion: {total: 1, steps: 1, target: x_max}\n"
            "scatter: {strenght: 0.1}\n"
        )
