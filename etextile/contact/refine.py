"""Facets to a smooth surface: a mesh is split into smaller triangles that follow its vertex normals.

A fabric pulled over flat facets would feel every edge. Edges flatter than the crease angle are therefore taken as
samples of a curved surface, sharper ones are kept. Each split puts the edge midpoint at

    (a + b) / 2 + (n_b . (b - a) n_b - n_a . (b - a) n_a) / 8

which is exact on a parabola whose end normals are n_a and n_b (Phong tessellation with shape factor 1/2: T. Boubekeur,
M. Alexa, ACM Trans. Graphics 27, 2008). The given vertices stay where they are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.types import Array, IntArray


CREASE_DEG = 40.0
"""Edges whose two triangles meet at more than this angle stay sharp."""

MOST_FACES = 300_000
"""Splitting stops before there are more triangles than this."""

MOST_ROUNDS = 16
"""Splitting stops after these; a round brings a curved edge four times closer, so that only torn meshes need more."""

PIECES: tuple[tuple[tuple[int, int, int], ...], ...] = (
    ((0, 1, 2),),
    ((0, 3, 2), (3, 1, 2)),
    ((0, 1, 4), (0, 4, 2)),
    ((3, 1, 4), (0, 3, 4), (0, 4, 2)),
    ((0, 1, 5), (5, 1, 2)),
    ((0, 3, 5), (3, 1, 2), (3, 2, 5)),
    ((4, 2, 5), (0, 1, 4), (0, 4, 5)),
    ((0, 3, 5), (1, 4, 3), (2, 5, 4), (3, 4, 5)),
)
"""Pieces of a triangle (0 1 2) by which of its edges are split: bit i for the midpoint 3 + i of edge i, i + 1."""


@dataclass(frozen=True)
class CurvedMesh:
    """Vertices (v, 3), triangles (f, 3) and a normal for each corner of each triangle (f, 3, 3)."""

    vertices: Array
    faces: IntArray
    corner_normals: Array


def refined(vertices: Array, faces: IntArray, *, tolerance: float, crease: float = CREASE_DEG) -> CurvedMesh:
    """Return a finer mesh of the smooth surface through a watertight one, watertight as well.

    Every edge further than `tolerance` mm from the surface is split, until there is none, the next round would
    exceed MOST_FACES triangles, or after MOST_ROUNDS. Edges that meet at more than `crease` deg stay sharp.
    """
    mesh = CurvedMesh(vertices, faces, corner_normals(vertices, faces, crease=crease))
    for _ in range(MOST_ROUNDS):
        finer = split(mesh, tolerance)
        if finer is None:
            break
        mesh = finer
    return mesh


def corner_normals(vertices: Array, faces: IntArray, *, crease: float = CREASE_DEG) -> Array:
    """Return the unit normal of the surface at each corner (f, 3, 3), shared across all edges that are no crease.

    Facet normals are weighted by e1 x e2 / (|e1|^2 |e2|^2), exact for vertices on a sphere (N. Max, J. Graphics
    Tools 4, 1999).
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    corner = vertices[faces]
    following, preceding = np.roll(corner, -1, axis=1) - corner, np.roll(corner, 1, axis=1) - corner
    squares = np.sum(following**2, axis=2) * np.sum(preceding**2, axis=2)
    weighted = np.cross(following, preceding) / np.maximum(squares, 1e-300)[:, :, None]
    one, two = smooth_neighbours(vertices, faces, crease=crease)
    count = faces.size
    links = coo_array((np.ones(len(one)), (one, two)), shape=(count, count))
    group = connected_components(links, directed=False)[1]
    total = np.zeros((int(group.max()) + 1, 3))
    np.add.at(total, group, weighted.reshape(-1, 3))
    return np.asarray(unit(total)[group].reshape(-1, 3, 3))


