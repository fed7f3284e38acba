"""A rectangular piece of fabric with the warp along x, as a lattice of trusses at any coarsening.

One lattice cell stands for coarsening x coarsening fabric cells. Areas go by tributary width, so a line on a cut edge
or on a symmetry plane carries half of what an inner line carries and any coarsening has the same stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from etextile.errors import BadInput
from etextile.lattice.weave import DIAGONAL, WARP, WEFT, Weave
from etextile.types import Array, BoolArray, IntArray
from etextile.vocabulary import PORTIONS


EDGES = ("x_min", "x_max", "y_min", "y_max")


@dataclass(frozen=True)
class Lattice:
    """Nodes and trusses of a piece of fabric.

    points (N, 3) mm, flat at z = 0; trusses (M, 2) node numbers; family (M,); rest_length (M,) mm; area (M,) mm2;
    quads (Q, 4) whole lattice cells; edge_cells (K, 4) cut ones, for drawing only; edges: name to node mask (N,);
    share (N,): part of a full node's tributary area; symmetry (2,): whether x = 0 and y = 0 are symmetry planes; cells:
    number along warp and weft; coarsening along warp and weft as built.
    """

    points: Array
    trusses: IntArray
    family: IntArray
    rest_length: Array
    area: Array
    quads: IntArray
    edges: dict[str, BoolArray]
    share: Array
    symmetry: tuple[bool, bool]
    cells: tuple[int, int]
    coarsening: tuple[float, float]
    warp_angle: float = 0.0
    notes: tuple[str, ...] = field(default=())
    edge_cells: IntArray = field(default_factory=lambda: np.zeros((0, 4), dtype=np.int64))

    @property
    def cell_area(self) -> float:
        """Area of the piece over its nodes' shares: the fabric a full node stands for, mm2."""
        if "outline" in self.edges:
            corners = self.points[self.quads[0]]
            return float(np.linalg.norm(np.cross(corners[1] - corners[0], corners[3] - corners[0])))
        extent = np.ptp(self.points[:, :2], axis=0)
        return float(extent[0] * extent[1] / self.share.sum())

    @property
    def multiplicity(self) -> int:
        """How many copies of the modelled part make the whole specimen."""
        return 1 << sum(self.symmetry)


@dataclass(frozen=True)
class Grid:
    """Extent and division of a piece with the warp along x."""

    start: tuple[float, float]
    step: tuple[float, float]
    cells: tuple[int, int]
    symmetry: tuple[bool, bool]

    @property
    def lines(self) -> tuple[Array, Array]:
        """Coordinates of the lattice lines along x and y, mm."""
        x = self.start[0] + self.step[0] * np.arange(self.cells[0] + 1.0)
        y = self.start[1] + self.step[1] * np.arange(self.cells[1] + 1.0)
        return x, y


def divide(weave: Weave, size: tuple[float, float], coarsening: float, portion: str) -> Grid:
    """Divide a piece of the given size (mm) into the nearest whole number of cells.

    Raises BadInput when the coarsening leaves less than one cell in a direction.
    """
    symmetry = PORTIONS[portion]
    extent = tuple(0.5 * full if cut else full for full, cut in zip(size, symmetry, strict=True))
    wanted = (coarsening * weave.cell_warp, coarsening * weave.cell_weft)
    cells = tuple(round(length / cell) for length, cell in zip(extent, wanted, strict=True))
    if min(cells) < 1:
        most = min(extent[0] / weave.cell_warp, extent[1] / weave.cell_weft)
        raise BadInput.of(
            f"coarsening {coarsening:g} leaves no whole cell in a piece of {extent[0]:g} x {extent[1]:g} mm; "
            f"at most {most:.4g}",
            key="fabric.coarsening",
        )
    start = tuple(0.0 if cut else -0.5 * full for full, cut in zip(size, symmetry, strict=True))
    step = (extent[0] / cells[0], extent[1] / cells[1])
    return Grid((start[0], start[1]), step, (cells[0], cells[1]), symmetry)


def weave_piece(weave: Weave, grid: Grid) -> Lattice:
    """Return the lattice of a piece whose warp runs along x; nodes are numbered with y running fastest."""
    x, y = grid.lines
    columns, rows = len(x), len(y)
    number = np.arange(columns * rows).reshape(columns, rows)
    points = np.stack([np.repeat(x, rows), np.tile(y, columns), np.zeros(columns * rows)], axis=1)
    width_x, width_y = (_tributary(size, step) for size, step in zip((columns, rows), grid.step, strict=True))
    warp_area = weave.truss_area * width_y / weave.cell_weft
    weft_area = weave.truss_area * width_x / weave.cell_warp
    diagonal = float(np.hypot(*grid.step))
    in_cell = grid.step[0] * grid.step[1] / (weave.cell_warp * weave.cell_weft)
    diagonal_area = weave.truss_area * in_cell * weave.cell_diagonal / diagonal
    pieces = (
        (number[:-1, :], number[1:, :], WARP, np.broadcast_to(warp_area, (columns - 1, rows))),
        (number[:, :-1], number[:, 1:], WEFT, np.broadcast_to(weft_area[:, None], (columns, rows - 1))),
        (number[:-1, :-1], number[1:, 1:], DIAGONAL, np.full((columns - 1, rows - 1), diagonal_area)),
        (number[:-1, 1:], number[1:, :-1], DIAGONAL, np.full((columns - 1, rows - 1), diagonal_area)),
    )
    trusses = np.concatenate([np.stack([a.ravel(), b.ravel()], axis=1) for a, b, _, _ in pieces])
    family = np.concatenate([np.full(a.size, name) for a, _, name, _ in pieces])
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    return Lattice(
        points=points,
        trusses=trusses,
        family=family,
        rest_length=np.linalg.norm(points[trusses[:, 1]] - points[trusses[:, 0]], axis=1),
        area=np.concatenate([area.ravel() for *_, area in pieces]),
        quads=quads,
        edges=_edges(points, x, y, grid.symmetry),
        share=np.outer(width_x / grid.step[0], width_y / grid.step[1]).ravel(),
        symmetry=grid.symmetry,
        cells=grid.cells,
        coarsening=(grid.step[0] / weave.cell_warp, grid.step[1] / weave.cell_weft),
    )


def _tributary(lines: int, step: float) -> Array:
    width = np.full(lines, step)
    width[[0, -1]] *= 0.5
    return width


def _edges(points: Array, x: Array, y: Array, symmetry: tuple[bool, bool]) -> dict[str, BoolArray]:
    """Return the nodes of every real edge; an edge on a symmetry plane is no edge."""
    edges = {
        "x_min": points[:, 0] == x[0],
        "x_max": points[:, 0] == x[-1],
        "y_min": points[:, 1] == y[0],
        "y_max": points[:, 1] == y[-1],
    }
    for cut, name in zip(symmetry, ("x_min", "y_min"), strict=True):
        if cut:
            edges[name] = np.zeros(len(points), dtype=bool)
    return edges
