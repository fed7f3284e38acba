"""Records as machines log them: jitter, repeated readings, unloadings and reloadings, told apart from disorder.

A crosshead or an extensometer does not rise from row to row: it jitters by some micrometres, stands still, runs back.
Rows in shuffled order do the same, only by far more; the line between the two is drawn here and nowhere else.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from etextile.types import Array, BoolArray, IntArray


JITTER, MAX_JITTER = 1e-3, 0.03
"""A fall by less than this share of the range (more when the readings are noisy, at most so much more) is jitter."""
NOISES = 10.0
MIN_FALL = 3
"""Rows over which a reading must fall to be an unloading and no row in a wrong place."""


def point_noise(values: Array) -> float:
    """Return the standard deviation of values (n,) from point to point, about any smooth curve.

    Third differences cancel a smooth curve and have the variance 20 sd^2; their median makes the estimate robust.
    """
    if len(values) < 8:
        return 0.0
    return float(1.4826 * np.median(np.abs(np.diff(values, 3))) / np.sqrt(20.0))


def jitter_of(values: Array) -> float:
    """Return how far readings (n,) that rise on the whole may fall without being an unloading."""
    reach = float(values.max() - min(float(values[0]), 0.0))
    return min(max(JITTER * reach, NOISES * point_noise(values)), MAX_JITTER * reach)


def reversals(values: Array, threshold: float) -> list[tuple[int, int, int]]:
    """Return every fall by more than `threshold`: its highest point, the first point below, its lowest point.

    Turning points are compared, not neighbours: a file of thousands of points falls by tiny steps.
    """
    found: list[tuple[int, int, int]] = []
    high = low = seen = 0
    falling = False
    top = bottom = float(values[0])
    for i, value in enumerate(values.tolist()):
        if falling:
            if value <= bottom:
                low, bottom = i, value
            elif value > bottom + threshold:
                found.append((high, seen, low))
                falling, high, top = False, i, value
        elif value >= top:
            high, top = i, value
        elif value < top - threshold:
            falling, seen, low, bottom = True, i, i, value
    return [*found, (high, seen, low)] if falling else found


def primary(values: Array, falls: Sequence[tuple[int, int]]) -> BoolArray:
    """Mark the points outside of falls (first, last) and beyond the value reached before them."""
    keep = np.ones(len(values), dtype=np.bool_)
    for first, last in falls:
        keep[first + 1 : last + 1] = False
        back = np.flatnonzero(values[last:] > values[: first + 1].max())
        keep[last : last + (int(back[0]) if len(back) else len(values))] = False
    return keep


def merged(values: Array, others: Array) -> tuple[Array, Array, IntArray]:
    """Return distinct values in rising order, the mean of `others` at each, and the first row of each."""
    distinct, first, inverse, count = np.unique(values, return_index=True, return_inverse=True, return_counts=True)
    return distinct, np.bincount(inverse, others) / count, first
