"""Specimens of one channel beside each other: which of them must be in another unit than the rest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from etextile.diagnose.data.punched import PunchForce
from etextile.errors import Problem


# Specimens of one test differ by less than this factor, whatever their scatter; most units differ by more.
SPECIMENS_FACTOR = 5.0


def odd_specimens(curves: Sequence[PunchForce]) -> Iterator[Problem]:
    """Yield the specimens that must be in another unit than the others: where they end, and the force they reach.

    Forces are compared up to the end of the shortest record.
    """
    ends = [len(curve.displacement) - 1 for curve in curves]
    found = list(_odd("displacement_mm", curves, ends))
    reach = min((float(curve.displacement[-1]) for curve in curves), default=0.0)
    if not found and all(curve.displacement[0] <= reach for curve in curves):
        peaks = [int(np.abs(curve.force[curve.displacement <= reach]).argmax()) for curve in curves]
        found = list(_odd("force_N", curves, peaks))
    yield from found


def _odd(key: str, curves: Sequence[PunchForce], rows: Sequence[int]) -> Iterator[Problem]:
    """Yield the specimens whose value is off the median of all by the factor; of two, the second."""
    reached, small, large, unit = {
        "displacement_mm": ("ends at", "m? cm?", "um?", "mm"),
        "force_N": ("peaks at", "kN?", "mN? gf?", "N"),
    }[key]
    columns = (curve.displacement if unit == "mm" else curve.force for curve in curves)
    values = [abs(float(column[row])) for column, row in zip(columns, rows, strict=True)]
    two = len(curves) == 2
    middle = values[0] if two else float(np.median(values))
    for curve, row, value in zip(curves, rows, values, strict=True):
        if SPECIMENS_FACTOR * value < middle or value > SPECIMENS_FACTOR * middle:
            other = curves[0].file if two else "the median of the specimens"
            guess = "one of the two is in another unit," if two else small if value < middle else large
            message = f"{reached} {value:.4g}, {other} at {middle:.4g}; {guess} convert to {unit}"
            yield Problem(message, file=curve.file, line=curve.line(row), key=key)
