"""Where wires and their loops lie, as the plain arrays that results carry; who lays them out is `wires`' business.

Material coordinates, origin in the specimen's centre: warp along x, weft along y. A wire is a line of straight pieces
between vertices. A place on it is its coordinate *along* the wire: the warp or weft coordinate for wires woven along
these yarns, the length from the start for laid ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from etextile.errors import BadInput
from etextile.types import Array, BoolArray, IntArray


KINDS = ("warp", "weft", "laid")
"""How a wire lies: woven along the warp or the weft, or laid on the fabric along any line."""
ALONG_WARP, ALONG_WEFT, LAID = range(3)


@dataclass(frozen=True)
class WireLayout:
    """Wires (W,), the vertices (V,) of their paths and their loops (L,) in material coordinates."""

    weft_mm: Array
    """(W,) weft coordinate of each wire; of its middle where it does not follow the warp."""
    start_mm: Array
    """(W,) coordinate along the wire where its modelled part begins (0 on the symmetry plane x = 0)."""
    end_mm: Array
    """(W,) coordinate along the wire where it ends."""
    share: Array
    """(W,) share of the cross-section that belongs to the modelled part: 1, or 0.5 on a symmetry plane."""
    loop_wire: IntArray
    """(L,) wire of each loop, not decreasing."""
    loop_index: IntArray
    """(L,) number of the loop within its wire."""
    loop_warp_mm: Array
    """(L,) warp coordinate of the loop's centre."""
    loop_exit_mm: Array
    """(L,) coordinate along the wire where it leaves the weave (of the full loop, also when it is halved)."""
    loop_entry_mm: Array
    """(L,) coordinate along the wire where it re-enters; greater than `loop_exit_mm`."""
    loop_slack: Array
    """(L,) excess length: the rest length of the free wire is (1 + slack) times the span."""
    loop_halved: BoolArray
    """(L,) True when a symmetry plane halves the loop in the model."""
    loop_copies: IntArray
    """(L,) how many loops of the same wire a stored loop stands for: 2 where a plane mirrors it, else 1."""
    wire_copies: IntArray
    """(W,) how many wires of the whole specimen a stored wire stands for: 2 where a plane mirrors it, else 1."""
    symmetric: bool
    """False when the symmetry planes mirror wires or loops that the whole specimen does not have there."""
    kind: IntArray
    """(W,) index into KINDS."""
    loop_rigid_mm: Array
    """(L,) length of a part in the middle of the (full) loop that does not stretch; 0 for an empty loop."""
    vertex_wire: IntArray
    """(V,) wire of each vertex of the paths, not decreasing; every wire has two or more."""
    vertex_along_mm: Array
    """(V,) coordinate along the wire, growing within it."""
    vertex_warp_mm: Array
    """(V,) warp coordinate."""
    vertex_weft_mm: Array
    """(V,) weft coordinate."""
    names: tuple[str, ...]
    """(W,) names of the wires; their numbers where nobody named them."""

    @classmethod
    def of_arrays(cls, arrays: Mapping[str, Any]) -> WireLayout:
        """Return the layout with these fields; those of older files (straight wires, no names) are filled in."""
        own = {entry.name: arrays[entry.name] for entry in fields(cls) if entry.name in arrays}
        wires, loops = len(own["weft_mm"]), len(own["loop_wire"])
        if "vertex_wire" not in own:
            own |= straight_warp(own["weft_mm"], own["start_mm"], own["end_mm"])
        own.setdefault("kind", np.zeros(wires, dtype=np.int64))
        own.setdefault("loop_rigid_mm", np.zeros(loops))
        own.setdefault("names", tuple(str(number) for number in range(wires)))
        return cls(**own)

    @property
    def n_wires(self) -> int:
        """Number of wires in the modelled part."""
        return int(self.weft_mm.size)

    @property
    def n_loops(self) -> int:
        """Number of loops in the modelled part."""
        return int(self.loop_wire.size)

    @cached_property
    def loop_weft_mm(self) -> Array:
        """(L,) weft coordinate of each loop's centre."""
        return self.places(self.loop_wire, 0.5 * (self.loop_exit_mm + self.loop_entry_mm))[:, 1]

    @property
    def loop_span_mm(self) -> Array:
        """(L,) distance between exit and entry in the undeformed fabric."""
        return self.loop_entry_mm - self.loop_exit_mm

    @property
    def loop_rest_mm(self) -> Array:
        """(L,) length of the free wire, span * (1 + slack)."""
        return self.loop_span_mm * (1.0 + self.loop_slack)

    @property
    def modelled_exit_mm(self) -> Array:
        """(L,) where the modelled part of each loop begins: where its wire does for a loop that is halved there."""
        return np.where(
            self.loop_halved, np.maximum(self.loop_exit_mm, self.start_mm[self.loop_wire]), self.loop_exit_mm
        )

    @property
    def modelled_entry_mm(self) -> Array:
        """(L,) where the modelled part of each loop ends: where its wire does for a loop that is halved there."""
        return np.where(
            self.loop_halved, np.minimum(self.loop_entry_mm, self.end_mm[self.loop_wire]), self.loop_entry_mm
        )

    @property
    def modelled_rigid_mm(self) -> Array:
        """(L,) length of the part in the modelled part of each loop."""
        return np.asarray(self.loop_rigid_mm * np.where(self.loop_halved, 0.5, 1.0))

    @property
    def straight(self) -> bool:
        """Whether all wires follow the warp."""
        return bool((self.kind == ALONG_WARP).all())

    @property
    def length_mm(self) -> Array:
        """(W,) length of the modelled part of each wire's path."""
        return np.asarray(self.end_mm - self.start_mm)

    @cached_property
    def pieces(self) -> StraightPieces:
        """The straight pieces of all wires."""
        return StraightPieces.of(self)

    def places(self, wire: IntArray, along: Array) -> Array:
        """Return warp and weft coordinates (n, 2) of the places `along` (n,) on the wires (n,)."""
        return self.pieces.places(self.pieces.at(wire, along), along)

    def with_loop_slack(self, slack: ArrayLike) -> WireLayout:
        """Return a copy with another slack: one number, or one for each of the L loops."""
        values = np.array(np.broadcast_to(np.asarray(slack, dtype=float), (self.n_loops,)))
        if not (np.isfinite(values) & (values >= 0.0)).all():
            raise BadInput.of("must be finite and not negative", key="wires.loops.slack")
        return replace(self, loop_slack=values)


