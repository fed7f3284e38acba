"""Compiled signed distances: they run for every node of the fabric in every Newton iteration.

Each kernel fills gap (n,), normal (n, 3) and hessian (n, 3, 3) and returns them. The Hessian of a distance follows from
the shape operator S of the surface at the closest point: H = S (1 + gap S)^-1 on the tangent plane, by the
Cayley-Hamilton theorem (S + gap det S P) / (1 + gap tr S + gap^2 det S) with the tangent projector P = 1 - n n^T.
"""

from __future__ import annotations

import numpy as np

from etextile.compiled import njit
from etextile.types import Array


SMALLEST = 1e-9
"""Distances from a centre, axis or focal surface below this share of the size are treated as this share."""


@njit
def sphere_distance(points: Array, radius: float) -> tuple[Array, Array, Array]:
    """Return the distance to a sphere about the origin: gap = |x| - radius, hessian = (1 - n n^T) / |x|."""
    return capsule_distance(points, radius, 0.0)


@njit
def capsule_distance(points: Array, radius: float, half: float) -> tuple[Array, Array, Array]:
    """Return the distance to a capsule along x whose caps are centred at x = -half and x = +half."""
    count = points.shape[0]
    gap, normal, hessian = np.empty(count), np.empty((count, 3)), np.empty((count, 3, 3))
    for p in range(count):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        along = min(max(x, -half), half)
        r = np.sqrt((x - along) ** 2 + y * y + z * z)
        gap[p] = r - radius
        if r > SMALLEST * radius:
            normal[p, 0], normal[p, 1], normal[p, 2] = (x - along) / r, y / r, z / r
        else:
            r = SMALLEST * radius
            normal[p, 0], normal[p, 1], normal[p, 2] = 0.0, 0.0, 1.0
        straight = -half < x < half
        for i in range(3):
            for j in range(3):
                hessian[p, i, j] = -normal[p, i] * normal[p, j] / r
            if i > 0 or not straight:
                hessian[p, i, i] += 1.0 / r
    return gap, normal, hessian


@njit
def ellipsoid_multiplier(x: float, y: float, z: float, semi: Array) -> float:
    """Return the largest root t of sum (a x / (t + a^2))^2 = 1, at least -min(a)^2 (Eberly, robust bisection).

    The closest point of the ellipsoid is a^2 x / (t + a^2). Newton on the nearly linear 1 / sqrt(sum), kept in a
    bracket by bisection. Inside the focal disc there is no root and -min(a)^2 itself is returned.
    """
    least = min(semi[0], semi[1], semi[2]) ** 2
    u, v, w = semi[0] * abs(x), semi[1] * abs(y), semi[2] * abs(z)
    low = max(u - semi[0] ** 2, v - semi[1] ** 2, w - semi[2] ** 2, -least)
    high = np.sqrt(u * u + v * v + w * w) - least
    t = max(low, -least * (1.0 - 1e-15))
    for _ in range(100):
        pu, pv, pw = t + semi[0] ** 2, t + semi[1] ** 2, t + semi[2] ** 2
        total = (u / pu) ** 2 + (v / pv) ** 2 + (w / pw) ** 2
        if total > 1.0:
            low = t
        else:
            high = t
        slope = (u / pu) ** 2 / pu + (v / pv) ** 2 / pv + (w / pw) ** 2 / pw
        following = t
        if slope > 0.0:
            following = t + (np.sqrt(total) - 1.0) * total / slope
        if not low <= following <= high:
            following = 0.5 * (low + high)
        if abs(following - t) <= 4e-16 * (least + abs(t)) or high - low <= 4e-16 * (least + abs(t)):
            break
        t = following
    return float(t)


@njit
def ellipsoid_foot(point: Array, semi: Array, foot: Array) -> float:
    """Fill `foot` with the closest point of the ellipsoid and return the multiplier t (negative inside)."""
    t = ellipsoid_multiplier(point[0], point[1], point[2], semi)
    smallest = 0
    for i in range(3):
        if semi[i] < semi[smallest]:
            smallest = i
    rest = 1.0
    for i in range(3):
        below = t + semi[i] ** 2
        if below > 1e-14 * semi[i] ** 2:
            foot[i] = semi[i] ** 2 * point[i] / below
        else:
            foot[i] = 0.0
        if i != smallest:
            rest -= (foot[i] / semi[i]) ** 2
    if t + semi[smallest] ** 2 <= 1e-7 * semi[smallest] ** 2:
        side = -1.0 if point[smallest] < 0.0 else 1.0
        foot[smallest] = side * semi[smallest] * np.sqrt(max(rest, 0.0))
    return t


