"""What the report says of parts: where they are, what they connect, and what the wires bear at their lands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from etextile.results.wire_history import WireHistory
from etextile.types import Array
from wires.layout import Portion
from wires.parts import PartSpec, Terminal
from wires.portion import AXES, Image
from wires.woven import element_lengths, element_places


EDGE_MM = 2.0
"""Wire up to this far beside a land counts as at its edge."""


def part_rows(
    parts: Sequence[PartSpec],
    terminals: Sequence[Terminal],
    history: WireHistory,
    nets: Sequence[dict[str, Any]],
    *,
    images: Mapping[str, Sequence[Image]],
    portion: Portion,
) -> list[dict[str, Any]]:
    """Return one row per part: place, land, wires and nets, the greatest strain of a wire at it and which wire that is.

    The strain is the wire's own, of what is woven in or free within EDGE_MM of the land; null where no wire is near.
    A part that is not in the modelled portion bears what its mirror image does there.
    """
    rows = []
    for index, part in enumerate(parts):
        own = [item for item in terminals if item.part == index]
        at = np.array(part.at, dtype=float)
        for axis in AXES[portion] if portion != "whole" else ():
            at[axis] = abs(at[axis])
        strain = {item.wire: _strain_at(part, at, images[item.wire][0].wire, history) for item in own}
        worst = max(strain, key=lambda name: strain[name], default=None)
        rows.append(
            {
                "name": part.name,
                "warp_mm": part.at[0],
                "weft_mm": part.at[1],
                "size_mm": list(part.size),
                "rigid": part.rigid,
                "wires": [item.wire for item in own],
                "nets": [net["name"] for net in nets if part.name in net.get("parts", ())],
                "max_strain": None if worst is None else strain[worst],
                "worst_wire": worst,
            }
        )
    return rows


def _strain_at(part: PartSpec, at: Array, wire: int, history: WireHistory) -> float:
    """Return the greatest strain of a modelled wire at the edge of a part that lies `at` (2,)."""
    layout = history.layout
    half = np.array(part.size) / 2 + EDGE_MM
    own = np.flatnonzero(history.element_wire == wire)
    places, length = element_places(history)[own], element_lengths(history)[own]
    found = [0.0]
    if len(own):
        nearest = _nearest(layout.places(history.element_wire[own], places), at, half, length)
        found.append(float(history.element_strain[:, own[nearest]].max(initial=0.0)))
    loops = np.flatnonzero(layout.loop_wire == wire)
    middle = layout.places(layout.loop_wire[loops], 0.5 * (layout.loop_exit_mm + layout.loop_entry_mm)[loops])
    near = _nearest(middle, at, half, layout.loop_span_mm[loops])
    found.append(float(history.wire_strain[:, loops[near]].max(initial=0.0)))
    return max(found)


def _nearest(places: Array, at: Array, half: Array, length: Array) -> Array:
    """Return which pieces of these lengths about places (n, 2) reach to within EDGE_MM of a land."""
    off = np.abs(places - at) - half
    return np.asarray((off < 0.5 * length[:, None]).all(axis=1))
