"""Plane geometry of drawn lines: lengths, nearest places, crossings and common stretches."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from etextile.types import Array, BoolArray


_TINY_MM = 1e-6
BLOCK = 32
"""Pieces of a line that share a box: what lies in boxes apart does not cross."""


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


def crossings(first: Array, second: Array, *, between: BoolArray | None = None) -> Array:
    """Return the places (k, 2) where two lines (n, 2), (m, 2) cross or touch; parallel pieces do not cross.

    `between` (n - 1, m - 1) says which pieces are asked about, all of them unless it is given.
    """
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
    hit = (
        (apart if between is None else apart & between)
        & (s > -near_a)
        & (s < 1 + near_a)
        & (t > -near_b)
        & (t < 1 + near_b)
    )
    found = (a + s[..., None] * da)[hit]
    return np.unique(np.round(found, 6), axis=0) if len(found) else np.zeros((0, 2))


def self_crossing(points: Array) -> Array | None:
    """Return a place (2,) where a line (n, 2) crosses or touches itself, None when it does not."""
    starts = range(0, len(points) - 1, BLOCK)
    blocks = [points[start : start + BLOCK + 1] for start in starts]
    low, high = (np.array([end(block, axis=0) for block in blocks]) for end in (np.min, np.max))
    for k, block in enumerate(blocks):
        near = ((low[k:] <= high[k] + _TINY_MM) & (high[k:] >= low[k] - _TINY_MM)).all(axis=1)
        for other in k + np.flatnonzero(near):
            if (found := _met(block, blocks[other], BLOCK * (int(other) - k))) is not None:
                return found
    return None


def _met(first: Array, second: Array, ahead: int) -> Array | None:
    """Return a place (2,) where pieces of two stretches of a line meet that are not neighbours, None for none.

    Piece 0 of `second` is `ahead` pieces along the line from piece 0 of `first`.
    """
    apart = ahead + np.arange(len(second) - 1) - np.arange(len(first) - 1)[:, None]
    found = crossings(first, second, between=apart > 1)
    return np.asarray(found[0]) if len(found) else None


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


class Lines:
    """Lines by what they look like: which of them have the same vertices as another line, from either end."""

    def __init__(self, lines: Sequence[Array]) -> None:
        from scipy.spatial import cKDTree

        self._lines = lines
        self._tree = cKDTree(np.array([line.mean(axis=0) for line in lines]).reshape(-1, 2))

    def same(self, line: Array) -> list[int]:
        """Return the numbers of the lines that are `line` (n, 2), in order."""
        near = self._tree.query_ball_point(line.mean(axis=0), 2.0 * _TINY_MM)
        return [number for number in sorted(near) if same_line(self._lines[number], line)]
