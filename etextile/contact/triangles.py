"""Compiled signed distances from the nodes of a regular grid to a triangle mesh.

Exact in a band around the mesh, every triangle asking the nodes near it; further away each node tries the closest
triangles of its neighbours (fast sweeping: R. Bridson, "Fluid simulation for computer graphics", 2nd ed., section
4.3). The sign is the winding number, counted along grid lines, so facets and edges cannot flip it.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from etextile.compiled import njit
from etextile.types import Array, IntArray


@njit
def nearest(x: float, y: float, z: float, a: Array, b: Array, c: Array) -> tuple[float, float, float]:
    """Return the squared distance of a point to triangle abc and the weights of b and c at the closest point.

    C. Ericson, "Real-time collision detection", Morgan Kaufmann 2005, section 5.1.5.
    """
    abx, aby, abz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    acx, acy, acz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    apx, apy, apz = x - a[0], y - a[1], z - a[2]
    d1, d2 = abx * apx + aby * apy + abz * apz, acx * apx + acy * apy + acz * apz
    if d1 <= 0.0 and d2 <= 0.0:
        return apx * apx + apy * apy + apz * apz, 0.0, 0.0
    bpx, bpy, bpz = x - b[0], y - b[1], z - b[2]
    d3, d4 = abx * bpx + aby * bpy + abz * bpz, acx * bpx + acy * bpy + acz * bpz
    if d3 >= 0.0 and d4 <= d3:
        return bpx * bpx + bpy * bpy + bpz * bpz, 1.0, 0.0
    cpx, cpy, cpz = x - c[0], y - c[1], z - c[2]
    d5, d6 = abx * cpx + aby * cpy + abz * cpz, acx * cpx + acy * cpy + acz * cpz
    if d6 >= 0.0 and d5 <= d6:
        return cpx * cpx + cpy * cpy + cpz * cpz, 0.0, 1.0
    vc, vb, va = d1 * d4 - d3 * d2, d5 * d2 - d1 * d6, d3 * d6 - d5 * d4
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v, w = d1 / (d1 - d3), 0.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        v, w = 0.0, d2 / (d2 - d6)
    elif va <= 0.0 and d4 >= d3 and d5 >= d6:
        w = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        v = 1.0 - w
    else:
        v, w = vb / (va + vb + vc), vc / (va + vb + vc)
    rx, ry, rz = apx - v * abx - w * acx, apy - v * aby - w * acy, apz - v * abz - w * acz
    return rx * rx + ry * ry + rz * rz, v, w


@njit
def band(corners: Array, spacing: float, cells: float, squared: Array, closest: npt.NDArray[np.int32]) -> None:
    """Fill `squared` (distance) and `closest` (triangle) exactly at all nodes within `cells` of a triangle.

    corners: (f, 3, 3) triangles in the grid's coordinates (node i at i spacing). The arrays of the grid's shape come
    filled with inf and -1.
    """
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for f in range(corners.shape[0]):
        a, b, c = corners[f, 0], corners[f, 1], corners[f, 2]
        for i in range(3):
            low[i] = max(int(np.ceil(min(a[i], b[i], c[i]) / spacing - cells)), 0)
            high[i] = min(int(np.floor(max(a[i], b[i], c[i]) / spacing + cells)), squared.shape[i] - 1)
        for i in range(low[0], high[0] + 1):
            for j in range(low[1], high[1] + 1):
                for k in range(low[2], high[2] + 1):
                    d = nearest(i * spacing, j * spacing, k * spacing, a, b, c)[0]
                    if d < squared[i, j, k]:
                        squared[i, j, k] = d
                        closest[i, j, k] = f


@njit
def sweep(corners: Array, spacing: float, fixed: float, squared: Array, closest: npt.NDArray[np.int32]) -> None:
    """Carry closest triangles outward from the band in eight directions; distances up to `fixed` are left alone."""
    n0, n1, n2 = squared.shape
    for direction in range(8):
        s0, s1, s2 = 1 - 2 * (direction & 1), 1 - (direction & 2), 1 - (direction & 4) // 2
        for p in range(n0):
            i = p if s0 > 0 else n0 - 1 - p
            for q in range(n1):
                j = q if s1 > 0 else n1 - 1 - q
                for r in range(n2):
                    k = r if s2 > 0 else n2 - 1 - r
                    if squared[i, j, k] <= fixed * fixed:
                        continue
                    for axis in range(3):
                        u, v, w = i - s0 * (axis == 0), j - s1 * (axis == 1), k - s2 * (axis == 2)
                        if u < 0 or v < 0 or w < 0 or u >= n0 or v >= n1 or w >= n2:
                            continue
                        f = closest[u, v, w]
                        if f < 0 or f == closest[i, j, k]:
                            continue
                        a, b, c = corners[f, 0], corners[f, 1], corners[f, 2]
                        d = nearest(i * spacing, j * spacing, k * spacing, a, b, c)[0]
                        if d < squared[i, j, k]:
                            squared[i, j, k] = d
                            closest[i, j, k] = f


@njit
def descend(
    corners: Array,
    faces: IntArray,
    ring: tuple[IntArray, IntArray],
    spacing: float,
    fixed: float,
    squared: Array,
    closest: npt.NDArray[np.int32],
) -> None:
    """Move every node beyond `fixed` to the closest triangle around its present one until none is closer.

    ring: first index per vertex (v + 1,) and the triangles around the vertices, one vertex after the other.
    """
    starts, around = ring
    for i in range(squared.shape[0]):
        for j in range(squared.shape[1]):
            for k in range(squared.shape[2]):
                f = -1
                while f != closest[i, j, k] and squared[i, j, k] > fixed * fixed:
                    f = closest[i, j, k]
                    for corner in range(3):
                        vertex = faces[f, corner]
                        for g in around[starts[vertex] : starts[vertex + 1]]:
                            if g == f:
                                continue
                            a, b, c = corners[g, 0], corners[g, 1], corners[g, 2]
                            d = nearest(i * spacing, j * spacing, k * spacing, a, b, c)[0]
                            if d < squared[i, j, k]:
                                squared[i, j, k] = d
                                closest[i, j, k] = g


@njit
def bulge(corners: Array, shifts: Array, spacing: float, closest: npt.NDArray[np.int32]) -> Array:
    """Return for each node how far the curved surface lies outside of the flat triangle at its closest point, mm.

    shifts: (f, 3, 3) offset of each edge's curved midpoint; in between the quadratic triangle patch
    4 (u v s_ab + v w s_bc + w u s_ca) is taken along the triangle's normal.
    """
    height = np.zeros(closest.shape)
    for i in range(closest.shape[0]):
        for j in range(closest.shape[1]):
            for k in range(closest.shape[2]):
                f = closest[i, j, k]
                a, b, c = corners[f, 0], corners[f, 1], corners[f, 2]
                _, v, w = nearest(i * spacing, j * spacing, k * spacing, a, b, c)
                u = 1.0 - v - w
                n = np.cross(b - a, c - a)
                length = np.sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
                for axis in range(3):
                    patch = u * v * shifts[f, 0, axis] + v * w * shifts[f, 1, axis] + w * u * shifts[f, 2, axis]
                    height[i, j, k] += 4.0 * patch * n[axis] / max(length, 1e-300)
    return height


@njit
def side(px: float, py: float, qx: float, qy: float) -> int:
    """Return the side of the origin on which the line from p to q passes, never 0 for two different points.

    Ties are broken the same way for both triangles at an edge (simulation of simplicity), so that a ray through an
    edge crosses exactly one of them.
    """
    twice_area = py * qx - px * qy
    if twice_area != 0.0:
        return 1 if twice_area > 0.0 else -1
    if qy != py:
        return 1 if qy > py else -1
    if qx != px:
        return 1 if px > qx else -1
    return 0


@njit
def crossings(corners: Array, spacing: float, shape: tuple[int, int, int]) -> IntArray:
    """Return the winding number of the surface around each node (1 inside a mesh wound outward, 0 outside)."""
    winding = np.zeros(shape, np.int32)
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for f in range(corners.shape[0]):
        a, b, c = corners[f, 0], corners[f, 1], corners[f, 2]
        for i in range(1, 3):
            low[i] = max(int(np.ceil(min(a[i], b[i], c[i]) / spacing)), 0)
            high[i] = min(int(np.floor(max(a[i], b[i], c[i]) / spacing)), shape[i] - 1)
        for j in range(low[1], high[1] + 1):
            for k in range(low[2], high[2] + 1):
                y, z = j * spacing, k * spacing
                ay, az, by, bz, cy, cz = a[1] - y, a[2] - z, b[1] - y, b[2] - z, c[1] - y, c[2] - z
                turn = side(by, bz, cy, cz)
                if turn == 0 or turn != side(cy, cz, ay, az) or turn != side(ay, az, by, bz):
                    continue
                wa, wb, wc = bz * cy - by * cz, cz * ay - cy * az, az * by - ay * bz
                total = wa + wb + wc
                if total == 0.0:
                    continue
                x = (wa * a[0] + wb * b[0] + wc * c[0]) / total
                first = int(np.ceil(x / spacing))
                if first < shape[0]:
                    winding[max(first, 0), j, k] += turn
    for i in range(1, shape[0]):
        for j in range(shape[1]):
            for k in range(shape[2]):
                winding[i, j, k] += winding[i - 1, j, k]
    return winding.astype(np.int64)
