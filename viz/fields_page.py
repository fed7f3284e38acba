"""Fields of two runs on the undeformed specimen, under a slider: strain of the fabric, wires and loops by state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from viz.live import fields_data, flat_shape, loops_data, packed, states_data, thinned
from viz.scene import Scene
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
    corners = (last.flat[quads][:, :, :2] - shape["low"]) / shape["scale"]
    loops = loops_data(first, report, low=np.zeros(3), size=1.0)
    return {
        "name": name,
        "at": [round(scene.displacement_mm, 6) for scene in first],
        "flat": shape,
        "cells": packed(np.round(np.clip(corners, 0.0, 65535.0)).astype(np.uint16)),
        "fields": fields_data(fields, owner),
        "wire": last.wires.wire.astype(int).tolist(),
        "wire_states": states_data(report, first),
        "loops": [{key: value for key, value in loop.items() if key != "place"} for loop in loops],
    }  # fmt: skip


def looks() -> dict[str, Any]:
    """Return the colours of fields and wires."""
    return {"ramp": list(STRAIN_RAMP), "wire_colour": [wire_colour(number) for number in range(4)]}
