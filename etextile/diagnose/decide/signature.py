"""Signature: the sign that a card declares, what an effect can do to the strongest gap, and where its change begins.

An effect that moves the force against its card is not named: its words would explain something else. And what an effect
can do to the quantity with the strongest gap says in plain words why it is not the cause.
"""

from __future__ import annotations

import numpy as np

from etextile.diagnose.decide.localise import Window, in_window
from etextile.diagnose.decide.rank import VISIBLE
from etextile.diagnose.decide.where import NAMES, GapPlace, onset_of
from etextile.diagnose.infer.gauss import Whitener
from etextile.diagnose.infer.whitened import Workbench
from etextile.diagnose.predict.table import Coordinates, EffectTable
from etextile.effects.base import Card
from etextile.types import Array, BoolArray, IntArray
from etextile.units import load_text
from etextile.vocabulary import FORCE


def undeclared(bench: Workbench, table: EffectTable, coordinates: Coordinates) -> bool:
    """Tell whether the change at a point moves the force against the sign that the card declares for it."""
    card = table.grid.card
    declared = sum(item.sign for item in card.signature if item.channel == FORCE)
    own = bench.points.of(FORCE)
    if not declared or not own.any():
        return False
    change = table.curve(coordinates)[own]
    if _size(bench, own, change) < VISIBLE:
        return False
    clear = change * np.abs(change) / np.diag(bench.mean_covariance)[own]
    return bool(np.sign(clear.sum()) == -np.sign(declared) * _direction(card, table.grid.parameters(coordinates)))


def _size(bench: Workbench, own: BoolArray | IntArray, change: Array) -> Array:
    """Return the size (q,) of changes (k, q), or of one (k,), of the points `own` in standard deviations."""
    return np.asarray(np.linalg.norm(Whitener.of(bench.mean_covariance[np.ix_(own, own)])(change), axis=0))


def _direction(card: Card, parameters: dict[str, float]) -> int:
    """Return 1 when the first parameter lies on the card's example's side of its neutral value, -1 on the other."""
    first = card.parameters[0]
    if first.neutral is None or first.name not in card.example.parameters:
        return 1
    away = (parameters[first.name] - first.neutral) * (card.example.parameters[first.name] - first.neutral)
    return -1 if away < 0.0 else 1


def mismatch(bench: Workbench, place: GapPlace, table: EffectTable, coordinates: Coordinates) -> str:
    """Return how sign or onset of an effect, fitted at a point, disagree with a gap; empty when they do not.

    The sign is wrong when no change that can be seen, at any size within the physical range, moves the quantity towards
    the measurement over the window of the gap. The onset is that of the fitted change, found as that of the gap is.
    """
    inside = in_window(bench.points, place.window)
    changes = table.basis[inside] @ table.amplitudes[:, table.valid]
    seen = changes[:, _size(bench, inside, changes) >= VISIBLE]
    name = NAMES.get(place.channel, place.channel)
    if not seen.shape[1]:
        return f"hardly moves the {name}" if changes.shape[1] else ""
    if np.all(bench.residual[inside] @ seen <= 0.0):
        return f"moves the {name} the other way"
    own = np.flatnonzero(in_window(bench.points, Window(place.window.series, -np.inf, np.inf)))
    change = table.curve(coordinates)
    if _size(bench, own, change[own]) < VISIBLE:
        return ""
    found = onset_of(bench, own, change, bench.mean_covariance)
    unit = bench.points.unit
    begins = f"begins at {load_text(found.at, unit, whole=True)} {unit}"
    if found.low > place.onset.high:
        return f"{begins} only"
    if found.high < place.onset.low:
        return f"{begins} already"
    return ""
