"""Fields of two runs on the undeformed specimen, under a slider: strain of the fabric, wires and loops by state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from viz.live import fields_data, flat_shape, loops_data, states_data
from viz.scene import Scene
from viz.shape import PARTS, packed, rounded, thinned
from viz.style import STRAIN_RAMP, wire_colour


Report = Mapping[str, Any]


def field_map(name: str, fields: Mapping[str, Sequence[Scene]], report: Report) -> dict[str, Any]:
    """Return one run for a page; `fields`: its scenes over the steps by the field that colours them.

    Corners are whole 65 535ths of the specimen's larger side, strains 250ths of the largest; what is said of a loop is
    what the report says.
    """
    first = next(iter(fields.values()))
    last = first[-1]
    quads, owner = thinned(last)
    shape = flat_shape(last)
    corners = rounded(last.flat[quads][:, :, :2], np.array(shape["low"]), PARTS * shape["scale"])
    return {
        "name": name,
        "at": [round(scene.displacement_mm, 6) for scene in first],
        "flat": shape,
        "cells": packed(corners),
        "fields": fields_data(fields, owner),
        "wire": last.wires.wire.astype(int).tolist(),
        "wire_states": states_data(report, first),
        "loops": loops_data(first, report),
    }


def looks() -> dict[str, Any]:
    """Return the colours of fields and wires."""
    return {"ramp": list(STRAIN_RAMP), "wire_colour": [wire_colour(number) for number in range(4)]}
