"""Histories over steps: the greatest value so far, and where one first reaches a level."""

from __future__ import annotations

import numpy as np

from etextile.types import Array


def running_maximum(values: Array) -> Array:
    """Return the greatest value so far, (S, ...) along the first axis."""
    result: Array = np.maximum.accumulate(values, axis=0)
    return result


def first_crossing(displacement_mm: Array, values: Array, level: float | Array) -> Array:
    """Return (L,) the displacement at which each column of `values` (S, L) first reaches `level`
    (one for all or (L,)); NaN when it does not.

    Linear between the steps: d = d0 + (d1 - d0) (level - v0) / (v1 - v0). A column that starts at or above the level
    gives the displacement of the first step.
    """
    reached = values >= level
    ever = reached.any(axis=0)
    step = np.where(ever, reached.argmax(axis=0), 0)
    before = np.maximum(step - 1, 0)
    columns = np.arange(values.shape[1])
    low, high = values[before, columns], values[step, columns]
    rise = np.where(high > low, high - low, 1.0)
    weight = np.where((step > 0) & (high > low), (level - low) / rise, 1.0)
    crossing = displacement_mm[before] + weight * (displacement_mm[step] - displacement_mm[before])
    return np.where(ever, crossing, np.nan)
