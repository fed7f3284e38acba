"""A piece cut from the lattice: coupons and specimens with the warp at any angle to x, circles, convex polygons.

Each family of trusses is a set of parallel yarns of one spacing. A yarn is cut where it crosses an edge and gets a node
exactly on the edge line. It carries what its tributary width says: the part of the piece that its strip covers, over
spacing and length kept. So a yarn along an edge carries half, a yarn well inside one, what a yarn outside still covers
inside is carried by the next one, and no fabric is lost with loose ends: leaving them off without that makes a strip of
eight cells 7 % too soft. At multiples of 90 degrees the piece is divided into whole cells as usual.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from etextile.errors import BadInput
from etextile.lattice.edge_cells import edge_cells
from etextile.lattice.piece import EDGES, Lattice, divide, weave_piece
from etextile.lattice.shape import OUTLINE, Outlined, Rectangle, Shape
from etextile.lattice.weave import DIAGONAL, WARP, WEFT, Weave
from etextile.types import Array, BoolArray, IntArray
from etextile.vocabulary import PORTIONS


SNAP = 0.02
"""Nodes this close to an edge line, in cells, are moved onto it: no slivers."""
FAMILIES = ((WARP, (1, 0)), (WEFT, (0, 1)), (DIAGONAL, (1, 1)), (DIAGONAL, (1, -1)))
"""Families with the lattice step of a truss; every lattice node is the start of one truss of each."""
MOST = 2.0
"""A yarn stands for at most so many: short ones at corners would become lumps."""
NO_NODE = np.iinfo(np.int32).min
"""Lattice index of cut ends, which are none of the lattice's nodes."""


def cut_piece(
    weave: Weave,
    size: tuple[float, float],
    *,
    coarsening: float,
    warp_angle: float,
    held: Collection[str] = EDGES,
) -> Lattice:
    """Return the rectangle of `size` (mm) centred at the origin with the warp at `warp_angle` degrees to x.

    Yarn ends at edges that are not `held` carry nothing and are left off; `edges` then marks the nodes they hung on.
    Raises BadInput when the coarsening leaves no whole cell.
    """
    quarters = round(warp_angle / 90.0)
    if abs(warp_angle - 90.0 * quarters) < 1e-9:
        along = size if quarters % 2 == 0 else (size[1], size[0])
        return _turned(weave_piece(weave, divide(weave, along, coarsening, "whole")), quarters, warp_angle)
    step = (coarsening * weave.cell_warp, coarsening * weave.cell_weft)
    half = (0.5 * size[0], 0.5 * size[1])
    piece = Rectangle(half)
    frames = [Frame(step, np.radians(warp_angle), piece, (i, j)) for i in (0.0, 0.5) for j in (0.0, 0.5)]
    lattice = cut_frame(weave, min(frames, key=lambda frame: frame.misfit), held=held)
    if len(lattice.quads) == 0:
        message = f"coarsening {coarsening:g} leaves no whole cell in a piece of {size[0]:g} x {size[1]:g} mm"
        raise BadInput.of(f"{message} with the warp at {warp_angle:g} deg", key="fabric.coarsening")
    return replace(lattice, warp_angle=warp_angle)


def cut_outline(weave: Weave, shape: Outlined, *, coarsening: float, warp_angle: float, portion: str) -> Lattice:
    """Return a piece with a clamped outline, the warp at `warp_angle` degrees to x; a lattice node is in the origin.

    A quarter or half (with the warp along x or y) is the part at x >= 0 (and y >= 0), yarns in its planes with half
    their area. Raises BadInput when the coarsening leaves no whole cell.
    """
    step = (coarsening * weave.cell_warp, coarsening * weave.cell_weft)
    whole = cut_frame(weave, Frame(step, np.radians(warp_angle), shape), held=(OUTLINE,))
    if len(whole.quads) == 0:
        message = f"coarsening {coarsening:g} leaves no whole cell in a piece that reaches {shape.reach:g} mm"
        raise BadInput.of(message, key="fabric.coarsening")
    return halved(replace(whole, warp_angle=warp_angle), PORTIONS[portion])


