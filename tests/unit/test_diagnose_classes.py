"""Classes: a change that another effect can imitate within noise is no name, one that it cannot is."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.diagnose.data.noise import NoiseScatter, SignalShape, WeightedScatter
from etextile.diagnose.data.points import Points, Series, Thinning
from etextile.diagnose.decide.classes import class_of, distance
from etextile.diagnose.infer.whitened import Workbench
from etextile.diagnose.predict.table import EffectTable, ParameterAxis, ParameterGrid
from etextile.effects.base import Card, Example, Parameter
from etextile.types import Array
from etextile.vocabulary import FORCE


N = 80
U = np.tile(np.linspace(1.0, 40.0, 40) / 40.0, 2)
EXACT_FORM = np.zeros((N, 1))
RAMP, PARABOLA, LATE = U, U**2, np.maximum(U - 0.8, 0.0)
NOISE = 0.1


def toy(name: str, curve: Array) -> EffectTable:
    """An effect whose change is its parameter, 0 to 4, times a curve."""
    parameter = Parameter("size", "", 0.0, 4.0, "the size")
    card = Card(name, "a toy", (parameter,), Example({"size": 4.0}))
    grid = ParameterGrid(card, (ParameterAxis(parameter, np.array([0.0, 4.0]), 0),))
    return EffectTable(grid, curve[:, None], np.array([[0.0, 4.0]]), np.array([True, True]))


def bench_of(freedom: Array | None = None) -> Workbench:
    """Two force curves to 40 mm with white noise and, if given, a free fabric parameter (n, 1)."""
    nowhere, nothing = np.full(N, np.nan), np.zeros(N)
    points = Points(
        tuple(Series(FORCE, "force", "N", n, f"punch_{n}") for n in (0, 1)), np.repeat([0, 1], 40), 40.0 * U, nowhere,
        nowhere, nothing, nowhere,
    )  # fmt: skip
    white, columns = np.full(N, NOISE), np.zeros((N, 1)) if freedom is None else freedom
    return Workbench(
        points, Thinning(np.arange(N), np.ones(N)), points, nothing, nothing, white, white,
        SignalShape(nothing, nothing, nothing),
        (WeightedScatter(1.0, NoiseScatter(1e-6, 1e-6, 1e-6)),), columns, nothing,
    )  # fmt: skip


def test_the_distance_is_that_of_a_least_squares_fit_in_deviations_of_noise() -> None:
    change = 0.7 * PARABOLA
    best = float(RAMP @ change / (RAMP @ RAMP))
    by_hand = float(np.linalg.norm(change - best * RAMP)) / NOISE
    found = distance(change, bench_of(), toy("a", PARABOLA), toy("b", RAMP), EXACT_FORM)
    assert found == pytest.approx(by_hand, rel=2e-3)


def test_a_small_change_has_a_twin_and_the_same_change_ten_times_larger_has_none() -> None:
    tables = {item.id: item for item in (toy("parabola", PARABOLA), toy("ramp", RAMP), toy("late", LATE))}
    assert class_of("parabola", 0.2 * PARABOLA, bench_of(), tables, EXACT_FORM) == ("parabola", "ramp")
    assert class_of("parabola", 2.0 * PARABOLA, bench_of(), tables, EXACT_FORM) == ("parabola",)
    assert class_of("parabola", 0.2 * PARABOLA, bench_of(), tables, EXACT_FORM, without=("ramp",)) == ("parabola",)


def test_what_the_fabric_parameters_could_do_separates_nothing() -> None:
    """The difference of the two is a change that the free fabric parameter makes as well."""
    freedom = 10.0 * (PARABOLA - RAMP)[:, None]
    tables = {item.id: item for item in (toy("parabola", PARABOLA), toy("ramp", RAMP))}
    assert class_of("parabola", 2.0 * PARABOLA, bench_of(freedom), tables, EXACT_FORM) == ("parabola", "ramp")


def test_an_unknown_form_of_the_law_widens_the_class() -> None:
    own, other = toy("parabola", PARABOLA), toy("ramp", RAMP)
    form = np.stack([np.cos(np.pi * k * U) for k in range(4)], axis=1)
    exact, smooth = (distance(0.5 * PARABOLA, bench_of(), own, other, item) for item in (EXACT_FORM, form))
    assert smooth < 0.8 * exact


def test_an_effect_of_the_wrong_sign_is_no_twin() -> None:
    own, other = toy("up", RAMP), toy("down", -RAMP)
    assert distance(2.0 * RAMP, bench_of(), own, other, EXACT_FORM) == pytest.approx(
        float(np.linalg.norm(2.0 * RAMP)) / NOISE, rel=1e-3
    )