@njit
def ellipsoid_distance(points: Array, semi: Array) -> tuple[Array, Array, Array]:
    """Return the distance to the ellipsoid about the origin with semi-axes `semi` (3,).

    With g = foot / a^2 the gap is t |g|, the normal g / |g| and the shape operator P diag(1 / a^2) P / |g|.
    """
    count = points.shape[0]
    gap, normal, hessian = np.empty(count), np.empty((count, 3)), np.empty((count, 3, 3))
    foot, g, image = np.empty(3), np.empty(3), np.empty(3)
    for p in range(count):
        t = ellipsoid_foot(points[p], semi, foot)
        for i in range(3):
            g[i] = foot[i] / semi[i] ** 2
        length = np.sqrt(g[0] ** 2 + g[1] ** 2 + g[2] ** 2)
        n, shape = normal[p], hessian[p]
        quadratic = 0.0
        for i in range(3):
            n[i] = g[i] / length
            image[i] = n[i] / semi[i] ** 2
            quadratic += n[i] * image[i]
        gap[p] = t * length
        trace, square = 0.0, 0.0
        for i in range(3):
            for j in range(3):
                shape[i, j] = (quadratic * n[i] * n[j] - n[i] * image[j] - image[i] * n[j]) / length
            shape[i, i] += 1.0 / (semi[i] ** 2 * length)
            trace += shape[i, i]
        for i in range(3):
            for j in range(3):
                square += shape[i, j] ** 2
        offset_curvature(shape, n, gap[p], trace, 0.5 * (trace * trace - square))
    return gap, normal, hessian


@njit
def offset_curvature(shape: Array, n: Array, gap: float, trace: float, determinant: float) -> None:
    """Turn the shape operator (3, 3) at the foot in place into the Hessian of the distance at height `gap`."""
    below = max(1.0 + gap * trace + gap * gap * determinant, SMALLEST)
    for i in range(3):
        for j in range(3):
            shape[i, j] = (shape[i, j] - gap * determinant * n[i] * n[j]) / below
        shape[i, i] += gap * determinant / below


@njit
def cubic_weights(t: float, values: Array, slopes: Array, bends: Array) -> None:
    """Fill the four weights of a uniform cubic B-spline at t in [0, 1] and their first and second derivatives."""
    s = 1.0 - t
    values[0], values[3] = s * s * s / 6.0, t * t * t / 6.0
    values[1] = 2.0 / 3.0 - t * t * (1.0 - 0.5 * t)
    values[2] = 2.0 / 3.0 - s * s * (1.0 - 0.5 * s)
    slopes[0], slopes[3] = -0.5 * s * s, 0.5 * t * t
    slopes[1] = t * (1.5 * t - 2.0)
    slopes[2] = s * (2.0 - 1.5 * s)
    bends[0], bends[1], bends[2], bends[3] = s, 3.0 * t - 2.0, 3.0 * s - 2.0, t


@njit
def spline_derivatives(coefficients: Array, cell: Array, weights: Array, out: Array) -> None:
    """Fill `out` with the tricubic spline's value, x y z and xx yy zz yz xz xy derivatives, per grid spacing.

    cell: (3,) index of the lower corner; weights: (3 axes, 3 orders, 4). Sums run over z, then y, then x.
    """
    out[:] = 0.0
    ci, cj, ck = int(cell[0]) - 1, int(cell[1]) - 1, int(cell[2]) - 1
    wx, wy, wz = weights[0], weights[1], weights[2]
    for i in range(4):
        v = vy = vyy = vz = vyz = vzz = 0.0
        for j in range(4):
            a = b = c = 0.0
            for k in range(4):
                value = coefficients[ci + i, cj + j, ck + k]
                a += wz[0, k] * value
                b += wz[1, k] * value
                c += wz[2, k] * value
            v += wy[0, j] * a
            vy += wy[1, j] * a
            vyy += wy[2, j] * a
            vz += wy[0, j] * b
            vyz += wy[1, j] * b
            vzz += wy[0, j] * c
        out[0] += wx[0, i] * v
        out[1] += wx[1, i] * v
        out[2] += wx[0, i] * vy
        out[3] += wx[0, i] * vz
        out[4] += wx[2, i] * v
        out[5] += wx[0, i] * vyy
        out[6] += wx[0, i] * vzz
        out[7] += wx[0, i] * vyz
        out[8] += wx[1, i] * vz
        out[9] += wx[1, i] * vy


