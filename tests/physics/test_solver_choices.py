"""Solvers by name: one answer from all, honest fallbacks, and nothing called converged that is not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from etextile.errors import BadInput, NoEquilibrium, NotPositiveDefinite
from etextile.mechanics.model import Model
from etextile.solve import linear
from etextile.solve.linear import LINEAR_SOLVERS, MixedPardiso, SuperLU, make_linear_solver
from etextile.solve.newton import NewtonOutcome, Settings
from etextile.solve.nonlinear import NONLINEAR_SOLVERS
from etextile.solve.path import Increment, advance
from etextile.solve.pattern import Pattern, lay_out
from etextile.solve.reasons import no_equilibrium
from etextile.solve.system import System
from etextile.types import Array


def last(model: Model, settings: Settings) -> Increment:
    *_, increment = advance(model, settings)
    return increment


@pytest.fixture(params=["band", "pardiso", "superlu"])
def solver(request: pytest.FixtureRequest) -> str:
    if request.param == "pardiso":
        pytest.importorskip("pypardiso")
    return str(request.param)


@pytest.mark.parametrize("name", ["band", "pardiso"])
def test_all_linear_solvers_give_the_same_punch(punch: Callable[..., Model], name: str) -> None:
    if name == "pardiso":
        pytest.importorskip("pypardiso")
    model = punch(coarsening=25.0, travel=(5.0, 10.0))
    one, other = (last(model, Settings(linear=which)) for which in (name, "superlu"))
    assert one.punch_force_N == pytest.approx(other.punch_force_N, rel=1e-6)
    np.testing.assert_allclose(one.positions, other.positions, atol=1e-5)


def test_both_nonlinear_methods_give_the_same_punch(punch: Callable[..., Model]) -> None:
    model = punch(coarsening=25.0, travel=(5.0, 10.0))
    one, other = (last(model, Settings(nonlinear=name)) for name in ("interior", "damped"))
    assert one.punch_force_N == pytest.approx(other.punch_force_N, rel=1e-5)


def test_without_onemkl_superlu_takes_over(punch: Callable[..., Model], monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(*_: Any) -> None:
        raise ImportError("mkl_rt not found")

    monkeypatch.setattr(linear, "Pardiso", missing)
    monkeypatch.setattr(linear, "suits", lambda *_: False)
    model = punch(coarsening=45.0)
    pattern = System(model, linear="superlu").pattern
    assert isinstance(make_linear_solver("auto", pattern, model.points), SuperLU)


def test_a_matrix_that_is_not_positive_definite_is_refused(punch: Callable[..., Model], solver: str) -> None:
    system = System(punch(coarsening=45.0), linear=solver)
    with pytest.raises(NotPositiveDefinite):
        system.factorise(lambda values: values.__setitem__(system.pattern.rows[4], -1.0), identity=1.0)
    system.factorise(lambda values: None, identity=2.0)
    load = np.ones(system.model.points.shape)
    np.testing.assert_allclose(system.solve(load), np.where(system.model.fixed, 0.0, 0.5))


def test_a_band_serves_what_is_small_and_narrow(punch: Callable[..., Model]) -> None:
    """Wider lattices, and a point that is coupled to all others, are cheaper for a sparse solver."""
    assert System(punch(coarsening=25.0)).solver.name == "band"
    assert System(punch(coarsening=4.0)).solver.name != "band"
    star = lay_out(400, [np.stack([np.zeros(399, dtype=int), np.arange(1, 400)], axis=1)])
    assert make_linear_solver("auto", star, np.zeros((400, 3))).name != "band"


def floppy(count: int, stiffness: float) -> tuple[Pattern, Array, Array]:
    """Return a line of `count` nodes tied to their neighbours by 1 N/mm and to the ground by `stiffness` N/mm."""
    pattern = lay_out(count, [np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)])
    upper = np.zeros((3 * count, 3 * count))
    ties = np.diag(np.r_[1.0, np.full(count - 2, 2.0), 1.0]) - np.eye(count, k=1) - np.eye(count, k=-1)
    for axis in range(3):
        upper[axis::3, axis::3] = ties + stiffness * np.eye(count)
    rows = np.repeat(np.arange(3 * count), np.diff(pattern.indptr))
    return pattern, upper, upper[rows, pattern.indices]


def test_single_precision_takes_a_step_and_double_what_single_cannot() -> None:
    """A chain held by a spring 1e-10 as stiff as it is: rounding to single precision loses the spring."""
    pytest.importorskip("pypardiso")
    load = np.random.default_rng(1).normal(size=150)
    for stiffness, low, high in ((1e-2, 1e-9, 1e-4), (1e-10, 0.0, 1e-5)):
        pattern, matrix, values = floppy(50, stiffness)
        solver = MixedPardiso(pattern, np.zeros((50, 3)))
        solver.factorise(values)
        left = np.linalg.norm(matrix @ solver.solve(load) - load) / np.linalg.norm(load)
        assert low < left < high


def test_an_indefinite_matrix_is_refused_in_both_precisions_and_the_next_one_is_solved() -> None:
    pytest.importorskip("pypardiso")
    pattern, matrix, values = floppy(50, 1e-2)
    solver = MixedPardiso(pattern, np.zeros((50, 3)))
    bad = values.copy()
    bad[pattern.rows[7]] = -1.0
    for _ in range(2):
        with pytest.raises(NotPositiveDefinite):
            solver.factorise(bad)
    solver.factorise(values)
    np.testing.assert_allclose(matrix @ solver.solve(np.ones(150)), 1.0, atol=1e-3)


def test_the_punch_is_the_same_in_single_precision(
    punch: Callable[..., Model], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("pypardiso")
    model = punch(coarsening=15.0, travel=(10.0, 20.0))
    double = last(model, Settings(linear="pardiso"))
    monkeypatch.setattr(linear, "MIXED", 0)
    single = last(model, Settings(linear="pardiso"))
    assert single.punch_force_N == pytest.approx(double.punch_force_N, rel=1e-5)
    assert not np.array_equal(single.positions, double.positions)
    np.testing.assert_allclose(single.positions, double.positions, atol=2e-4)


@pytest.mark.parametrize(
    ("registry", "name", "meant"), [(LINEAR_SOLVERS, "pardisso", "pardiso"), (NONLINEAR_SOLVERS, "newtn", "newton")]
)
def test_an_unknown_solver_is_refused_with_the_nearest(registry: Any, name: str, meant: str) -> None:
    with pytest.raises(BadInput, match=f"did you mean '{meant}'"):
        registry[name]


class Gives:
    """A response that bears less the further it is pulled, or carries a load."""

    def __init__(self, giving_way: str = "", load: float | None = None) -> None:
        self.giving_way, self.load = giving_way, load


@pytest.mark.parametrize(
    ("responses", "last_travel", "said"),
    [
        ((Gives(), Gives("3 yarn segments are past the peak force")), 29.0, "past the peak force, so the test is unst"),
        ((Gives(load=0.0),), 0.0, "nothing holds the flat piece against the load"),
        ((Gives(),), 31.0, "on the way back the fabric goes slack"),
        ((Gives(),), 29.0, "at 29 mm. Try more motion.steps"),
    ],
)
def test_a_path_that_ends_says_the_likely_cause(
    punch: Callable[..., Model], responses: tuple[Any, ...], last_travel: float, said: str
) -> None:
    model = punch()
    trial = System(model).evaluate(model.points, 30.0, tuple(part.initial_state() for part in model.contributions))
    outcome = NewtonOutcome(replace(trial, responses=responses), False, "stalled", 3, 1.0, 1e-4)
    assert said in no_equilibrium(model, outcome, last=last_travel, cut_backs=2)


def test_an_increment_that_did_not_converge_is_never_handed_out(punch: Callable[..., Model]) -> None:
    handed: list[Increment] = []
    path = advance(punch(travel=(30.0, 52.5)), Settings(max_iterations=2, max_cut_backs=1))
    with pytest.raises(NoEquilibrium, match=r"no equilibrium at .* mm after 1 cut-backs .*residual .* N, worst at"):
        handed.extend(path)
    assert all(step.verdict.residual_N <= step.verdict.tolerance_N for step in handed)
