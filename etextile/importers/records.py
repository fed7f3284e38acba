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
WINDOW = 32
"""Points over which the noise is taken: a crosshead that is held jitters where one that moves does not."""
MIN_FALL = 3
"""Rows over which a reading must fall to be an unloading and no row in a wrong place."""
BREAK = 0.5
"""Broken: the load stays below this share of its peak."""
PAUSE = 0.005
"""Relaxed: the load lies below its earlier peak by this share of all."""
STILL = 0.002
"""Standing still: a reading is beyond that of the earlier peak of load by no more than this share of the largest."""
SINGLE, ALONE = 0.05, 4.0
"""A single reading off by this share of the peak, and by so many times what its neighbours differ, is none."""


def point_noise(values: Array) -> float:
    """Return the standard deviation of values (n,) from point to point, about any smooth curve.

    Third differences cancel a smooth curve and have the variance 20 sd^2; their median makes the estimate robust.
    """
    if len(values) < 8:
        return 0.0
    return float(1.4826 * np.median(np.abs(np.diff(values, 3))) / np.sqrt(20.0))


def running_median(values: Array, width: int) -> Array:
    """Return the median over a window of `width` points (n,), narrower at the ends."""
    half = min(width // 2, max((len(values) - 1) // 2, 0))
    padded = np.pad(values, half, mode="reflect") if half else values
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1), axis=1))


def single_readings(along: Array, load: Array) -> BoolArray:
    """Mark single readings (n,) far from both neighbours, which agree, as the motion goes on: faults of recorders."""
    off = np.zeros(len(load), dtype=np.bool_)
    if len(load) < 5:
        return off
    miss, apart = np.abs(load[1:-1] - 0.5 * (load[:-2] + load[2:])), np.abs(load[2:] - load[:-2])
    least = max(SINGLE * float(running_median(load, 5).max()), 2.0 * NOISES * point_noise(load))
    goes_on = np.diff(along)[1:] * np.diff(along)[:-1] > 0.0
    off[1:-1] = goes_on & (miss > np.maximum(least, ALONE * apart))
    return off


def single_note(lines: IntArray) -> str:
    """Say that the single readings in these lines of a file were left out."""
    count = f"{len(lines)} single readings" if len(lines) > 1 else "a single reading"
    return f"{count} far from the neighbours left out (line {', '.join(map(str, lines[:5]))})"


def where_broken(along: Array, load: Array, *, back: float) -> int | None:
    """Return the first row after a specimen came apart, None where it did not.

    The load is below half of the peak, and stays there, while the reading along the motion has not gone back by `back`:
    no unloading is that steep.
    """
    peak = int(np.argmax(load))
    if load[peak] <= -load.min():
        return None
    low = np.flatnonzero(load[peak:] < BREAK * load[peak])
    if not len(low) or np.any(load[peak + low[0] :] > BREAK * load[peak]):
        return None
    row = peak + int(low[0])
    return None if along[row] < along[peak] - back else row


def stands_still(along: Array, load: Array) -> BoolArray:
    """Mark the readings (n,) that are not beyond where the load was highest up to them."""
    rises = load >= np.maximum.accumulate(load)
    at = np.maximum.accumulate(np.where(rises, np.arange(len(load)), 0))
    return np.asarray(along <= along[at] + STILL * along.max())


def jitter_of(values: Array) -> float:
    """Return how far readings (n,) that rise on the whole may fall without being an unloading."""
    reach = float(values.max() - min(float(values[0]), 0.0))
    parts = [values[i : i + WINDOW] for i in range(0, len(values), WINDOW // 2)] if len(values) > WINDOW else [values]
    return min(max(JITTER * reach, NOISES * max(point_noise(part) for part in parts)), MAX_JITTER * reach)


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