@njit
def spline_distance(
    points: Array, coefficients: Array, origin: Array, spacing: float, rim: float
) -> tuple[Array, Array, Array]:
    """Return the distance interpolated by a tricubic B-spline on a regular grid, and its derivatives.

    The outer `rim` cells (at least 1) are not used: there the spline feels the end of the grid. A point beyond, with
    q the nearest point of the box that is left, gets the lower bound
    sqrt(|x - q|^2 + gap(q)^2), its gradient and a zero Hessian: the body lies beyond the face that holds q.
    """
    count = points.shape[0]
    gap, normal, hessian = np.empty(count), np.empty((count, 3)), np.empty((count, 3, 3))
    cell, weights, out = np.empty(3), np.empty((3, 3, 4)), np.empty(10)
    beyond = np.empty(3)
    for p in range(count):
        outside = 0.0
        for i in range(3):
            q = (points[p, i] - origin[i]) / spacing
            last = coefficients.shape[i] - 1.0 - rim
            inner = min(max(q, rim), last)
            cell[i] = min(np.floor(inner), last - 1.0)
            cubic_weights(inner - cell[i], weights[i, 0], weights[i, 1], weights[i, 2])
            beyond[i] = (q - inner) * spacing
            outside += beyond[i] ** 2
        spline_derivatives(coefficients, cell, weights, out)
        n, h = normal[p], hessian[p]
        gap[p] = out[0]
        for i in range(3):
            n[i] = out[1 + i] / spacing
        if outside > 0.0:
            gap[p] = np.sqrt(outside + out[0] ** 2)
            h[:, :] = 0.0
            for i in range(3):
                n[i] = (beyond[i] if beyond[i] != 0.0 else out[0] * n[i]) / gap[p]
        else:
            scale = 1.0 / spacing**2
            h[0, 0], h[1, 1], h[2, 2] = out[4] * scale, out[5] * scale, out[6] * scale
            h[1, 2] = h[2, 1] = out[7] * scale
            h[0, 2] = h[2, 0] = out[8] * scale
            h[0, 1] = h[1, 0] = out[9] * scale
    return gap, normal, hessian


@njit
def to_body(points: Array, rotation: Array, translation: Array) -> Array:
    """Return rotation^T (points - translation): world coordinates to body coordinates."""
    result = np.empty_like(points)
    for p in range(points.shape[0]):
        x, y, z = points[p, 0] - translation[0], points[p, 1] - translation[1], points[p, 2] - translation[2]
        for i in range(3):
            result[p, i] = rotation[0, i] * x + rotation[1, i] * y + rotation[2, i] * z
    return result


@njit
def turn(normal: Array, hessian: Array, rotation: Array) -> tuple[Array, Array]:
    """Return rotation n and rotation H rotation^T for normals (n, 3) and Hessians (n, 3, 3)."""
    normals, hessians = np.empty_like(normal), np.empty_like(hessian)
    half = np.empty((3, 3))
    for p in range(normal.shape[0]):
        for i in range(3):
            total = 0.0
            for j in range(3):
                total += rotation[i, j] * normal[p, j]
                half[i, j] = 0.0
                for k in range(3):
                    half[i, j] += rotation[i, k] * hessian[p, k, j]
            normals[p, i] = total
        for i in range(3):
            for j in range(i, 3):
                total = 0.0
                for k in range(3):
                    total += half[i, k] * rotation[j, k]
                hessians[p, i, j] = total
                hessians[p, j, i] = total
    return normals, hessians
