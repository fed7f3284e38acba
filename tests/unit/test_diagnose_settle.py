"""What the lattice leaves open in an effect: covariance of a moved change, and of what a card calls undetermined."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.diagnose.points import EDGE, FORCE, Points, Series
from etextile.diagnose.settle import doubt
from etextile.diagnose.table import Grid, axes_of
from etextile.effects.base import Undetermined
from etextile.effects.rotational_shear import RotationalShear
from etextile.types import Array


def measured() -> Points:
    """Return two force curves and the height of the free edge at two places, 0 to 40 mm."""
    u = np.linspace(1.0, 40.0, 40)
    force = [Series(FORCE, "force", "N", n, f"punch_{n}") for n in (0, 1)]
    edge = Series(EDGE, "height", "mm", 0, EDGE)
    place = np.repeat([0.0, 40.0], 40)
    nowhere = np.full(80, np.nan)
    return Points(
        (*force, edge), np.repeat([0, 1, 2, 2], 40), np.tile(u, 4), np.concatenate([nowhere, place]),
        np.concatenate([nowhere, np.full(80, np.inf)]), np.zeros(160), np.full(160, np.nan),
    )  # fmt: skip


def deviation(covariance: Array) -> Array:
    return np.sqrt(np.diag(covariance))


def test_a_change_that_every_lattice_gives_alike_is_in_no_doubt() -> None:
    assert not doubt(measured(), np.zeros(160), ()).any()


def test_the_doubt_has_the_size_of_the_move_where_it_moved_and_fades_away_from_there() -> None:
    points = measured()
    moved = np.where(points.of(EDGE) & (points.displacement > 20.0), 0.7, 0.0)
    found = deviation(doubt(points, moved, ()))
    assert found[points.of(EDGE) & (points.displacement > 32.0)] == pytest.approx(0.7, rel=0.01)
    assert found[points.of(EDGE) & (points.displacement < 5.0)].max() < 0.07
    assert not found[points.of(FORCE)].any()


def test_specimens_are_wrong_together_and_channels_apart() -> None:
    points = measured()
    found = doubt(points, np.ones(160), ())
    first, second, edge = (np.flatnonzero(points.owner == i) for i in range(3))
    np.testing.assert_allclose(found[np.ix_(first, first)], found[np.ix_(first, second)])
    assert not found[np.ix_(first, edge)].any()
    assert np.linalg.eigvalsh(found).min() > -1e-9


def test_over_places_a_field_is_known_up_to_its_form_and_a_force_is_not_judged_twice() -> None:
    points = measured()
    found = deviation(doubt(points, np.zeros(160), (), change=np.full(160, 3.0)))
    assert found[points.of(EDGE)] == pytest.approx(0.3)
    assert not found[points.of(FORCE)].any()


def test_what_a_card_leaves_undetermined_is_as_large_as_it_says_and_there_alone() -> None:
    points = measured()
    card = replace(RotationalShear.card, undetermined=(Undetermined(EDGE, "height", 1.5),))
    found = deviation(doubt(points, np.full(160, 7.0 * points.of(EDGE)), (card,)))
    assert found[points.of(EDGE)] == pytest.approx(1.5)
    assert not found[points.of(FORCE)].any()


def test_the_ordinary_node_is_next_to_the_example_and_never_the_neutral_one() -> None:
    card = RotationalShear.card
    grid = Grid(card, axes_of(card))
    at = grid.ordinary
    assert grid.parameters([grid.axes[0].nodes[at[0]]])["share"] == pytest.approx(card.example.parameters["share"])
    tiny = replace(card, example=replace(card.example, parameters={"share": 1e-6}))
    grid = Grid(tiny, axes_of(tiny))
    assert grid.ordinary[0] != grid.axes[0].neutral
