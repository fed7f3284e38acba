"""Plane geometry of drawn lines: lengths, nearest places, crossings and common stretches."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from etextile.types import Array


_TINY_MM = 1e-6


def distance_along(points: Array) -> Array:
    """Return the length from the first vertex to each of the vertices (n, 2), shape (n,)."""
    step = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(step)])


def snap(points: Array, along: Array, place: tuple[float, float]) -> tuple[float, float]:
    """Return the coordinate along a line (n, 2), (n,) of its place nearest to a point, and how far that is, mm."""
    start, way = points[:-1], np.diff(points, axis=0)
    share = np.clip(((np.array(place) - start) * way).sum(axis=1) / (way**2).sum(axis=1), 0.0, 1.0)
    off = np.linalg.norm(start + share[:, None] * way - np.array(place), axis=1)
    best = int(off.argmin())
    return float(along[best] + share[best] * (along[best + 1] - along[best])), float(off[best])


def crossings(first: Array, second: Array) -> Array:
    """Return the places (k, 2) where two lines (n, 2), (m, 2) cross or touch; parallel pieces do not cross."""
    a, da = first[:-1, None], np.diff(first, axis=0)[:, None]
    b, db = second[None, :-1], np.diff(second, axis=0)[None]
    det = da[..., 0] * db[..., 1] - da[..., 1] * db[..., 0]
    scale = np.linalg.norm(da, axis=2) * np.linalg.norm(db, axis=2)
    apart = np.abs(det) > 1e-9 * scale
    gap = b - a
    det = np.where(apart, det, 1.0)
    s = (gap[..., 0] * db[..., 1] - gap[..., 1] * db[..., 0]) / det
    t = (gap[..., 0] * da[..., 1] - gap[..., 1] * da[..., 0]) / det
    near_a, near_b = _TINY_MM / np.linalg.norm(da, axis=2), _TINY_MM / np.linalg.norm(db, axis=2)
    hit = apart & (s > -near_a) & (s < 1 + near_a) & (t > -near_b) & (t < 1 + near_b)
    found = (a + s[..., None] * da)[hit]
    return np.unique(np.round(found, 6), axis=0) if len(found) else np.zeros((0, 2))


def self_crossing(points: Array) -> Array | None:
    """Return a place (2,) where a line (n, 2) crosses or touches itself, None when it does not."""
    for k in range(len(points) - 3):
        found = crossings(points[k : k + 2], points[k + 2 :])
        if len(found):
            return np.asarray(found[0])
    return None


def overlap_mm(first: Array, second: Array) -> float:
    """Return the length over which two lines (n, 2), (m, 2) lie on each other, mm."""
    total = 0.0
    for a, b in pairwise(first):
        way = b - a
        length = float(np.linalg.norm(way))
        way = way / length
        ends = np.stack([second[:-1], second[1:]], axis=1) - a
        beside = np.abs(ends[..., 0] * way[1] - ends[..., 1] * way[0]).max(axis=1) < 1e-3
        place = np.sort(ends @ way, axis=1)
        total += float(np.clip(np.minimum(place[:, 1], length) - np.maximum(place[:, 0], 0.0), 0.0, None)[beside].sum())
    return total


def same_line(first: Array, second: Array) -> bool:
    """Tell whether two lines have the same vertices, from either end."""
    if first.shape != second.shape:
        return False
    return any(bool(np.abs(first - other).max() <= 1e-6) for other in (second, second[::-1]))