def halved(lattice: Lattice, planes: tuple[bool, bool]) -> Lattice:
    """Return the part of a lattice at x >= 0 and/or y >= 0, whose planes no truss may cross."""
    points = lattice.points
    keep, halves = np.ones(len(points), dtype=np.bool_), np.ones(len(points))
    area, share = lattice.area.copy(), lattice.share.copy()
    for axis in np.flatnonzero(planes):
        on = np.abs(points[:, axis]) < 1e-9 * float(np.ptp(points[:, axis]))
        points = np.where(on[:, None] & (np.arange(3) == axis), 0.0, points)
        keep &= points[:, axis] >= 0.0
        area *= np.where(on[lattice.trusses].all(axis=1), 0.5, 1.0)
        halves *= np.where(on, 0.5, 1.0)
    new = np.cumsum(keep) - 1
    trusses, quads, sides = (keep[nodes].all(axis=1) for nodes in (lattice.trusses, lattice.quads, lattice.edge_cells))
    return replace(
        lattice,
        points=points[keep],
        trusses=new[lattice.trusses[trusses]],
        family=lattice.family[trusses],
        rest_length=lattice.rest_length[trusses],
        area=area[trusses],
        quads=new[lattice.quads[quads]],
        edge_cells=new[lattice.edge_cells[sides]],
        edges={name: mask[keep] for name, mask in lattice.edges.items()},
        share=(share * halves)[keep],
        symmetry=planes,
        cells=(lattice.cells[0] // (1 + planes[0]), lattice.cells[1] // (1 + planes[1])),
    )


@dataclass(frozen=True)
class Frame:
    """Lattice and piece: steps (mm) along warp and weft, angle of the warp (rad), shape of the piece.

    `offset`: place of a lattice node from the centre of the piece, in steps.
    """

    step: tuple[float, float]
    angle: float
    shape: Shape
    offset: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def axes(self) -> Array:
        """Steps along warp and weft as rows (2, 2), mm."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.asarray(np.array([[c, s], [-s, c]]) * np.array(self.step)[:, None])

    @cached_property
    def index(self) -> IntArray:
        """Indices (k, 2) of all nodes that may lie in the piece, and some more around it."""
        reach = np.ceil(self.shape.reach / np.array(self.step)).astype(np.int64) + 2
        i, j = (np.arange(-count, count + 1) for count in reach)
        return np.stack([np.repeat(i, len(j)), np.tile(j, len(i))], axis=1)

    def places(self, index: IntArray) -> Array:
        """Return places (k, 2), mm, of lattice indices (k, 2); near an edge line exactly on it."""
        return self.shape.snapped((index + np.array(self.offset)) @ self.axes, SNAP * min(self.step))

    @property
    def misfit(self) -> float:
        """Width of fabric (mm) held or free wrongly at the corners of a rectangle, which a yarn passes or not.

        Yarns up to |h1 n1 - h2 n2| from the centre end on the same two edges, those beyond on another pair. A corner
        midway between two yarns suits both; which yarns lie where is up to the offset.
        """
        found = 0.0
        half = self.shape.half if isinstance(self.shape, Rectangle) else (0.0, 0.0)
        for way, offset in zip(self.axes, self.offset[::-1], strict=True):
            spacing = abs(float(np.linalg.det(self.axes))) / float(np.hypot(*way))
            across = np.abs(way[::-1]) / np.hypot(*way) * np.array(half)
            reach = abs(float(across[0] - across[1])) / spacing
            count = np.floor(reach - offset) - np.ceil(-reach - offset) + 1.0
            found += spacing * abs(float(count) - 2.0 * reach)
        return found


@dataclass(frozen=True)
class Yarns:
    """Trusses of one family and direction inside the piece, cut by its edges.

    ends (m, 2, 2) mm; index (m, 2, 2) of the ends in the lattice; cut (m, 2): ends that are none of its nodes;
    family (m,); line (m,): number of the yarn, in the order of `covered` (mm2), what each yarn's strip covers;
    spacing mm of the yarns.
    """

    ends: Array
    index: IntArray
    cut: BoolArray
    family: int
    line: IntArray
    covered: Array
    spacing: float


def cut_frame(weave: Weave, frame: Frame, *, held: Collection[str]) -> Lattice:
    """Return the lattice of a frame cut by its piece."""
    parts = [_yarns(frame, family, step) for family, step in FAMILIES]
    points, trusses, index = _numbered(parts)
    edges = frame.shape.edges(points)
    keep = _without_loose_ends(trusses, edges, held)
    length = np.linalg.norm(points[trusses[:, 1]] - points[trusses[:, 0]], axis=1)
    splits = np.cumsum([len(part.line) for part in parts])[:-1]
    strips = zip(parts, np.split(length * keep, splits), strict=True)
    width = np.concatenate([part.spacing * _weights(part, kept)[part.line] for part, kept in strips])
    family = np.repeat([part.family for part in parts], [len(part.line) for part in parts])
    keep &= width > 0.0
    used, numbered = np.unique(trusses[keep], return_inverse=True)
    new = np.full(len(points), -1)
    new[used] = np.arange(len(used))
    sides = _sides(parts, new[trusses], keep, skipping=isinstance(frame.shape, Outlined))
    trusses, points, index = numbered.reshape(-1, 2), points[used], index[used]
    length, width, family = length[keep], width[keep], family[keep]
    inner = index[index[:, 0] != NO_NODE]
    columns, rows = np.ptp(inner, axis=0) if len(inner) else (0, 0)
    quads = _cells(index)
    return Lattice(
        points=np.column_stack([points, np.zeros(len(points))]),
        trusses=trusses,
        family=family,
        rest_length=length,
        area=weave.truss_area * weave.thickness * width / np.array(weave.nominal_area)[family],
        quads=quads,
        edge_cells=_not_whole(sides, quads),
        edges={name: mask[used] for name, mask in edges.items()},
        share=_share(frame, trusses, np.where(family == DIAGONAL, 0.0, width * length), count=len(points)),
        symmetry=(False, False),
        cells=(int(columns), int(rows)),
        coarsening=(frame.step[0] / weave.cell_warp, frame.step[1] / weave.cell_weft),
        warp_angle=float(np.degrees(frame.angle)),
    )


def _yarns(frame: Frame, family: int, step: tuple[int, int]) -> Yarns:
    """Return one family of trusses cut by the piece, and what the strip of each of its yarns covers."""
    index = np.stack([frame.index, frame.index + np.array(step)], axis=1)
    places = np.stack([frame.places(index[:, k]) for k in (0, 1)], axis=1)
    start, stop = frame.shape.inside(places[:, 0], places[:, 1])
    kept = stop - start > 1e-9
    ends = np.stack([frame.shape.between(places[kept], share[kept]) for share in (start, stop)], axis=1)
    way = np.array(step) @ frame.axes
    spacing = float(abs(np.linalg.det(frame.axes)) / np.hypot(*way))
    normal = np.array([-way[1], way[0]]) / np.hypot(*way)
    line = frame.index @ np.array([-step[1], step[0]])
    origin = float(normal @ (np.array(frame.offset) @ frame.axes))
    distance = origin + spacing * np.arange(line.min(), line.max() + 1)
    covered = frame.shape.area_below(distance + 0.5 * spacing, normal)
    covered = covered - frame.shape.area_below(distance - 0.5 * spacing, normal)
    cut = np.stack([start > 0.0, stop < 1.0], axis=1)[kept]
    return Yarns(ends, index[kept], cut, family, line[kept] - line.min(), covered, spacing)


def _weights(yarns: Yarns, length: Array) -> Array:
    """Return for each yarn how many it stands for: covered area over spacing and kept length; trusses' `length` (m,).

    A yarn of which less than its spacing is kept, at a corner, is left out; its strip goes to the next yarn, as do
    those of yarns outside.
    """
    kept = np.bincount(yarns.line, weights=length, minlength=len(yarns.covered))
    lines = np.flatnonzero(kept >= yarns.spacing)
    weight = np.zeros(len(kept))
    if len(lines):
        low, high = int(lines[0]), int(lines[-1])
        covered = yarns.covered[low : high + 1].copy()
        covered[0] += yarns.covered[:low].sum()
        covered[-1] += yarns.covered[high + 1 :].sum()
        _hand_inwards(covered, np.asarray(MOST * yarns.spacing * kept[low : high + 1]))
        weight[lines] = covered[lines - low] / (yarns.spacing * kept[lines])
    return weight


def _hand_inwards(covered: Array, most: Array) -> None:
    """Hand what yarns (k,) cover beyond `most` (k,) to their inner neighbours, from both sides to the middle."""
    middle = len(covered) // 2
    for start, way in ((0, 1), (len(covered) - 1, -1)):
        for line in range(start, middle, way):
            excess = max(covered[line] - most[line], 0.0)
            covered[line] -= excess
            covered[line + way] += excess


def _numbered(parts: Sequence[Yarns]) -> tuple[Array, IntArray, IntArray]:
    """Return points (n, 2), trusses (m, 2), and the lattice index (n, 2) of the points, NO_NODE for cut ends."""
    ends = np.concatenate([part.ends for part in parts]).reshape(-1, 2)
    cut = np.concatenate([part.cut for part in parts]).ravel()
    index = np.concatenate([part.index for part in parts]).reshape(-1, 2)
    known, first, number = np.unique(index[~cut], axis=0, return_index=True, return_inverse=True)
    node = np.empty(len(cut), dtype=np.int64)
    node[~cut] = number.reshape(-1)
    node[cut] = len(known) + np.arange(np.count_nonzero(cut))
    points = np.concatenate([ends[~cut][first], ends[cut]])
    return points, node.reshape(-1, 2), np.concatenate([known, np.full((np.count_nonzero(cut), 2), NO_NODE)])


def _sides(parts: Sequence[Yarns], trusses: IntArray, kept: BoolArray, *, skipping: bool) -> IntArray:
    """Return the cells that an edge cuts, from the warp and weft trusses (the first two parts).

    `skipping`: cells with a side that was left off are closed without it, so that an outline is covered all round.
    """
    yarns = parts[:2]
    count = sum(len(part.line) for part in yarns)
    start = np.concatenate([part.index[:, 0] for part in yarns])
    direction = np.repeat([0, 1], [len(part.line) for part in yarns])
    return edge_cells(start, direction, trusses[:count], kept=kept[:count], skipping=skipping)


def _not_whole(cells: IntArray, whole: IntArray) -> IntArray:
    """Return the cells (q, 4) that are none of the whole ones: a side that was left off does not cut a cell."""
    known = {frozenset(cell) for cell in whole.tolist()}
    return np.array([cell for cell in cells.tolist() if frozenset(cell) not in known], np.int64).reshape(-1, 4)


def _without_loose_ends(trusses: IntArray, edges: dict[str, BoolArray], held: Collection[str]) -> BoolArray:
    """Return which trusses (m,) do not end loosely; nodes that lose one are marked in the masks of its edges."""
    keep = np.ones(len(trusses), dtype=np.bool_)
    fast = np.any([edges[name] for name in held], axis=0) if held else np.zeros(len(edges["x_min"]), dtype=np.bool_)
    while True:
        count = np.bincount(trusses[keep].ravel(), minlength=len(fast))
        loose = ((count == 1) & ~fast)[trusses] & keep[:, None]
        gone = loose.any(axis=1)
        if not gone.any():
            return keep
        for name in (name for name in edges if name not in held):
            edges[name][trusses[gone & edges[name][trusses].any(axis=1)]] = True
        keep &= ~gone


def _cells(index: IntArray) -> IntArray:
    """Return the whole cells (q, 4) as nodes in turn, from the lattice index (n, 2) of the nodes."""
    nodes = np.flatnonzero(index[:, 0] != NO_NODE)
    if len(nodes) == 0:
        return np.zeros((0, 4), dtype=np.int64)
    low = index[nodes].min(axis=0)
    number = np.full(np.ptp(index[nodes], axis=0) + 2, -1, dtype=np.int64)
    number[tuple((index[nodes] - low).T)] = nodes
    rings = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    return np.asarray(rings[rings.min(axis=1) >= 0])


def _share(frame: Frame, trusses: IntArray, covered: Array, *, count: int) -> Array:
    """Return the part (n,) of a full node's tributary area: mean over warp and weft of half of what they cover (m,)."""
    lumped = np.bincount(trusses.ravel(), weights=np.repeat(0.25 * covered, 2), minlength=count)
    return np.asarray(lumped / (frame.step[0] * frame.step[1]))


def _turned(lattice: Lattice, quarters: int, angle: float) -> Lattice:
    """Return a lattice turned by quarter turns about its centre; the names of its edges turn with it."""
    turns = quarters % 4
    points, edges = lattice.points, lattice.edges
    for _ in range(turns):
        points = np.column_stack([-points[:, 1], points[:, 0], points[:, 2]])
        edges = {"x_min": edges["y_max"], "x_max": edges["y_min"], "y_min": edges["x_min"], "y_max": edges["x_max"]}
    return replace(lattice, points=points, edges=edges, warp_angle=angle)
