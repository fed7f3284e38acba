"""Sign and onset of an effect against its card and against the gap, on curves of known form."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

import numpy as np
import pytest

from etextile.diagnose.data.noise import NoiseScatter, SignalShape, WeightedScatter
from etextile.diagnose.data.points import Points, Series, thin
from etextile.diagnose.decide.localise import Window
from etextile.diagnose.decide.signature import mismatch, undeclared
from etextile.diagnose.decide.where import GapPlace, onset_of
from etextile.diagnose.infer.whitened import Workbench
from etextile.diagnose.predict.table import EffectTable, ParameterGrid, axes_of, tabulate
from etextile.effects.base import Card, Example, Parameter, Signature
from etextile.types import Array
from etextile.vocabulary import FORCE


TRAVEL = np.linspace(1.0, 40.0, 40)
FORCES = 2.0 * TRAVEL**2
GAP_FROM = 20.0


def bench(residual: Array) -> Workbench:
    """Return one specimen with 1 N of noise and scatter of half a per cent."""
    nowhere = np.full(len(TRAVEL), np.nan)
    series = (Series(FORCE, "force", "N", 0, "punch"),)
    points = Points(series, np.zeros(len(TRAVEL), dtype=np.int64), TRAVEL, nowhere, nowhere, FORCES, nowhere)
    white = np.ones(len(TRAVEL))
    return Workbench(
        points, thin(points), points, FORCES, residual, white, white,
        SignalShape(FORCES, np.gradient(FORCES, TRAVEL), FORCES),
        (WeightedScatter(1.0, NoiseScatter(0.005, 0.02, 0.002)),), np.zeros((len(TRAVEL), 0)), np.zeros(len(TRAVEL)),
    )  # fmt: skip


def gap(sign: float = -1.0) -> tuple[Workbench, GapPlace]:
    """Return a gap that begins at 20 mm, and where the hinge finds that."""
    residual = sign * 3.0 * np.maximum(TRAVEL - GAP_FROM, 0.0) ** 1.5
    found = bench(residual)
    at = onset_of(found, np.arange(len(TRAVEL)), residual, found.mean_covariance)
    return found, GapPlace(FORCE, "force", at, Window(0, 25.0, 40.0), 20.0, sign * 10.0, "")


def effect(shape: Array, *, sign: Literal[-1, 0, 1] = -1, low: float = 0.0) -> EffectTable:
    """Return an effect whose change is its size times a shape; its card declares a sign for size one."""
    card = Card(
        "toy", "a toy", (Parameter("size", "", low, 2.0, "the size"),), Example({"size": 1.0}),
        (Signature("punch_force", sign, 0.0, "a toy"),),
    )  # fmt: skip
    grid = ParameterGrid(card, axes_of(card))
    return tabulate(grid, {index: values["size"] * shape for index, values in grid.nodes()}, np.ones(len(TRAVEL)))


def at(table: EffectTable, size: float) -> list[float]:
    return [float(table.grid.axes[0].to_coordinate(size))]


@pytest.mark.parametrize(
    ("size", "sign", "wrong"), [(1.0, -1, False), (1.0, 1, True), (-1.0, -1, False), (1.0, 0, False)]
)
def test_a_change_against_the_card_is_seen_on_both_sides_of_nothing(size: float, sign: int, *, wrong: bool) -> None:
    """The effect lowers the force at size one and raises it at size minus one; card +1 is wrong, 0 declares nothing."""
    table = effect(-0.05 * FORCES, sign=sign, low=-2.0)  # type: ignore[arg-type]
    assert undeclared(gap()[0], table, at(table, size)) is wrong


def test_a_change_within_the_noise_is_held_against_no_card() -> None:
    table = effect(-0.0005 * FORCES, sign=1)
    assert not undeclared(gap()[0], table, at(table, 1.0))


def test_an_effect_that_only_raises_the_force_cannot_lower_it() -> None:
    """Whatever its size; one that goes both ways can."""
    table = effect(0.05 * FORCES, sign=1)
    assert mismatch(*gap(-1.0), table, at(table, 0.0)) == "moves the force the other way"
    assert mismatch(*gap(+1.0), table, at(table, 0.0)) == ""
    both = effect(0.05 * FORCES, sign=1, low=-2.0)
    assert mismatch(*gap(-1.0), both, at(both, 0.0)) == ""


@pytest.mark.parametrize(("begins", "words"), [(32.0, "only"), (20.0, ""), (0.0, "already")])
def test_an_effect_that_begins_elsewhere_than_the_gap_says_so(begins: float, words: str) -> None:
    shape = -3.0 * np.maximum(TRAVEL - begins, 0.0) ** 1.5
    table = effect(shape)
    found = mismatch(*gap(), table, at(table, 1.0))
    assert found.endswith(words)
    assert bool(found) == bool(words)


def test_what_cannot_be_seen_has_no_direction() -> None:
    """An effect within the noise at any size, one of which only nothing could be simulated, one without any run."""
    small = effect(1e-5 * FORCES)
    assert mismatch(*gap(), small, at(small, 2.0)) == "hardly moves the force"
    table = effect(-0.05 * FORCES)
    neutral = replace(table, valid=np.arange(len(table.valid)) == table.grid.axes[0].neutral)
    assert mismatch(*gap(), neutral, at(table, 0.0)) == "hardly moves the force"
    lost = replace(table, valid=np.zeros_like(table.valid))
    assert mismatch(*gap(), lost, at(table, 0.0)) == ""


def test_a_share_of_a_per_cent_that_every_point_has_is_hidden_by_the_scatter_between_specimens() -> None:
    """Many points are each a little off, all together as their common gain may be."""
    table = effect(-0.005 * FORCES, sign=1)
    assert not undeclared(gap()[0], table, at(table, 1.0))


def test_the_sign_is_that_of_the_clear_part_of_a_change() -> None:
    """Five deviations more early on, and a little less everywhere later: the card's `more, fading` holds."""
    shape = np.where(TRAVEL < 6.0, 8.0, -0.8)
    table = effect(shape, sign=1)
    assert not undeclared(gap()[0], table, at(table, 1.0))
    assert undeclared(gap()[0], effect(-shape, sign=1), at(table, 1.0))
