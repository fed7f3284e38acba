"""The diagnosis from measurement to verdict on a simulator of formulas: all stages, refits and both finer lattices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from etextile.diagnose.data.measured import Measurements
from etextile.diagnose.data.observe import PEAKS, Record
from etextile.diagnose.data.punched import PunchForce
from etextile.diagnose.decide.verdict import Answer
from etextile.diagnose.infer.finer_table import depends, on_finer_lattice
from etextile.diagnose.infer.full_table import requests_on, whole
from etextile.diagnose.predict.parameters import BaseParameters, prior_covariance
from etextile.diagnose.predict.run_tables import Candidate
from etextile.diagnose.predict.simulate import Request, Runner
from etextile.diagnose.setting import Setting
from etextile.diagnose.workflow import Diagnosis, diagnose, prepare
from etextile.effects.base import Card, Example, Parameter, Undetermined
from etextile.types import Array


LAW = (100.0, 1.0, 300.0, 1.2)
COARSENING = 20.0
TRAVEL = np.arange(0.5, 40.01, 0.5)
SHAPES: dict[str, Callable[[Array], Array]] = {
    "early": lambda u: 200.0 * (1.0 - np.exp(-u / 5.0)),
    "kink": lambda u: -2.0 * np.maximum(u - 25.0, 0.0) ** 1.5,
    "wave": lambda u: 60.0 * np.sin(u / 6.0) ** 2,
}
"""Change of the force in N by each effect at size one."""


def force(u: Array, sizes: dict[str, float], *, coarsening: float = 0.0, stiffness: float = 300.0) -> Array:
    """Force of a test in N: the base, its lattice error, the effects, and that two of them hinder each other."""
    base = 1.2 * u**2 * stiffness / 300.0 * (1.0 + 0.01 * (coarsening / COARSENING) ** 2)
    changes = [size * SHAPES[name](u) * (1.0 + 0.02 * coarsening / COARSENING) for name, size in sizes.items()]
    hindered = 0.1 * changes[0] * np.tanh(changes[1] / 100.0) if len(changes) == 2 else 0.0
    return np.asarray(base + sum(changes, np.zeros(len(u))) - hindered)


@dataclass
class Formulas:
    """A simulator that knows the answer; `lost`: effects whose runs on the finest lattice find no equilibrium."""

    fingerprint: str = "formulas"
    lost: frozenset[str] = frozenset()
    asked: list[Request] = field(default_factory=list)

    def __call__(self, request: Request) -> Record:
        self.asked.append(request)
        travel = np.linspace(0.0, request.total, request.steps + 1)
        sizes = {item.id: item.parameters[0][1] for item in request.effects}
        values = force(travel, sizes, coarsening=request.coarsening, stiffness=request.laws[0][2])
        x = np.arange(0.0, 5.0) * request.coarsening / COARSENING
        end = len(travel) // 2 if self.lost & set(sizes) and request.coarsening < 0.4 * COARSENING else None
        positions, peaks = np.zeros((len(travel), 5, 5, 3)), np.zeros((len(travel), len(PEAKS)))
        return Record(x, x, (True, True), travel[:end], values[:end], positions[:end], peaks[:end], end is None)


def candidates() -> tuple[Candidate, ...]:
    parameter = Parameter("size", "", 0.0, 2.5, "the size")
    return tuple(Candidate(Card(name, "a toy", (parameter,), Example({"size": 1.0}))) for name in SHAPES)


def diagnosed(
    hidden: Callable[[Array], Array], *, lost: Sequence[str] = (), seed: int = 1, simulator: Formulas | None = None
) -> Diagnosis:
    """Diagnose three specimens with 1 % scatter of their gain and 1 % noise of the largest force."""
    rng = np.random.default_rng(seed)
    truth = hidden(TRAVEL)
    noise = 0.01 * float(truth.max())
    curves = tuple(
        PunchForce(f"{i}.csv", TRAVEL, truth * (1.0 + 0.01 * z) + noise * rng.standard_normal(len(TRAVEL)), noise)
        for i, z in enumerate((-0.7, 0.1, 0.6))
    )
    covariance = np.kron(np.eye(3), 0.01 * prior_covariance(LAW[3]))
    base = BaseParameters((LAW,) * 3, covariance, (0.07,) * 3, ((0.0, 0.12),) * 3, ("test",) * 3)
    setting = Setting(Measurements("test", ".", curves), base, (LAW,) * 3, COARSENING, candidates())
    return diagnose(setting, Runner(simulator or Formulas(lost=frozenset(lost))))


def found(diagnosis: Diagnosis) -> dict[str, tuple[float, float, float]]:
    """Return median and interval of the size of every effect of the best hypothesis."""
    best = diagnosis.finalists[0].contender
    sizes = {}
    for i, name in enumerate(best.ids):
        (axis,) = diagnosis.tables[name].grid.axes
        middle, low, high = (float(axis.to_value(value)) for value in best.evidence.interval(i))
        sizes[name] = (middle, low, high)
    return sizes


def test_nothing_is_found_where_nothing_is_hidden() -> None:
    """The lattice error of the case, 1 % of the force, is no gap."""
    assert diagnosed(lambda u: force(u, {})).verdict.kind is Answer.NO_GAP


@pytest.mark.parametrize("name", ["early", *(pytest.param(n, marks=pytest.mark.slow) for n in SHAPES if n != "early")])
def test_a_single_effect_is_named_with_its_size(name: str) -> None:
    diagnosis = diagnosed(lambda u: force(u, {name: 1.3}))
    assert (diagnosis.verdict.kind, diagnosis.verdict.effects) == (Answer.NAMED, (name,))
    _, low, high = found(diagnosis)[name]
    assert low < 1.3 < high
    assert high - low < 0.8


def test_two_effects_that_hinder_each_other_are_named_with_their_sizes() -> None:
    """The tables superpose effects; that these hinder each other is known from runs of the pair alone."""
    hidden = {"early": 1.2, "kink": 1.5}
    diagnosis = diagnosed(lambda u: force(u, hidden))
    assert diagnosis.verdict.kind is Answer.NAMED
    assert set(diagnosis.verdict.effects) == set(hidden)
    for name, (_, low, high) in found(diagnosis).items():
        assert low < hidden[name] < high


def test_a_cause_that_no_effect_makes_has_no_name() -> None:
    diagnosis = diagnosed(lambda u: force(u, {}) - 150.0 * np.exp(-(((u - 14.0) / 2.5) ** 2)))
    assert diagnosis.verdict.kind is Answer.UNEXPLAINED
    assert diagnosis.verdict.effects == ()


def test_an_effect_that_finds_no_equilibrium_on_the_finest_lattice_is_not_named() -> None:
    diagnosis = diagnosed(lambda u: force(u, {"kink": 1.5}), lost=["kink"])
    assert diagnosis.verdict.kind in (Answer.AMBIGUOUS, Answer.UNEXPLAINED)
    assert not diagnosis.finalists[0].simulated


def test_an_effect_that_cannot_change_the_verdict_is_looked_at_in_few_runs_and_left() -> None:
    """A kink takes away much of the force: the early change is run at two of its four sizes, on no finer lattice."""
    simulator = Formulas()
    diagnosis = diagnosed(lambda u: force(u, {"kink": 2.2}), simulator=simulator)
    assert (diagnosis.verdict.kind, diagnosis.verdict.effects) == (Answer.NAMED, ("kink",))
    sizes = {
        name: {item.effects[0].parameters[0][1] for item in simulator.asked if [e.id for e in item.effects] == [name]}
        for name in SHAPES
    }
    assert len(sizes["early"]) == 2 < len(diagnosis.tables["kink"].grid.axes[0].nodes) - 1 <= len(sizes["kink"])
    assert all(item.coarsening == COARSENING for item in simulator.asked if [e.id for e in item.effects] == ["early"])


def test_whole_tables_take_the_runs_that_are_announced_and_keep_those_of_the_first_look() -> None:
    curve = (PunchForce("1.csv", TRAVEL, force(TRAVEL, {"kink": 1.0}), 1.0),)
    base = BaseParameters(
        (LAW,) * 3, np.kron(np.eye(3), 1e-4 * prior_covariance(LAW[3])), (0.07,) * 3, ((0.0, 0.12),) * 3, ("test",) * 3
    )
    setting = Setting(Measurements("test", ".", curve), base, (LAW,) * 3, COARSENING, candidates())
    runner = Runner(Formulas())
    ready = prepare(setting, runner, lambda stage, text: None)
    announced = runner.missing(requests_on(ready, {"kink": ready.plans["kink"]}, candidates()))
    before = runner.count
    full = whole(ready, ["kink"], candidates(), runner)
    assert runner.count - before == announced == 2
    assert full.few == ready.few - {"kink"}
    for node in ready.tables["kink"].grid.axes[0].nodes:
        assert full.tables["kink"].curve([node]) == pytest.approx(ready.tables["kink"].curve([node]), abs=0.1)


@dataclass
class Folding(Formulas):
    """Formulas whose kink saturates early on finer lattices; its largest size finds no equilibrium there."""

    def __call__(self, request: Request) -> Record:
        found, sizes = super().__call__(request), {item.id: item.parameters[0][1] for item in request.effects}
        if "kink" not in sizes or request.coarsening == COARSENING:
            return found
        bare = super().__call__(replace(request, effects=()))
        change = np.tanh(sizes["kink"]) * SHAPES["kink"](found.displacement)
        completed = sizes["kink"] < 2.4
        end = None if completed else 4
        return replace(
            found, force=(bare.force + change)[:end], displacement=found.displacement[:end],
            positions=found.positions[:end], peaks=found.peaks[:end], completed=completed,
        )  # fmt: skip


def test_a_table_of_an_effect_that_the_lattice_moves_is_made_on_a_finer_one() -> None:
    """It gives the finer lattice's change there, and keeps the coarser one's where the finer has no equilibrium."""
    curve = (PunchForce("1.csv", TRAVEL, force(TRAVEL, {"kink": 1.0}), 1.0),)
    base = BaseParameters(
        (LAW,) * 3, np.kron(np.eye(3), 1e-4 * prior_covariance(LAW[3])), (0.07,) * 3, ((0.0, 0.12),) * 3, ("test",) * 3
    )
    setting = Setting(Measurements("test", ".", curve), base, (LAW,) * 3, COARSENING, candidates())
    runner = Runner(Folding())
    ready = whole(prepare(setting, runner, lambda stage, text: None), ["kink"], candidates(), runner)
    table, candidate = ready.tables["kink"], next(item for item in candidates() if item.card.id == "kink")
    folds = replace(table.grid.card, undetermined=(Undetermined("free_edge", "height", 1.0),))
    moved = replace(table, grid=replace(table.grid, card=folds), doubt=np.eye(len(ready.bench.points)))
    assert depends(moved)
    assert not depends(table)
    found, (axis,) = on_finer_lattice(ready, candidate, moved, runner), table.grid.axes
    assert found.doubt is moved.doubt
    for node in axis.nodes[[1, 2]]:
        size = float(axis.to_value(node))
        expected = np.tanh(size) * SHAPES["kink"](ready.bench.points.displacement)
        assert found.curve([node]) == pytest.approx(expected, abs=0.02 * np.abs(expected).max())
    assert found.curve([axis.nodes[-1]]) == pytest.approx(table.curve([axis.nodes[-1]]))
