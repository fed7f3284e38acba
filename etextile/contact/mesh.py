"""Body from a triangle mesh: read, checked with messages a person can act on, and baked into a smooth distance grid."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from etextile.contact import grid
from etextile.contact.body import Distance, evaluation_points, require
from etextile.contact.caps import capped
from etextile.contact.mesh_file import read_triangles
from etextile.errors import BadInput
from etextile.types import Array, IntArray


SMALLEST, LARGEST = 5.0, 2000.0
"""Longest side of a mesh's bounding box in mm outside of which its scale is doubted."""

NODES = 350_000
"""Size of a distance grid whose spacing is not given."""

MOST_NODES = 20_000_000
"""Largest distance grid that is accepted (160 MB)."""


@dataclass(frozen=True)
class MeshBody:
    """A closed triangle mesh with the smooth distance grid baked from it.

    notes: what was repaired. deviation: (v,) distance of each vertex from the zero level of the grid in mm, the error
    made by smoothing; its largest value is `worst_deviation`. The normal is the gradient of the interpolated gap: its
    length differs from one by the interpolation error, and clearly on the medial axis inside the body.
    """

    vertices: Array = field(repr=False)
    faces: IntArray = field(repr=False)
    grid: grid.DistanceGrid
    deviation: Array = field(repr=False)
    notes: tuple[str, ...] = ()

    @property
    def worst_deviation(self) -> float:
        """Return the largest distance (mm) of a mesh vertex from the surface that the fabric feels."""
        return float(self.deviation.max())

    def distance(self, points: Array) -> Distance:
        """Return the signed distance of `points` (n, 3); outside the grid a positive lower bound."""
        return self.grid.distance(evaluation_points(points))

    def surface(self) -> tuple[Array, IntArray]:
        """Return the mesh itself."""
        return self.vertices, self.faces

    def bounds(self) -> Array:
        """Return the box (2, 3) around the mesh."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    def support(self, direction: Array) -> float:
        """Return the maximum of x . direction over the zero level of the grid.

        Newton for direction = multiplier * normal and gap = 0 from the furthest vertex, which is kept as the answer
        where that leads nowhere (a flat or sharp top).
        """
        heights = self.vertices @ direction
        point = self.vertices[int(np.argmax(heights))].copy()
        multiplier = float(np.linalg.norm(direction))
        system, rest = np.zeros((4, 4)), np.zeros(4)
        for _ in range(20):
            found = self.distance(point[None])
            system[:3, :3], system[3, :3] = multiplier * found.hessian[0], found.normal[0]
            system[:3, 3] = found.normal[0]
            rest[:3], rest[3] = direction - multiplier * found.normal[0], -found.gap[0]
            step = np.linalg.lstsq(system, rest, rcond=1e-9)[0]
            point, multiplier = point + step[:3], multiplier + step[3]
            if np.abs(step[:3]).max() < 1e-10:
                break
        height = float(point @ direction)
        reach = self.grid.spacing * float(np.linalg.norm(direction))
        return height if abs(height - float(heights.max())) <= reach else float(heights.max())


def mesh_body(vertices: Array, faces: IntArray, *, grid_spacing: float | None = None) -> MeshBody:
    """Return the body of a closed mesh (mm) wound outward; the spacing is chosen by the size unless it is given."""
    spacing = automatic_spacing(vertices) if grid_spacing is None else checked_spacing(vertices, grid_spacing)
    baked = grid.baked(vertices, faces, spacing)
    return MeshBody(vertices, faces, baked, np.abs(baked.distance(vertices).gap))


def mesh(
    *, file: str | Path, scale: float = 1.0, cap_holes: bool = False, grid_spacing: float | None = None
) -> MeshBody:
    """Return the body of an STL, OBJ, PLY or 3MF `file` multiplied by `scale`, planar holes closed on request.

    Raises BadInput when the file cannot be read, is empty, open, in several pieces or of doubtful size, and when the
    grid spacing does not fit. Normals that point inward or disagree are repaired and noted.
    """
    if not (np.isfinite(scale) and scale > 0):
        require([(f"must be a positive factor (got {scale:g})", "scale")])
    vertices, faces, notes = prepared(Path(file), scale=scale, cap_holes=cap_holes)
    body = mesh_body(vertices, faces, grid_spacing=grid_spacing)
    return MeshBody(body.vertices, body.faces, body.grid, body.deviation, notes)


def automatic_spacing(vertices: Array, nodes: int = NODES) -> float:
    """Return the spacing (mm) at which the padded grid has about so many nodes."""
    extent = np.ptp(vertices, axis=0)
    spacing = float(np.cbrt(np.prod(extent) / nodes))
    for _ in range(20):
        spacing = float(np.cbrt(np.prod(extent + 2 * grid.PADDING * spacing) / nodes))
    return float(f"{spacing:.3g}")


def checked_spacing(vertices: Array, spacing: float) -> float:
    """Return `spacing`; raises BadInput when it is too coarse for the body or too fine for the memory."""
    extent = np.ptp(vertices, axis=0)
    if not (np.isfinite(spacing) and spacing > 0):
        require([(f"must be a positive length (got {spacing:g})", "grid_spacing")])
    coarsest = float(extent.min()) / 6.0
    if spacing > coarsest:
        text = f"is too coarse for a body {extent.min():.3g} mm thin (got {spacing:g} mm)"
        require([(f"{text}, use at most {coarsest:.2g} mm", "grid_spacing")])
    if np.prod(np.array(grid.grid_shape(vertices, spacing), dtype=float)) > MOST_NODES:
        finest = automatic_spacing(vertices) * np.cbrt(NODES / MOST_NODES)
        text = f"gives a grid of more than {MOST_NODES // 10**6} million nodes (got {spacing:g} mm)"
        require([(f"{text}, use at least {finest:.2g} mm", "grid_spacing")])
    return float(spacing)


def prepared(file: Path, *, scale: float = 1.0, cap_holes: bool = False) -> tuple[Array, IntArray, tuple[str, ...]]:
    """Return vertices (mm) and triangles of a closed body from a file, with notes on what was repaired.

    Raises BadInput when the file cannot be read, is empty, open, in several pieces or of doubtful size.
    """
    vertices, faces, welds = read_triangles(file)
    vertices, caps = scale * vertices, tuple[str, ...]()
    if cap_holes:
        vertices, faces, caps = capped(vertices, faces, name=str(file))
    vertices, faces, notes = checked(vertices, faces, name=str(file), scale=scale)
    return vertices, faces, (*welds, *caps, *notes)


def checked(
    vertices: Array, faces: IntArray, *, name: str, scale: float = 1.0
) -> tuple[Array, IntArray, tuple[str, ...]]:
    """Return a closed mesh in one piece and wound outward, with notes on what was repaired; else raises BadInput."""
    if not len(faces):
        text = "none of its triangles has an area: the file is damaged, or its points lie closer than single precision"
        raise BadInput.of(f"{text}; export it again", file=name)
    size = float(np.ptp(vertices[np.unique(faces)], axis=0).max())
    if not SMALLEST <= size <= LARGEST:
        raise BadInput.of(_scale_message(size, scale), file=name, key="body.scale")
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    uses = np.unique(edges, axis=0, return_counts=True)[1]
    if (uses != 2).any():
        text = f"is not watertight: {np.sum(uses == 1)} open edges, {np.sum(uses > 2)} edges of more than two triangles"
        remedy = "close the holes and remove inner walls in a mesh editor"
        if not (uses > 2).any():
            remedy = "close the holes in a mesh editor; planar ones, as a scan of a limb has, with cap_holes: true"
        raise BadInput.of(f"{text}; {remedy}", file=name)
    pieces = _pieces(faces)
    if pieces > 1:
        text = f"consists of {pieces} separate closed surfaces; keep one or join them in a mesh editor"
        raise BadInput.of(text, file=name)
    faces, notes = wound_outward(vertices, faces, name=name)
    return vertices, faces, notes


def _scale_message(size: float, scale: float) -> str:
    """Return what to say of a mesh whose longest side is `size` mm."""
    units = {"millimetres": 1.0, "metres": 1000.0, "inches": 25.4, "centimetres": 10.0, "micrometres": 0.001}
    likely = [(unit, factor) for unit, factor in units.items() if 30.0 <= size / scale * factor <= 1000.0]
    advice = "set scale so that its length becomes millimetres"
    if likely:
        advice = f"the file seems to be in {likely[0][0]}: set scale to {likely[0][1]:g}"
    return f"the mesh is {size:.6g} mm long with scale {scale:g}, expected {SMALLEST:g} to {LARGEST:g} mm; {advice}"


def _sharing(faces: IntArray) -> tuple[IntArray, IntArray, IntArray]:
    """Return the two sides of every edge of a closed mesh as places in `faces.reshape(-1)`, and where sides start."""
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    order = np.lexsort((np.maximum(start, end), np.minimum(start, end)))
    return order[::2], order[1::2], start


def _pieces(faces: IntArray) -> int:
    """Return in how many pieces a closed mesh is: triangles that share an edge belong together."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    one, two, _ = _sharing(faces)
    links = coo_array((np.ones(len(one)), (one // 3, two // 3)), shape=(len(faces), len(faces)))
    return int(connected_components(links, directed=False, return_labels=False))


def wound_outward(vertices: Array, faces: IntArray, *, name: str) -> tuple[IntArray, tuple[str, ...]]:
    """Return triangles that all wind outward, and notes on what had to be turned; `faces` is closed, in one piece.

    Neighbours agree when they run through their common edge in opposite directions; a walk over all triangles turns
    those that do not. Raises BadInput for a one-sided surface.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import breadth_first_order

    one, two, start = _sharing(faces)
    agree = start[one] != start[two]
    turned = np.zeros(len(faces), dtype=bool)
    if not agree.all():
        links = coo_array((2.0 - agree, (one // 3, two // 3)), shape=(len(faces), len(faces))).tocsr()
        links = links + links.T
        visited, parent = breadth_first_order(links, 0, directed=False)
        for f in visited[1:]:
            turned[f] = turned[parent[f]] ^ (links[f, parent[f]] > 1.5)
        if np.any(turned[one // 3] ^ turned[two // 3] ^ ~agree):
            raise BadInput.of("is a one-sided surface, its inside is not defined; model it again", file=name)
        faces = np.where(turned[:, None], faces[:, ::-1], faces)
    corners = vertices[faces]
    volume = float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])))
    notes = []
    if volume < 0:
        faces, turned = faces[:, ::-1], ~turned
    if turned.all():
        notes.append("the mesh was inside out: all normals were turned outward")
    elif turned.any():
        notes.append(f"{turned.sum()} of {len(faces)} triangles pointed inward and were turned outward")
    return np.ascontiguousarray(faces), tuple(notes)
