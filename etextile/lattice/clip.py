"""A rectangle about the origin and what lies in it: parts of segments, areas beside lines."""

from __future__ import annotations

import numpy as np

from etextile.types import Array


def inside(start: Array, end: Array, half: tuple[float, float]) -> tuple[Array, Array]:
    """Return where segments (k, 2) enter and leave the rectangle, as shares of the way, (k,) (Liang and Barsky)."""
    first, last = np.zeros(len(start)), np.ones(len(start))
    for axis in (0, 1):
        way = end[:, axis] - start[:, axis]
        with np.errstate(divide="ignore", invalid="ignore"):
            bounds = np.stack([(-half[axis] - start[:, axis]) / way, (half[axis] - start[:, axis]) / way])
        beside = (way == 0.0) & (np.abs(start[:, axis]) > half[axis])
        bounds = np.where(way == 0.0, np.array([[-np.inf], [np.inf]]), bounds)
        first = np.maximum(first, bounds.min(axis=0))
        last = np.where(beside, -1.0, np.minimum(last, bounds.max(axis=0)))
    return first, last


def between(places: Array, share: Array, half: tuple[float, float]) -> Array:
    """Return the places (m, 2) at shares (m,) of segments (m, 2, 2); what is cut lies exactly on the edge line."""
    found = places[:, 0] + share[:, None] * (places[:, 1] - places[:, 0])
    found = np.where((share == 0.0)[:, None], places[:, 0], np.where((share == 1.0)[:, None], places[:, 1], found))
    limit = np.array(half)
    on = ((share > 0.0) & (share < 1.0))[:, None] & (np.abs(np.abs(found) - limit) < 1e-9 * limit.max())
    return np.where(on, np.copysign(limit, found), found)


def area_below(distance: Array, normal: Array, half: tuple[float, float]) -> Array:
    """Return the area (k,) of the rectangle between its centre line and lines at signed distances (k,) along `normal`.

    The chord over the distance is a trapezoid: longest up to |h1 n1 - h2 n2|, then falling to zero at h1 n1 + h2 n2.
    """
    across = np.abs(normal) * np.array(half)
    flat, slope = abs(across[0] - across[1]), 2.0 * float(across.min())
    longest = 2.0 * min(side / size for side, size in zip(half, np.abs(normal[::-1]), strict=True) if size > 0.0)
    reach = np.minimum(np.abs(distance), flat)
    beyond = np.clip(np.abs(distance) - flat, 0.0, slope)
    falling = beyond - 0.5 * beyond**2 / slope if slope > 0.0 else 0.0
    return np.asarray(np.sign(distance) * longest * (reach + falling))
