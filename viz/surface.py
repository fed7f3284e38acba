"""The lattice seen as a surface: cells as quadrilaterals, truss values on them, places on them, clamped sides."""

from __future__ import annotations

import numpy as np

from etextile.errors import EtextileError
from etextile.types import Array, BoolArray, IntArray


SIDES = ("x_min", "x_max", "y_min", "y_max")


def quads_of(points: Array, warp: IntArray, weft: IntArray) -> IntArray:
    """Return the cells (q, 4) between warp and weft trusses, each (k, 2), of a flat lattice (n, >=2)."""
    ahead, aside = _successor(points, warp), _successor(points, weft)
    corner = np.flatnonzero((ahead >= 0) & (aside >= 0))
    across, along = aside[ahead[corner]], ahead[aside[corner]]
    closed = (across >= 0) & (across == along)
    first = corner[closed]
    return np.stack([first, ahead[first], across[closed], aside[first]], axis=1)


def _successor(points: Array, trusses: IntArray) -> IntArray:
    """Return for each point the one that follows along a family of parallel trusses, or -1 at the end."""
    following = np.full(len(points), -1, dtype=np.int64)
    if len(trusses):
        step = points[trusses[:, 1], :2] - points[trusses[:, 0], :2]
        backwards = step @ step[0] < 0.0
        start, end = np.where(backwards, trusses[:, ::-1].T, trusses.T)
        following[start] = end
    return following


def cell_values(quads: IntArray, trusses: IntArray, values: Array, *, n_points: int, largest: bool = False) -> Array:
    """Return for each cell (q,) the mean (or the largest) over those of the given trusses that lie on it."""
    key = np.sort(trusses, axis=1) @ np.array([n_points, 1])
    order = np.argsort(key)
    pairs = quads[:, [0, 1, 1, 2, 2, 3, 3, 0, 0, 2, 1, 3]].reshape(-1, 6, 2)
    wanted = np.sort(pairs, axis=2) @ np.array([n_points, 1])
    place = np.minimum(np.searchsorted(key[order], wanted), max(len(key) - 1, 0))
    if not len(key):
        return np.zeros(len(quads))
    found = key[order][place] == wanted
    if largest:
        own = np.where(found, values[order][place], -np.inf).max(axis=1)
    else:
        own = np.where(found, values[order][place], 0.0).sum(axis=1) / np.maximum(found.sum(axis=1), 1)
    return np.where(found.any(axis=1), own, _around(quads, trusses, values, n_points=n_points))


def _around(quads: IntArray, trusses: IntArray, values: Array, *, n_points: int) -> Array:
    """Return for each cell (q,) the mean over the trusses that end at its corners, for cut cells without an own one."""
    ends = trusses.ravel()
    total = np.bincount(ends, weights=np.repeat(values, 2), minlength=n_points)[quads].sum(axis=1)
    count = np.bincount(ends, minlength=n_points)[quads].sum(axis=1)
    return np.asarray(total / np.maximum(count, 1))


def shear_angle(points: Array, quads: IntArray) -> Array:
    """Return by how much the angle between the middle lines of each cell (q,) is less than a right one, radians."""
    a, b, c, d = (points[quads[:, corner]] for corner in range(4))
    along, across = b + c - a - d, d + c - a - b
    size = np.linalg.norm(along, axis=1) * np.linalg.norm(across, axis=1)
    return np.asarray(np.arcsin(np.clip(np.einsum("qi,qi->q", along, across) / np.maximum(size, 1e-30), -1.0, 1.0)))


def at(flat: Array, quads: IntArray, places: Array, values: Array) -> Array:
    """Return point values (n, d) at places (p, 2) of the flat fabric, bilinear in the cell that holds each place.

    Cells are parallelograms. A place outside takes the value at the nearest cell's edge.
    """
    from scipy.spatial import cKDTree

    if not len(quads):
        raise EtextileError("the lattice has no cells to find a place in")
    corners = flat[quads, :2]
    along, aside = corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]
    _, near = cKDTree(corners.mean(axis=1)).query(places, k=min(5, len(quads)))
    near = np.asarray(near).reshape(len(places), -1)
    frame = np.stack([along, aside], axis=-1)[near]
    local = np.linalg.solve(frame, (places[:, None] - corners[near, 0])[..., None])[..., 0]
    outside = np.abs(local - 0.5).max(axis=-1)
    best = np.argmin(outside, axis=1)
    row = np.arange(len(places))
    u, v = np.clip(local[row, best], 0.0, 1.0).T
    weights = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=1)
    return np.asarray(np.einsum("pc,pcd->pd", weights, values[quads[near[row, best]]]))


def boundary(quads: IntArray) -> IntArray:
    """Return the sides (e, 2) that belong to one cell only."""
    sides = np.sort(quads[:, [0, 1, 1, 2, 2, 3, 3, 0]].reshape(-1, 2), axis=1)
    sides = sides[sides[:, 0] != sides[:, 1]]
    found, count = np.unique(sides, axis=0, return_counts=True)
    return np.asarray(found[count == 1])


def clamped_sides(flat: Array, quads: IntArray, clamped: BoolArray) -> dict[str, tuple[float, float]]:
    """Return the sides of the bounding rectangle that are clamped, each with the range held along it, mm."""
    low, high = flat[:, :2].min(axis=0), flat[:, :2].max(axis=0)
    tolerance = 1e-6 * float(np.max(high - low))
    edges = boundary(quads)
    held = flat[edges[np.all(clamped[edges], axis=1)], :2]
    sides = {}
    for number, name in enumerate(SIDES):
        axis, bound = divmod(number, 2)
        on = np.all(np.abs(held[:, :, axis] - (low, high)[bound][axis]) < tolerance, axis=1)
        if on.any():
            along = held[on, :, 1 - axis]
            sides[name] = (float(along.min()), float(along.max()))
    return sides
