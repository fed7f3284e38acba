"""Wires put into a lattice: Model -> Model with explicit copper trusses in the weave and across the loops.

A wire point at material place (x, y) rides on the four nodes of the cell it lies in, by bilinear interpolation, so
wires need no lattice lines of their own. Between loops, elements end where the wire crosses weft lines and at the
loops, and each lies in one cell; a loop is one element from exit to entry, free of the fabric between. Woven-in
elements have a rest length of (1 + crimp), loops of (1 + slack) times their span. On the symmetry plane y = 0 a wire
has half its area, and a loop cut by x = 0 its half length.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from etextile.errors import BadInput
from etextile.lattice.piece import Lattice
from etextile.lattice.weave import WIRE
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Followers, Model
from etextile.mechanics.truss import TrussBlock
from etextile.types import Array, IntArray
from wires.layout import WireLayout


LOOPS = "loops"
"""Name of the block of perfectly bonded loops."""


@dataclass(frozen=True)
class EmbeddedWires:
    """Where wires and loops are among the trusses: layout; wire, place and length (K,) of the woven-in elements."""

    layout: WireLayout
    element_wire: IntArray
    element_along_mm: Array
    element_length_mm: Array
    crimp: float
    loop_rigid_mm: Array | float = 0.0
    """Length of a component in each loop that does not stretch."""

    @property
    def count(self) -> int:
        """Number of woven-in elements K; the loops follow them in the order of the layout."""
        return len(self.element_wire)

    @property
    def element_warp_mm(self) -> Array:
        """Warp coordinate (K,) of the middles of the woven-in elements."""
        return self.layout.places(self.element_wire, self.element_along_mm)[:, 0]


@dataclass(frozen=True)
class Lines:
    """Lattice lines along x and y; nodes are numbered with y running fastest."""

    x: Array
    y: Array

    @classmethod
    def of(cls, lattice: Lattice) -> Lines:
        """Read the lines off a lattice whose warp runs along x."""
        if lattice.warp_angle != 0.0:
            raise BadInput.of(
                f"wires need the warp along x (got {lattice.warp_angle:g} deg), use wires: null or an angle of 0",
                key="fabric.warp_angle",
            )
        rows = lattice.cells[1] + 1
        return cls(lattice.points[::rows, 0], lattice.points[:rows, 1])

    def interpolate(self, x: Array, y: Array, cell: IntArray) -> tuple[IntArray, Array]:
        """Return nodes and weights, both (n, 4), of points (n,) as seen from the cell column `cell` (n,) along x."""
        rows = len(self.y)
        j = np.clip(np.searchsorted(self.y, y, side="right") - 1, 0, rows - 2)
        s = (x - self.x[cell]) / (self.x[cell + 1] - self.x[cell])
        t = (y - self.y[j]) / (self.y[j + 1] - self.y[j])
        corner = cell * rows + j
        nodes = np.stack([corner, corner + 1, corner + rows, corner + rows + 1], axis=1)
        weights = np.stack([(1 - s) * (1 - t), (1 - s) * t, s * (1 - t), s * t], axis=1)
        return nodes.astype(np.int64), weights

    def column(self, x: Array) -> IntArray:
        """Return the cell column (n,) of places x (n,)."""
        return np.clip(np.searchsorted(self.x, x, side="right") - 1, 0, len(self.x) - 2)


def embed(
    model: Model, layout: WireLayout, law: PowerLaw, *, area_mm2: float, crimp: float
) -> tuple[Model, EmbeddedWires]:
    """Return the model with wires of cross-section `area_mm2` (copper) and the record of where they are.

    Raises BadInput when the warp is not along x.
    """
    lines = Lines.of(model.lattice)
    parts = [cut_wire(layout, lines, wire) for wire in range(layout.n_wires)]
    wire = np.concatenate([np.full(len(a), w) for w, (a, _) in enumerate(parts)] or [np.zeros(0)]).astype(np.int64)
    start, end = (np.concatenate([part[k] for part in parts] or [np.zeros(0)]) for k in (0, 1))
    exits, entries = layout.modelled_exit_mm, layout.modelled_entry_mm
    woven = truss_block("wires", lines, start, end, layout, wire, law, area_mm2, 1.0 + crimp)
    loops = truss_block(
        LOOPS, lines, exits, entries, layout, layout.loop_wire, law, area_mm2,
        1.0 + layout.loop_slack,
    )  # fmt: skip
    blocks = tuple(block for block in (woven, loops) if len(block.nodes))
    followers = wire_points(model, lines, layout, [(start, end, wire), (exits, entries, layout.loop_wire)])
    lattice, *others = model.contributions
    model = replace(model, contributions=(lattice, *blocks, *others), followers=followers)
    return model, EmbeddedWires(layout, wire, 0.5 * (start + end), end - start, crimp)


def cut_wire(layout: WireLayout, lines: Lines, wire: int, *, longest: float = np.inf) -> tuple[Array, Array]:
    """Return start and end (n,) of the woven-in elements of one wire, none longer than `longest` mm."""
    first, last = layout.start_mm[wire], layout.end_mm[wire]
    own = layout.loop_wire == wire
    exits, entries = layout.loop_exit_mm[own], layout.loop_entry_mm[own]
    stops = np.unique(np.concatenate([[first, last], lines.x, exits, entries]))
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


def truss_block(
    name: str,
    lines: Lines,
    start: Array,
    end: Array,
    layout: WireLayout,
    wire: IntArray,
    law: PowerLaw,
    area_mm2: float,
    excess: float | Array,
) -> TrussBlock:
    """Return trusses from start to end (n,) along their wires; elements within one cell couple its four nodes."""
    y = layout.weft_mm[wire]
    one_cell = lines.column(0.5 * (start + end))
    inside = (start >= lines.x[one_cell] - 1e-9) & (end <= lines.x[one_cell + 1] + 1e-9)
    from_cell, to_cell = (np.where(inside, one_cell, lines.column(place)) for place in (start, end))
    nodes_a, weights_a = lines.interpolate(start, y, from_cell)
    nodes_b, weights_b = lines.interpolate(end, y, to_cell)
    if inside.all():
        nodes, weights = nodes_a, weights_b - weights_a
    else:
        nodes, weights = _merge(np.hstack([nodes_a, nodes_b]), np.hstack([-weights_a, weights_b]))
    span = end - start
    return TrussBlock(
        name=name,
        nodes=nodes,
        weights=weights,
        rest_length=span * excess,
        span=span,
        area=area_mm2 * layout.share[wire],
        law=np.zeros(len(span), dtype=np.int64),
        laws=(law,),
        family=np.full(len(span), WIRE),
    )


def _merge(nodes: IntArray, weights: Array) -> tuple[IntArray, Array]:
    """Add the weights of nodes that appear twice in a row to the first place; the second keeps weight zero."""
    weights = weights.copy()
    for later in range(1, nodes.shape[1]):
        for earlier in range(later):
            same = nodes[:, earlier] == nodes[:, later]
            weights[same, earlier] += weights[same, later]
            weights[same, later] = 0.0
    return nodes, weights


def wire_points(
    model: Model, lines: Lines, layout: WireLayout, parts: list[tuple[Array, Array, IntArray]]
) -> Followers:
    """Return the wire points with their cells and wires, elements in the order of the truss blocks."""
    wire = np.concatenate([own for *_, own in parts])
    ends = np.stack([np.concatenate([part[k] for part in parts]) for k in (0, 1)], axis=1)
    key = np.stack([np.repeat(wire, 2).astype(float), np.round(ends.ravel(), 9)], axis=1)
    places, number = np.unique(key, axis=0, return_inverse=True)
    x, y = places[:, 1], layout.weft_mm[places[:, 0].astype(int)]
    nodes, weights = lines.interpolate(x, y, lines.column(x))
    cells = number.reshape(-1, 2) + len(model.lattice.points)
    return Followers(nodes, weights, cells.astype(np.int64), wire)
