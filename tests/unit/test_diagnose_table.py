"""Tables of effects: neutral stays nothing, interpolation is close between nodes, runs that broke off are left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.diagnose.predict.run_tables import Candidate
from etextile.diagnose.predict.table import ParameterAxis, ParameterGrid, axes_of, axis_of, tabulate
from etextile.effects.base import Parameter
from etextile.effects.registry import EFFECTS
from etextile.studies.diagnose.setting import searched_in
from loadcases.reader import load_case


U = np.linspace(0.0, 1.0, 25)


def change(values: dict[str, float]) -> np.ndarray:
    """A smooth, curved answer: a hinge-like growth from an onset on, saturating with size."""
    return np.tanh(1.5 * values["size"]) * np.logaddexp(0.0, (U - values["onset"]) / 0.15)


def grid_of(example: float = 0.5) -> ParameterGrid:
    size = Parameter("size", "", -2.0, 2.0, "how much")
    onset = Parameter("onset", "", 0.1, 0.6, "from when on", neutral=None, default=0.2)
    card = EFFECTS["yarn_tail"].card
    return ParameterGrid(card, (axis_of(size, example, first=True), axis_of(onset, 0.0, first=False)))


def table_of(grid: ParameterGrid, *, broken: int | None = None):
    curves = {}
    for number, (index, _) in enumerate(grid.nodes()):
        at = [axis.to_value(axis.nodes[i]) for axis, i in zip(grid.axes, index, strict=True)]
        curves[index] = change({"size": float(at[0]), "onset": float(at[1])})
        if number == broken:
            curves[index] = np.full_like(U, np.nan)
    return tabulate(grid, curves, np.full_like(U, 0.01))


def test_interpolation_between_nodes_is_within_a_twentieth_of_the_change() -> None:
    grid = grid_of()
    table = table_of(grid)
    rng = np.random.default_rng(0)
    for _ in range(20):
        size, onset = rng.uniform(-1.5, 1.5), rng.uniform(0.12, 0.4)
        at = [float(grid.axes[0].to_coordinate(size)), float(grid.axes[1].to_coordinate(onset))]
        exact = change({"size": size, "onset": onset})
        assert np.abs(table.curve(at) - exact).max() < 0.05 * np.abs(change({"size": 1.5, "onset": 0.12})).max()


def test_the_neutral_value_changes_nothing_and_needs_no_run() -> None:
    grid = grid_of()
    zero = grid.axes[0].neutral
    assert all(index[0] != zero for index, _ in grid.nodes())
    assert np.abs(table_of(grid).curve([0.0, 0.3])).max() < 1e-12


def test_parameters_near_a_run_that_broke_off_are_not_usable() -> None:
    grid = grid_of()
    table = table_of(grid, broken=0)
    index, _ = grid.nodes()[0]
    at = np.array([[axis.nodes[i] for axis, i in zip(grid.axes, index, strict=True)]])
    assert not table.coefficients(at)[1][0]
    assert table.coefficients(np.array([[0.0, 0.3]]))[1][0]


def test_a_corrected_table_gives_the_simulated_change_and_nothing_stays_nothing() -> None:
    grid = grid_of()
    table = table_of(grid)
    at = [0.7, 0.3]
    wanted = table.curve(at) + 0.2 * np.sin(6.0 * U)
    corrected = table.corrected(np.array(at), wanted)
    np.testing.assert_allclose(corrected.curve(at), wanted, atol=1e-12)
    assert np.abs(corrected.curve([0.0, 0.3])).max() < 1e-12


@pytest.mark.parametrize("name", list(EFFECTS))
def test_every_effect_of_the_library_has_a_grid_within_its_physical_range(name: str) -> None:
    """Coordinates go to values and back, nodes stay in range, at most 35 runs per effect."""
    grid = ParameterGrid(EFFECTS[name].card, axes_of(EFFECTS[name].card))
    nodes = grid.nodes()
    assert 3 <= len(nodes) <= 35
    for _, values in nodes:
        for item in EFFECTS[name].card.parameters:
            assert item.allows(values[item.name])
    for axis in grid.axes:
        assert np.all(np.diff(axis.nodes) > 0.0)
        np.testing.assert_allclose(axis.to_coordinate(axis.to_value(axis.nodes)), axis.nodes, atol=1e-9)


def test_a_refined_axis_passes_through_the_point_and_keeps_its_neutral_node() -> None:
    axis = grid_of().axes[0]
    finer = axis.refined(0.4321)
    assert 0.4321 in finer.nodes
    assert finer.neutral is not None
    assert finer.nodes[finer.neutral] == 0.0
    assert isinstance(axis.refined(float(axis.nodes[0])), ParameterAxis)
    assert len(axis.refined(float(axis.nodes[0])).nodes) == len(axis.nodes)


def test_a_run_that_broke_off_leaves_the_cells_it_is_no_corner_of() -> None:
    """Beside a lost node the interpolation is linear, not impossible."""
    grid = grid_of()
    whole, table = table_of(grid), table_of(grid, broken=0)
    sizes, onsets = (axis.nodes for axis in grid.axes)
    at = np.array([[0.5 * (sizes[1] + sizes[2]), 0.5 * (onsets[1] + onsets[2])]])
    amplitudes, usable = table.coefficients(at)
    assert usable.all()
    exact = whole.curve(at[0])
    assert table.basis @ amplitudes[0] == pytest.approx(exact, abs=0.15 * np.abs(exact).max())


def test_a_correction_is_taken_over_by_its_share() -> None:
    grid = grid_of()
    table = table_of(grid)
    at = [float(grid.axes[0].to_coordinate(0.8)), 0.3]
    curve, other = table.curve(at), table.curve(at) + 0.1
    assert table.corrected(at, other).curve(at) == pytest.approx(other)
    assert table.corrected(at, other, share=0.25).curve(at) == pytest.approx(0.75 * curve + 0.25 * other)


def test_between_two_forms_the_change_is_shared_and_no_run_is_added() -> None:
    """Of a form both ends are simulated; a third of the way between them the change is two thirds and one third."""
    form = axis_of(Parameter("form", "", 0.0, 1.0, "how", neutral=None, default=0.0, form=True), 0.0, first=False)
    grid = ParameterGrid(
        EFFECTS["pretension"].card, (axis_of(Parameter("size", "", 0.0, 1.0, ""), 0.5, first=True), form)
    )
    curves = {index: np.full(5, 1.0 + index[1]) for index, _ in grid.nodes()}
    table = tabulate(grid, curves, np.full(5, 0.01))
    assert table.curve([grid.axes[0].nodes[-1], 1.0 / 3.0]) == pytest.approx(np.full(5, 4.0 / 3.0))
    assert form.refined(0.4) is form


@pytest.mark.parametrize(("proportional", "least", "most"), [(0.003, 0.0, 0.1), (None, 0.3, 1.0)])
def test_a_change_that_a_small_size_does_most_of_is_met_between_its_nodes(
    proportional: float | None, least: float, most: float
) -> None:
    """log(1 + size / 0.003) at 0.01, as little compression does it to a free edge: off by a third without the hint."""
    size = Parameter("ratio", "", 0.0, 0.3, "how much", proportional=proportional)
    card = EFFECTS["compression_carry"].card
    (axis,) = axes_of(replace(card, parameters=(size,)))
    grid = ParameterGrid(replace(card, parameters=(size,)), (axis,))
    curves = {index: np.full(5, np.log1p(values["ratio"] / 0.003)) for index, values in grid.nodes()}
    found = tabulate(grid, curves, np.full(5, 0.01)).curve([float(axis.to_coordinate(0.01))])
    assert least < np.abs(found / np.log1p(0.01 / 0.003) - 1.0).max() < most


@pytest.mark.parametrize("size", [-0.2, 0.03, 0.1, 0.3])
def test_an_effect_that_answers_otherwise_on_either_side_of_nothing_is_met_beside_nothing(size: float) -> None:
    """A taut specimen is stiffer at once, a slack one hardly softer: a kink at the neutral value, as pretension has."""

    def answer(value: float) -> np.ndarray:
        return (np.tanh(value) if value > 0.0 else 0.1 * value) * U

    axis = axis_of(Parameter("size", "", -2.0, 2.0, "how much"), 0.5, first=True)
    grid = ParameterGrid(replace(EFFECTS["pretension"].card, parameters=(axis.parameter,)), (axis,))
    table = tabulate(grid, {index: answer(values["size"]) for index, values in grid.nodes()}, np.full_like(U, 0.01))
    found = table.curve([float(axis.to_coordinate(size))])
    assert found == pytest.approx(answer(size), rel=0.1)


def test_a_choice_has_two_forms_and_nothing_between() -> None:
    choice = axis_of(Parameter("film", "", 0.0, 1.0, "", neutral=None, default=0.0, choice=True), 0.0, first=False)
    np.testing.assert_array_equal(choice.weights(np.array([0.0, 0.49, 0.51, 1.0])), [[1, 0], [1, 0], [0, 1], [0, 1]])
    np.testing.assert_array_equal(choice.to_value(np.array([0.2, 0.8])), [0.0, 1.0])
    assert choice.refined(0.4) is choice


def test_slip_in_a_film_is_searched_where_yarns_are_cut_at_both_edges() -> None:
    """Off the yarns the elastic slip and the film are searched, along them the limit of slip alone."""
    candidate = Candidate(EFFECTS["yarn_sliding"].card)
    for case, axes in (("nylon_30", ["compliance", "film"]), ("punch", ["limit"])):
        card = searched_in(load_case(case).case, candidate).card
        assert [axis.parameter.name for axis in axes_of(card)] == axes
        assert {item.name for item in card.parameters} == {"limit", "compliance", "film"}
    card = searched_in(load_case("nylon_30").case, candidate).card
    grid = ParameterGrid(card, axes_of(card))
    for _, parameters in grid.nodes():
        EFFECTS["yarn_sliding"](**parameters)
        assert parameters["film"] in (0.0, 1.0)
        assert parameters["limit"] == 0.0
