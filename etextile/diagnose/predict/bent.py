"""The record of a bending test: moments over curvatures of a piece that is laid around a cylinder."""

from __future__ import annotations

import numpy as np

from etextile.diagnose.data.observe import PEAKS, Record
from etextile.diagnose.predict.simulate import places
from etextile.mechanics.model import Model
from etextile.motion.bent import moments
from etextile.types import Array


PER_METRE = 1e-3
"""One 1/m in 1/mm."""
STATIONS = 120
"""Most curvatures at which moments are calculated; a run takes a fraction of a millisecond for each."""


def bent_record(model: Model, curvature: Array) -> Record:
    """Return moments (N m/m) and positions at rising curvatures (K,) 1/m > 0; raises BadInput as `moments` does."""
    moment, bent = moments(model, PER_METRE * curvature)
    lattice = model.lattice
    x, y, shape = places(lattice.points)
    positions = [lattice.points, *(item[: len(lattice.points)] for item in bent)]
    return Record(
        x, y, lattice.symmetry, np.array([0.0, *curvature]), np.array([0.0, *moment]),
        np.array([item.reshape(shape) for item in positions]), np.zeros((len(positions), len(PEAKS))), True,
        lattice.warp_angle,
    )  # fmt: skip
