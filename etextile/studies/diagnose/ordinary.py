"""Ordinary measurements of the channels: their noise, what they cost, and where they are read."""

from __future__ import annotations

import numpy as np

from etextile.diagnose.data.measured import ClampLine, FreeEdge, Measurements, StrainField
from etextile.diagnose.data.observe import Record
from etextile.diagnose.data.points import Points, gather
from etextile.types import Array
from etextile.vocabulary import CLAMP, EDGE, STRAIN


NOISE = {EDGE: 0.2, STRAIN: 0.003, CLAMP: 0.1}
"""Standard deviation of an ordinary instrument: mm, engineering strain, mm."""
COST = {CLAMP: 1, EDGE: 2, STRAIN: 5}
"""What a measurement takes, relative: a mark and a rule, a photograph from the side, two cameras with a pattern."""
SHARES = (0.25, 0.5, 0.75, 1.0)
"""Displacements at which is measured, as shares of the largest."""
PLACES = (0.02, 0.25, 0.5, 0.75, 0.95)
"""Places along half the specimen, as shares of it."""


def imagined(record: Record, reach: float) -> dict[str, Points]:
    """Return the points of an ordinary measurement of every channel on a specimen of this size."""
    travel = reach * np.array(SHARES)
    x, y = record.x[-1] * np.array(PLACES), record.y[-1] * np.array(PLACES)
    u1, x1 = _crossed(travel, x)
    u2, x2, y2 = _crossed(travel, x, y)
    u3, y3 = _crossed(travel, y)
    edge = FreeEdge("", u1, x1, x1, np.full_like(x1, record.y[-1]), np.zeros_like(x1), NOISE[EDGE])
    field = StrainField("", u2, x2, y2, np.zeros_like(x2), np.zeros_like(x2), NOISE[STRAIN])
    clamp = ClampLine("", u3, y3, np.zeros_like(y3), NOISE[CLAMP])
    return {
        EDGE: gather(Measurements("", "", free_edge=edge)),
        STRAIN: gather(Measurements("", "", strain_field=field)),
        CLAMP: gather(Measurements("", "", clamp_line=clamp)),
    }


def _crossed(*axes: Array) -> tuple[Array, ...]:
    """Return all combinations, the first axis slowest."""
    return tuple(grid.ravel() for grid in np.meshgrid(*axes, indexing="ij"))
