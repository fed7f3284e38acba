"""Shapes written as functions of space: round primitives, smooth unions and the mesh of their zero level.

Body parts are easier to blend as implicit functions (negative inside) than as meshes: a smooth minimum joins them
without a seam. The mesh is made by surface nets (S. Gibson, "Constrained elastic surface nets", MICCAI 1998): one
vertex per cell that the surface crosses, then relaxed along the surface and drawn back onto the zero level, which
gives nearly equilateral triangles of one size.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import reduce
from typing import TypeAlias

import numpy as np

from etextile.errors import BadInput
from etextile.types import Array, IntArray


Implicit: TypeAlias = Callable[[Array], Array]
"""Function of points (n, 3) to values (n,), negative inside; near its zero level close to a distance in mm."""


def capped_cone(start: Array, end: Array, start_radius: float, end_radius: float) -> Implicit:
    """Return the exact distance to the convex hull of two balls, min over t of |p - c(t)| - r(t)."""
    length = float(np.linalg.norm(end - start))
    axis = (end - start) / length
    slope = (start_radius - end_radius) / length
    tangent = slope / np.sqrt(1.0 - slope**2)

    def value(points: Array) -> Array:
        along = (points - start) @ axis
        radial = np.linalg.norm(points - start - along[:, None] * axis, axis=1)
        centre = np.clip(along - radial * tangent, 0.0, length)
        return np.asarray(np.hypot(along - centre, radial) - start_radius + slope * centre)

    return value


def grown_ellipsoid(centre: Array, semi_axes: tuple[float, float, float], offset: float) -> Implicit:
    """Return the exact distance to an ellipsoid about `centre` grown by `offset` on all sides."""
    from etextile.contact import kernels

    def value(points: Array) -> Array:
        return kernels.ellipsoid_distance(points - centre, np.array(semi_axes))[0] - offset

    return value


def smooth_union(parts: list[Implicit], width: float) -> Implicit:
    """Return the union of `parts`, rounded where two are within `width` mm of each other.

    Cubic smooth minimum, twice differentiable: min(a, b) - width h^3 / 6 with h = max(1 - |a - b| / width, 0). Where
    the parts differ by more than `width` the union is exactly the nearer part.
    """

    def blend(a: Array, b: Array) -> Array:
        near = np.maximum(1.0 - np.abs(a - b) / width, 0.0)
        return np.asarray(np.minimum(a, b) - width * near**3 / 6.0)

    return lambda points: reduce(blend, (part(points) for part in parts))


def implicit_mesh(shape: Implicit, bounds: Array, *, edge: float) -> tuple[Array, IntArray]:
    """Return vertices (v, 3) and outward triangles (f, 3) with edges of about `edge` mm on the zero level of `shape`.

    `bounds` (2, 3) is a box around the body. Features smaller than about 2 `edge` are lost.
    """
    counts = np.ceil(np.ptp(bounds, axis=0) / edge).astype(int) + 5
    lower = bounds.mean(axis=0) - 0.5 * edge * (counts - 1)
    axes = [lower[i] + edge * np.arange(counts[i]) for i in range(3)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    values = shape(nodes.reshape(-1, 3)).reshape(tuple(counts))
    _require_room(values, nodes)
    vertices, quads = surface_nets(unambiguous(values))
    vertices = lower + edge * vertices
    edges = np.concatenate([quads[:, [i, (i + 1) % 4]] for i in range(4)])
    for _ in range(6):
        vertices = _drawn(_relaxed(vertices, edges), shape)
    for _ in range(3):
        vertices = _drawn(vertices, shape)
    return vertices, _split(vertices, quads)


def _require_room(values: Array, nodes: Array) -> None:
    """Raise BadInput where the body reaches the outer cells of the grid, about `bounds`: it has to end inside."""
    inner = np.zeros(values.shape, dtype=bool)
    inner[2:-2, 2:-2, 2:-2] = True
    reached = nodes[(values < 0.0) & ~inner]
    if len(reached):
        place = np.round(reached[0], 3).tolist()
        what = f"the body goes on beyond the box low .. high, at {place}"
        raise BadInput.of(f"{what}: give a box that holds it (gap is negative inside)")


def unambiguous(values: Array) -> Array:
    """Return values with no grid face whose corners have the signs + - + -, where the net would not be a surface.

    Such faces occur where a saddle touches the grid. Their outer corner nearest to zero is put inside, which moves the
    net by less than a cell; its vertices are drawn onto the surface later anyway.
    """
    values = values.copy()
    found = True
    while found:
        found = False
        for axis in range(3):
            moved = np.moveaxis(values, axis, 0)
            corners = np.stack([moved[:, :-1, :-1], moved[:, 1:, :-1], moved[:, 1:, 1:], moved[:, :-1, 1:]])
            inside = corners < 0.0
            mixed = (inside[0] == inside[2]) & (inside[1] == inside[3]) & (inside[0] != inside[1])
            layer, row, column = np.nonzero(mixed)
            least = np.where(inside, np.inf, corners)[:, mixed].argmin(axis=0)
            row, column = row + np.array([0, 1, 1, 0])[least], column + np.array([0, 0, 1, 1])[least]
            moved[layer, row, column] = -1e-3 * np.abs(moved[layer, row, column]) - 1e-12
            found = found or len(layer) > 0
    return values


def surface_nets(values: Array) -> tuple[Array, IntArray]:
    """Return vertices (v, 3), in units of the grid, and outward quads (q, 4) of the zero level of a sampled function.

    Every cell with both signs at its corners holds one vertex, the mean of the crossings on its edges; every grid edge
    that is crossed joins the four cells around it. The surface must not touch the outer cells.
    """
    inside = values < 0.0
    cells = tuple(np.array(values.shape) - 1)
    total, count = np.zeros((*cells, 3)), np.zeros(cells)
    crossings = []
    for axis in range(3):
        first, second = _ends(values, axis)
        crossed = (first < 0.0) != (second < 0.0)
        start = np.argwhere(crossed)
        share = first[crossed] / (first[crossed] - second[crossed])
        point = start.astype(float)
        point[:, axis] += share
        crossings.append((start, inside[tuple(start.T)]))
        for around in _cells_around(start, axis):
            np.add.at(total, tuple(around.T), point)
            np.add.at(count, tuple(around.T), 1.0)
    used = count > 0
    number = np.full(cells, -1, dtype=np.int64)
    number[used] = np.arange(used.sum())
    quads = []
    for axis, (start, leaving) in enumerate(crossings):
        corners = np.stack([number[tuple(around.T)] for around in _cells_around(start, axis)], axis=1)
        quads.append(np.where(leaving[:, None], corners, corners[:, ::-1]))
    return total[used] / count[used, None], np.concatenate(quads)


def _ends(values: Array, axis: int) -> tuple[Array, Array]:
    """Return the values at the lower and the upper end of all grid edges along `axis`."""
    moved = np.moveaxis(values, axis, 0)
    return np.moveaxis(moved[:-1], 0, axis), np.moveaxis(moved[1:], 0, axis)


def _cells_around(start: IntArray, axis: int) -> list[IntArray]:
    """Return the indices of the four cells around grid edges, anticlockwise seen against `axis`."""
    i, j = np.eye(3, dtype=np.int64)[[(axis + 1) % 3, (axis + 2) % 3]]
    return [start - i - j, start - j, start, start - i]


def _drawn(points: Array, shape: Implicit, step: float = 1e-4) -> Array:
    """Return `points` drawn along the gradient towards the zero level (one Newton step, differences over `step` mm)."""
    value = shape(points)
    gradient = np.stack([shape(points + shift) - value for shift in step * np.eye(3)], axis=1) / step
    return np.asarray(points - (value / np.einsum("ij,ij->i", gradient, gradient))[:, None] * gradient)


def _relaxed(vertices: Array, edges: IntArray) -> Array:
    """Return vertices moved halfway to the mean of their neighbours."""
    total, count = np.zeros_like(vertices), np.zeros(len(vertices))
    np.add.at(total, edges[:, 0], vertices[edges[:, 1]])
    np.add.at(count, edges[:, 0], 1.0)
    np.add.at(total, edges[:, 1], vertices[edges[:, 0]])
    np.add.at(count, edges[:, 1], 1.0)
    return 0.5 * vertices + 0.5 * total / count[:, None]


def _split(vertices: Array, quads: IntArray) -> IntArray:
    """Return the quads cut along their shorter diagonal."""
    a, b, c, d = (vertices[quads[:, i]] for i in range(4))
    first = np.linalg.norm(c - a, axis=1) <= np.linalg.norm(d - b, axis=1)
    one = np.where(first[:, None], quads[:, [0, 1, 2]], quads[:, [0, 1, 3]])
    two = np.where(first[:, None], quads[:, [0, 2, 3]], quads[:, [1, 2, 3]])
    return np.concatenate([one, two])
