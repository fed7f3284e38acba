"""The first look: what fits, what shows beside it and what folds comes into question, the hopeless does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from etextile.diagnose.data.noise import NoiseScatter, SignalShape, WeightedScatter
from etextile.diagnose.data.points import Points, Series, Thinning
from etextile.diagnose.decide.survivors import survivors
from etextile.diagnose.infer.whitened import Workbench
from etextile.diagnose.predict.table import EffectTable, ParameterAxis, ParameterGrid
from etextile.effects.base import Card, Example, Parameter, Undetermined
from etextile.types import Array
from etextile.vocabulary import FORCE


N, NOISE = 60, 0.1
U = np.linspace(0.0, 1.0, N)
EARLY, LATE, MIDDLE = U, U**6, np.sin(np.pi * U)
FORM = np.zeros((N, 1))


def toy(name: str, curve: Array, *, folds: bool = False) -> EffectTable:
    """An effect whose change is its parameter, 0 to 9, times a curve."""
    parameter = Parameter("size", "", 0.0, 9.0, "the size")
    loose = (Undetermined("free_edge", "height", 1.0),) if folds else ()
    card = Card(name, "a toy", (parameter,), Example({"size": 4.0}), undetermined=loose)
    grid = ParameterGrid(card, (ParameterAxis(parameter, np.array([0.0, 9.0]), 0),))
    return EffectTable(grid, curve[:, None], np.array([[0.0, 9.0]]), np.array([True, True]))


def bench_of(residual: Array) -> Workbench:
    nowhere, nothing = np.full(N, np.nan), np.zeros(N)
    points = Points(
        (Series(FORCE, "force", "N", 0, "punch"),), np.zeros(N, dtype=np.int64), 40.0 * U, nowhere, nowhere, residual,
        nowhere,
    )  # fmt: skip
    white = np.full(N, NOISE)
    return Workbench(
        points, Thinning(np.arange(N), np.ones(N)), points, nothing, residual, white, white,
        SignalShape(nothing, nothing, nothing),
        (WeightedScatter(1.0, NoiseScatter(1e-6, 1e-6, 1e-6)),), np.zeros((N, 1)),
        nothing,
    )  # fmt: skip


def test_the_second_of_a_pair_survives_and_an_effect_that_can_do_nothing_of_it_does_not() -> None:
    """Both of the pair are far from explaining it alone; the third only moves the other way."""
    noise = NOISE * np.random.default_rng(0).standard_normal(N)
    tables = {item.id: item for item in (toy("early", EARLY), toy("late", LATE), toy("other", MIDDLE))}
    bench = bench_of(5.0 * EARLY + 3.0 * LATE + noise)
    assert survivors(bench, tables, FORM) == ("early", "late")
    assert survivors(bench_of(5.0 * EARLY + noise), tables, FORM) == ("early",)


def test_an_effect_that_folds_is_kept_where_its_fit_proves_little() -> None:
    residual = 0.5 * EARLY + NOISE * np.random.default_rng(1).standard_normal(N)
    tables = {"early": toy("early", EARLY), "other": toy("other", -MIDDLE)}
    assert survivors(bench_of(residual), tables, FORM) == ("early",)
    tables["other"] = replace(toy("other", -MIDDLE, folds=True))
    assert survivors(bench_of(residual), tables, FORM) == ("early", "other")


def test_what_cannot_be_seen_is_never_run_finer() -> None:
    assert survivors(bench_of(np.zeros(N)), {"faint": toy("faint", 1e-4 * EARLY)}, FORM) == ()


def test_while_the_best_stands_on_few_nodes_it_alone_is_asked_for_and_then_what_is_near_it() -> None:
    """The other is 85 behind: too far with a whole table, not with one on few nodes."""
    noise = NOISE * np.random.default_rng(2).standard_normal(N)
    shape = EARLY + 0.1 * MIDDLE
    tables = {"early": toy("early", shape), "near": toy("near", EARLY + 0.02 * MIDDLE)}
    bench = bench_of(5.0 * shape + noise)
    assert survivors(bench, tables, FORM, few=("early", "near")) == ("early",)
    assert survivors(bench, tables, FORM, few=("near",)) == ("early", "near")
    assert survivors(bench, tables, FORM) == ("early",)


def test_an_effect_that_lost_a_run_is_kept_where_its_fit_proves_little() -> None:
    """Some 250 behind: too far with few nodes, not when one of them was lost."""
    whole = toy("other", -MIDDLE)
    axis = replace(whole.grid.axes[0], nodes=np.array([0.0, 4.0, 9.0]))
    grid = ParameterGrid(whole.grid.card, (axis,))
    sound = EffectTable(grid, whole.basis, np.array([[0.0, 4.0, 9.0]]), np.array([True, True, True]))
    lost = replace(sound, valid=np.array([True, True, False]))
    bench = bench_of(0.5 * EARLY + NOISE * np.random.default_rng(3).standard_normal(N))
    for other, kept in ((sound, ("early",)), (lost, ("early", "other"))):
        assert survivors(bench, {"early": toy("early", EARLY), "other": other}, FORM, few=("other",)) == kept