@dataclass(frozen=True)
class StraightPieces:
    """Straight pieces (p,) of wires: wire, first and last coordinate along it, unit direction and origin (p, 2).

    The place of a coordinate s is origin + s * direction, so that along a warp wire it is s itself to the last digit.
    """

    wire: IntArray
    start: Array
    end: Array
    direction: Array
    origin: Array
    first: IntArray

    @classmethod
    def of(cls, layout: WireLayout) -> StraightPieces:
        """Return the pieces between the vertices of a layout, wire by wire."""
        inner = np.flatnonzero(np.diff(layout.vertex_wire) == 0)
        point = np.stack([layout.vertex_warp_mm, layout.vertex_weft_mm], axis=1)
        start, end = layout.vertex_along_mm[inner], layout.vertex_along_mm[inner + 1]
        length = (end - start)[:, None]
        direction = np.divide(point[inner + 1] - point[inner], length)
        direction[np.abs(direction) < 1e-12] = 0.0
        full = np.abs(np.abs(direction) - 1.0) < 1e-12
        direction[full] = np.sign(direction[full])
        wire = layout.vertex_wire[inner]
        first = np.searchsorted(wire, np.arange(layout.n_wires + 1))
        return cls(wire, start, end, direction, point[inner] - start[:, None] * direction, first)

    def at(self, wire: IntArray, along: Array) -> IntArray:
        """Return the pieces (n,) on which places `along` (n,) of wires (n,) lie."""
        found = self.first[wire].copy()
        for number in np.unique(wire):
            first, last = self.first[number], self.first[number + 1]
            if last - first > 1:
                own = wire == number
                inside = np.searchsorted(self.end[first:last], along[own], side="left")
                found[own] = first + np.minimum(inside, last - first - 1)
        return np.asarray(found)

    def places(self, piece: IntArray, along: Array) -> Array:
        """Return the places (n, 2) of coordinates `along` (n,) on pieces (n,)."""
        return np.asarray(self.origin[piece] + np.asarray(along)[:, None] * self.direction[piece])


def straight_warp(weft: Array, start: Array, end: Array) -> dict[str, Any]:
    """Return the vertex fields of wires that lie straight along the warp."""
    wires = len(weft)
    ends = np.stack([start, end], axis=1).ravel()
    return {
        "vertex_wire": np.repeat(np.arange(wires), 2),
        "vertex_along_mm": ends,
        "vertex_warp_mm": ends,
        "vertex_weft_mm": np.repeat(weft, 2),
    }
