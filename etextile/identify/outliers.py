"""Specimens that do not belong to the others, named by how far their loading curve lies from the median curve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.identify.segments import Segments
from etextile.types import Array


# A specimen is an outlier when its distance is above this share of the median curve and this multiple of the usual one.
MIN_DISTANCE = 0.08
MULTIPLE = 4.0
_GRID = 60


@dataclass(frozen=True)
class SpecimenDistances:
    """Distance of each specimen's curve from the median curve, relative (n,), and who is an outlier (n,).

    `signed` (n,): mean relative difference, positive for a specimen that is too stiff.
    """

    distance: Array
    signed: Array
    outlier: tuple[bool, ...]


def scatter(specimens: Sequence[Segments]) -> SpecimenDistances:
    """Compare the loading curves of specimens over the strain they share.

    Two specimens can differ but not tell which of them is wrong: none is then called an outlier.
    """
    count = len(specimens)
    if count < 2:
        return SpecimenDistances(np.zeros(count), np.zeros(count), (False,) * count)
    top = min(float(item.strain.max()) for item in specimens)
    grid = np.linspace(0.3 * top, top, _GRID)
    curves = np.array([np.interp(grid, np.maximum.accumulate(item.strain), item.stress) for item in specimens])
    middle = np.median(curves, axis=0)
    size = float(np.sqrt(np.mean(middle**2)))
    distance = np.sqrt(np.mean((curves - middle) ** 2, axis=1)) / size
    signed = np.mean(curves - middle, axis=1) / size
    limit = max(MIN_DISTANCE, MULTIPLE * float(np.median(distance)))
    outlier = distance > limit if count > 2 else np.zeros(count, dtype=np.bool_)
    return SpecimenDistances(distance, signed, tuple(bool(value) for value in outlier))