def smooth_neighbours(vertices: Array, faces: IntArray, *, crease: float = CREASE_DEG) -> tuple[IntArray, IntArray]:
    """Return pairs of corners (numbered 3 face + corner) that share a vertex across an edge that is no crease."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    normals = unit(np.cross(b - a, c - a))
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    forward, backward = _edge_keys(start, end, len(vertices)), _edge_keys(end, start, len(vertices))
    order = np.argsort(forward)
    place = np.minimum(np.searchsorted(forward, backward, sorter=order), len(order) - 1)
    twin = order[place]
    found = forward[twin] == backward
    bend = np.einsum("ij,ij->i", np.repeat(normals, 3, axis=0), normals[twin // 3])
    edge = np.flatnonzero(found & (bend > np.cos(np.radians(crease))))
    twin = twin[edge]
    return np.concatenate([edge, _next(edge)]), np.concatenate([_next(twin), twin])


def split(mesh: CurvedMesh, tolerance: float) -> CurvedMesh | None:
    """Return the mesh with every edge cut at its curved midpoint that lies more than `tolerance` mm off the edge.

    None when there is no such edge, or so many that there would be more than MOST_FACES triangles.
    """
    faces, count = mesh.faces, len(mesh.vertices)
    after = np.roll(faces, -1, axis=1)
    keys = _edge_keys(np.minimum(faces, after).reshape(-1), np.maximum(faces, after).reshape(-1), count)
    unique, number = np.unique(keys, return_inverse=True)
    ends = np.stack([unique // count, unique % count], axis=1)
    total = [np.bincount(number, weights=each) for each in midpoint_shifts(mesh).reshape(-1, 3).T]
    shift: Array = np.stack(total, axis=1) / np.bincount(number)[:, None]
    cut = np.linalg.norm(shift, axis=1) > tolerance
    if not cut.any() or len(faces) + cut[number].sum() > MOST_FACES:
        return None
    middle = mesh.vertices[ends[cut]].mean(axis=1) + shift[cut]
    name = np.cumsum(cut) - 1 + count
    number = number.reshape(-1, 3)
    nodes = np.concatenate([faces, name[number]], axis=1)
    halfway = unit(mesh.corner_normals + np.roll(mesh.corner_normals, -1, axis=1))
    normals = np.concatenate([mesh.corner_normals, halfway], axis=1)
    pattern = cut[number] @ np.array([1, 2, 4])
    chosen = [(np.flatnonzero(pattern == code), np.array(pieces)) for code, pieces in enumerate(PIECES)]
    return CurvedMesh(
        np.concatenate([mesh.vertices, middle]),
        np.concatenate([nodes[which][:, pieces].reshape(-1, 3) for which, pieces in chosen]),
        np.concatenate([normals[which][:, pieces].reshape(-1, 3, 3) for which, pieces in chosen]),
    )


def midpoint_shifts(mesh: CurvedMesh) -> Array:
    """Return how far the curved midpoint of each edge of each triangle lies off the straight one (f, 3, 3).

    Bounded by a tenth of the edge, which only normals of a badly shaped mesh exceed.
    """
    normals, after = mesh.corner_normals, np.roll(mesh.corner_normals, -1, axis=1)
    run = mesh.vertices[np.roll(mesh.faces, -1, axis=1)] - mesh.vertices[mesh.faces]
    rise = np.sum(after * run, axis=2)[..., None] * after - np.sum(normals * run, axis=2)[..., None] * normals
    longest = 0.1 * np.linalg.norm(run, axis=2)
    size = np.linalg.norm(rise, axis=2) / 8.0
    return np.asarray(rise / 8.0 * np.minimum(1.0, longest / np.maximum(size, 1e-300))[..., None])


def unit(vectors: Array) -> Array:
    """Return `vectors` (..., 3) divided by their length; zero vectors stay zero."""
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-300))


def _edge_keys(start: IntArray, end: IntArray, count: int) -> IntArray:
    """Return one whole number per directed edge."""
    return np.asarray(start * np.int64(count) + end)


def _next(corner: IntArray) -> IntArray:
    """Return the corner that follows within the same triangle."""
    return np.asarray(corner - corner % 3 + (corner + 1) % 3)
