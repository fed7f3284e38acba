"""Wires cut where they cross lattice lines, and the places on the lattice that they are interpolated at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.errors import BadInput
from etextile.lattice.piece import Lattice
from etextile.results.wire_layout import WireLayout
from etextile.types import Array, BoolArray, IntArray


@dataclass(frozen=True)
class LatticeLines:
    """Lattice lines along x and y; nodes are numbered with y running fastest.

    closed: of a tube, whose last line along x is its first.
    """

    x: Array
    y: Array
    closed: bool = False

    @classmethod
    def of(cls, lattice: Lattice) -> LatticeLines:
        """Read the lines off a lattice whose warp runs along x."""
        if lattice.warp_angle != 0.0:
            raise BadInput.of(
                f"wires need the warp along x (got {lattice.warp_angle:g} deg), use wires: null or an angle of 0",
                key="fabric.warp_angle",
            )
        rows = lattice.cells[1] + 1
        if len(lattice.points) == rows * (lattice.cells[0] + 1):
            return cls(lattice.points[::rows, 0], lattice.points[:rows, 1])
        rows -= 1
        y = lattice.points[:rows, 1]
        return cls(lattice.points[::rows, 0], np.append(y, -y[0]), closed=True)

    def cells(self, places: Array) -> IntArray:
        """Return column and row (n, 2) of the cells that places (n, 2) lie in."""
        return np.stack([_interval(line, places[:, axis]) for axis, line in enumerate((self.x, self.y))], axis=1)

    def interpolate(self, places: Array, cells: IntArray) -> tuple[IntArray, Array]:
        """Return nodes and weights, both (n, 4), of places (n, 2) as seen from `cells` (n, 2)."""
        rows = len(self.y) - self.closed
        i, j = cells.T
        s = (places[:, 0] - self.x[i]) / (self.x[i + 1] - self.x[i])
        t = (places[:, 1] - self.y[j]) / (self.y[j + 1] - self.y[j])
        corner, beside = i * rows + j, i * rows + (j + 1) % rows if self.closed else i * rows + j + 1
        nodes = np.stack([corner, beside, corner + rows, beside + rows], axis=1)
        weights = np.stack([(1 - s) * (1 - t), (1 - s) * t, s * (1 - t), s * t], axis=1)
        return nodes.astype(np.int64), weights

    def within(self, places: Array, cells: IntArray) -> BoolArray:
        """Tell which places (n, 2) lie in `cells` (n, 2), borders included."""
        found = np.ones(len(places), dtype=bool)
        for axis, line in enumerate((self.x, self.y)):
            cell = cells[:, axis]
            found &= (places[:, axis] >= line[cell] - 1e-9) & (places[:, axis] <= line[cell + 1] + 1e-9)
        return found


def _interval(line: Array, places: Array) -> IntArray:
    """Return the interval (n,) of increasing numbers that places (n,) lie in."""
    return np.clip(np.searchsorted(line, places, side="right") - 1, 0, len(line) - 2)


def border_crossings(layout: WireLayout, lines: LatticeLines, wire: int) -> Array:
    """Return the coordinates along a wire at which it crosses lattice lines."""
    pieces = layout.pieces
    found = [np.zeros(0)]
    for piece in range(pieces.first[wire], pieces.first[wire + 1]):
        for axis, line in enumerate((lines.x, lines.y)):
            way = pieces.direction[piece, axis]
            if way != 0.0:
                along = (line - pieces.origin[piece, axis]) / way
                found.append(along[(along >= pieces.start[piece]) & (along <= pieces.end[piece])])
    return np.concatenate(found)


def cut_wire(
    layout: WireLayout, lines: LatticeLines, wire: int, *, longest: float = np.inf, held: Sequence[float] | Array = ()
) -> tuple[Array, Array]:
    """Return start and end (n,) along the wire of its woven-in elements, none longer than `longest` mm.

    Elements end at lattice lines, at corners, at loops and at the places where the wire is `held`.
    """
    first, last = layout.start_mm[wire], layout.end_mm[wire]
    own = layout.loop_wire == wire
    exits, entries = layout.loop_exit_mm[own], layout.loop_entry_mm[own]
    corners = layout.vertex_along_mm[layout.vertex_wire == wire]
    stops = np.unique(
        np.concatenate([[first, last], border_crossings(layout, lines, wire), corners, exits, entries, held])
    )
    stops = stops[(stops >= first) & (stops <= last)]
    stops = stops[np.concatenate([[True], np.diff(stops) > 1e-9])]
    middle = 0.5 * (stops[:-1] + stops[1:])
    free = ((middle[:, None] > exits) & (middle[:, None] < entries)).any(axis=1)
    return _subdivide(stops[:-1][~free], stops[1:][~free], longest)


def _subdivide(start: Array, end: Array, longest: float) -> tuple[Array, Array]:
    """Return intervals (n,) cut into equal parts of at most `longest` mm."""
    parts = np.maximum(np.ceil((end - start) / longest - 1e-9), 1.0).astype(np.int64)
    if (parts == 1).all():
        return start, end
    number = np.concatenate([np.arange(n) for n in parts])
    first, piece = np.repeat(start, parts), np.repeat((end - start) / parts, parts)
    return first + number * piece, first + (number + 1) * piece
