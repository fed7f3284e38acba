"""Held-out scores on a toy: the effect that made the data closes what it has not seen, another one does not."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.diagnose.data.noise import NoiseScatter, SignalShape, WeightedScatter
from etextile.diagnose.data.points import Points, Series, Thinning
from etextile.diagnose.decide.heldout import hold_out, split_at
from etextile.diagnose.infer.whitened import Workbench
from etextile.diagnose.predict.table import EffectTable, ParameterAxis, ParameterGrid
from etextile.effects.base import Card, Example, Parameter
from etextile.vocabulary import FORCE


U = np.linspace(1.0, 40.0, 40)


def effect(name: str, direction: np.ndarray) -> EffectTable:
    parameter = Parameter("size", "", -4.0, 4.0, "the size")
    axis = ParameterAxis(parameter, np.array([-4.0, 4.0]), None)
    card = Card(name, "a toy", (parameter,), Example({"size": 1.0}))
    return EffectTable(
        ParameterGrid(card, (axis,)), direction[:, None], np.array([[-4.0, 4.0]]), np.array([True, True])
    )


def bench(residual: np.ndarray) -> Workbench:
    """Force of one specimen: 100 N at 40 mm, noise 1 N."""
    count = len(U)
    nowhere = np.full(count, np.nan)
    series = (Series(FORCE, "force", "N", 0, "punch_1"),)
    points = Points(series, np.zeros(count, dtype=np.int64), U, nowhere, nowhere, 2.5 * U + residual, nowhere)
    bins = Thinning(np.arange(count), np.ones(count))
    shape = SignalShape(2.5 * U, np.full(count, 2.5), 2.5 * U)
    scatters = (WeightedScatter(1.0, NoiseScatter(1e-4, 1e-4, 1e-4)),)
    return Workbench(
        points, bins, points, 2.5 * U, residual, np.ones(count), np.ones(count), shape, scatters, np.zeros((count, 1)),
        np.zeros(count),
    )  # fmt: skip


def test_the_true_effect_predicts_the_displacements_it_was_not_fitted_to() -> None:
    rng = np.random.default_rng(0)
    growth = np.maximum(U - 10.0, 0.0)
    found = hold_out(
        bench(growth + rng.normal(size=40)), (effect("true", growth),), np.zeros((40, 1)), U > 28.0, what="beyond"
    )
    assert found.shrinks
    assert found.closed > 0.95
    assert found.low > 0.8
    assert found.before > 15.0
    assert found.after < 1.6


def test_an_effect_of_another_shape_does_not() -> None:
    """A bump up to 28 mm is fitted perfectly and says nothing about what follows."""
    rng = np.random.default_rng(1)
    growth = np.maximum(U - 10.0, 0.0)
    bump = np.where(U < 28.0, growth, 0.0)
    found = hold_out(
        bench(growth + rng.normal(size=40)), (effect("bump", bump),), np.zeros((40, 1)), U > 28.0, what="beyond"
    )
    assert not found.shrinks
    assert found.closed < 0.05


def test_nothing_shrinks_where_there_is_no_gap() -> None:
    rng = np.random.default_rng(2)
    growth = np.maximum(U - 10.0, 0.0)
    shrunk = [
        hold_out(
            bench(rng.normal(size=40)), (effect("any", growth),), np.zeros((40, 1)), U > 28.0, what="beyond"
        ).shrinks
        for _ in range(40)
    ]
    assert sum(shrunk) <= 5


def test_the_split_lies_between_onset_and_end() -> None:
    assert split_at(20.0, 40.0) == pytest.approx(32.0)


def test_something_is_held_out_however_late_the_gap_may_begin() -> None:
    assert split_at(39.0, 40.0) == pytest.approx(34.0)
