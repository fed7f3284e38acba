"""A sleeve or a panel around a straight limb: the lattice in material coordinates, and where its nodes begin in space.

Warp runs along the limb, weft around it. The material coordinate x is the length along the piece from the hinge, so
that warp yarns keep their length where it tapers. y runs around from the outer line (y = 0, towards +z) and is measured
at the joint: all warp yarns run the whole length, and where the piece tapers they stand closer, so rest lengths around
are those at the joint times girth / girth at the joint. A tube closes in the crook
(y = half its girth), where its seam is. A half keeps y >= 0, mirrored at the plane of flexion; of a tube, the crook
line lies on that plane too.

In space a node begins at polar angle y / R of a circle with the piece's own radius R(x): for a tube R is its girth
over 2 pi, a panel lies on the limb. Chords are shorter than arcs by (angle between nodes)^2 / 24 of their length.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from etextile.errors import BadInput
from etextile.lattice.piece import Grid, Lattice, weave_piece
from etextile.lattice.weave import Weave
from etextile.types import Array, IntArray


@dataclass(frozen=True)
class Wrapping:
    """How a piece lies around a limb: length (mm) along it, centred on the hinge but for `offset`; radius by place.

    stations (S,), among them 0, and radii (S,) mm: of the piece along the limb's axis; around: extent of the whole
    piece along y at the joint, mm; closed: a tube.
    """

    length: float
    around: float
    stations: Array
    radii: Array
    closed: bool
    offset: float = 0.0

    def radius(self, axial: Array) -> Array:
        """Return the radius (n,) of the piece at places along the axis (n,), mm."""
        return np.interp(axial, self.stations, self.radii)

    def axial(self, x: Array) -> Array:
        """Return where along the axis places x (n,) of the piece lie, mm."""
        steps = np.hypot(np.diff(self.stations), np.diff(self.radii))
        length = np.concatenate([[0.0], np.cumsum(steps)])
        length -= np.interp(0.0, self.stations, length)
        return np.interp(x, length, self.stations)


@dataclass(frozen=True)
class Wrapped:
    """A lattice in material coordinates and the places (N, 3) mm where its nodes begin."""

    lattice: Lattice
    places: Array
    on_plane: Array
    """(N,) True for nodes on the plane of flexion that mirrors a half."""


def wrap(weave: Weave, wrapping: Wrapping, coarsening: float, *, half: bool) -> Wrapped:
    """Return a tube or panel of the nearest whole number of cells; raises BadInput when there is no whole cell."""
    extent = (wrapping.length, 0.5 * wrapping.around if half else wrapping.around)
    wanted = (coarsening * weave.cell_warp, coarsening * weave.cell_weft)
    cells = tuple(round(size / cell) for size, cell in zip(extent, wanted, strict=True))
    if cells[0] < 2 or cells[1] < (2 if half else 4):
        raise BadInput.of(
            f"coarsening {coarsening:g} leaves {cells[0]} x {cells[1]} cells in a piece of {extent[0]:g} x "
            f"{extent[1]:g} mm; take a smaller one",
            key="fabric.coarsening",
        )
    step = (extent[0] / cells[0], extent[1] / cells[1])
    start = (wrapping.offset - 0.5 * wrapping.length, 0.0 if half else -0.5 * wrapping.around)
    flat = weave_piece(weave, Grid(start, step, (cells[0], cells[1]), (False, half)))
    if wrapping.closed:
        flat = _sealed(flat) if half else _closed(flat, (cells[0], cells[1]))
    x, y = flat.points[:, 0], flat.points[:, 1]
    at_joint = float(wrapping.radius(np.zeros(1))[0])
    axial = wrapping.axial(x)
    own = wrapping.radius(axial)
    angle = y / at_joint
    places = np.stack([axial, own * np.sin(angle), own * np.cos(angle)], axis=1)
    mirrored = y == 0.0
    if wrapping.closed:
        mirrored |= np.isclose(y, 0.5 * wrapping.around)
    places[mirrored, 1] = 0.0
    return Wrapped(_tapered(flat, wrapping), places, mirrored if half else np.zeros(len(x), dtype=bool))


def _sealed(flat: Lattice) -> Lattice:
    """Return a half tube: its last line is no edge but lies on the plane of flexion."""
    edges = {**flat.edges, "y_max": np.zeros(len(flat.points), dtype=bool)}
    return replace(flat, edges=edges)


def _closed(flat: Lattice, cells: tuple[int, int]) -> Lattice:
    """Return a whole tube: its last line of nodes is the first one."""
    rows = cells[1] + 1
    number = np.arange(len(flat.points)).reshape(-1, rows)
    last = number[:, -1]
    merged = number.copy()
    merged[:, -1] = merged[:, 0]
    kept = np.setdiff1d(number.ravel(), last)
    renumber = np.full(len(flat.points), -1)
    renumber[kept] = np.arange(len(kept))
    to = renumber[merged.ravel()]
    trusses, area, chosen = _without_doubles(flat, number, to)
    share = flat.share.copy()
    share[merged[:, 0]] += share[last]
    return replace(
        flat,
        points=flat.points[kept],
        trusses=trusses,
        family=flat.family[chosen],
        rest_length=flat.rest_length[chosen],
        area=area,
        quads=to[flat.quads],
        edges={name: nodes[kept] & (name[0] == "x") for name, nodes in flat.edges.items()},
        share=share[kept],
    )


def _without_doubles(flat: Lattice, number: IntArray, to: IntArray) -> tuple[IntArray, Array, IntArray]:
    """Return trusses (M, 2), areas (M,) and which of the flat ones they are: warp lines of the seam are one."""
    first, last = np.zeros(len(flat.points), dtype=bool), np.zeros(len(flat.points), dtype=bool)
    first[number[:, 0]], last[number[:, -1]] = True, True
    double = last[flat.trusses].all(axis=1)
    area = flat.area.copy()
    area[first[flat.trusses].all(axis=1)] += area[double]
    chosen = np.flatnonzero(~double)
    return to[flat.trusses[chosen]], area[chosen], chosen


def _tapered(flat: Lattice, wrapping: Wrapping) -> Lattice:
    """Return the lattice with rest lengths as the piece is made: shorter around where it tapers."""
    at_joint = float(wrapping.radius(np.zeros(1))[0])
    ends = flat.points[flat.trusses]
    radius = wrapping.radius(wrapping.axial(ends[:, :, 0]))
    along = ends[:, 1, 0] - ends[:, 0, 0]
    apart = ends[:, 1, 1] - ends[:, 0, 1]
    if wrapping.closed:
        apart = np.mod(apart + 0.5 * wrapping.around, wrapping.around) - 0.5 * wrapping.around
    around = apart * radius.mean(axis=1) / at_joint
    return replace(flat, rest_length=np.hypot(along, around))
