"""What a piece may be cut to: a rectangle, a circle, a convex polygon. All that a yarn asks of its piece is here.

A shape knows where segments enter and leave it, how much of it lies on one side of a line, and which points lie on its
outline; how yarns are cut and what they stand for (`lattice.cut`) is the same for all.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from etextile.lattice import clip
from etextile.lattice.piece import EDGES
from etextile.types import Array, BoolArray


OUTLINE = "outline"
"""Name of the edge that goes all the way round."""
ROUNDING = 1e-9
"""Shares of a segment this close to its ends are its ends."""


class Shape(ABC):
    """A convex piece in the plane; the lattice's centre is the origin."""

    @property
    @abstractmethod
    def reach(self) -> float:
        """Greatest distance of a point of the piece from the origin, mm."""

    @abstractmethod
    def snapped(self, places: Array, near: float) -> Array:
        """Return places (..., 2) with those closer than `near` (mm) to the outline moved onto it."""

    @abstractmethod
    def inside(self, start: Array, end: Array) -> tuple[Array, Array]:
        """Return where segments (k, 2) enter and leave the piece, as shares of the way (k,); beside it stop < start."""

    @abstractmethod
    def between(self, places: Array, share: Array) -> Array:
        """Return the places (m, 2) at shares (m,) of segments (m, 2, 2); what is cut lies exactly on the outline."""

    @abstractmethod
    def area_below(self, distance: Array, normal: Array) -> Array:
        """Return the area (k,) below lines at signed distances (k,) along `normal`, but for a constant."""

    @abstractmethod
    def edges(self, points: Array) -> dict[str, BoolArray]:
        """Return the masks (n,) of points (n, 2) on the named edges."""


@dataclass(frozen=True)
class Rectangle(Shape):
    """A rectangle about the origin with its half lengths (mm)."""

    half: tuple[float, float]

    @property
    def reach(self) -> float:
        """Return half the diagonal."""
        return float(np.hypot(*self.half))

    def snapped(self, places: Array, near: float) -> Array:
        """Return places with near ones on the edge lines, also beyond corners."""
        half = np.array(self.half)
        return np.asarray(np.where(np.abs(np.abs(places) - half) < near, np.copysign(half, places), places))

    def inside(self, start: Array, end: Array) -> tuple[Array, Array]:
        """Return where segments enter and leave (Liang and Barsky)."""
        return clip.inside(start, end, self.half)

    def between(self, places: Array, share: Array) -> Array:
        """Return places on segments."""
        return clip.between(places, share, self.half)

    def area_below(self, distance: Array, normal: Array) -> Array:
        """Return the area between the centre line and lines."""
        return clip.area_below(distance, normal, self.half)

    def edges(self, points: Array) -> dict[str, BoolArray]:
        """Return the four edges by name."""
        return {
            name: points[:, "xy".index(name[0])]
            == (self.half["xy".index(name[0])] * (1.0 if name.endswith("max") else -1.0))
            for name in EDGES
        }


class Outlined(Shape):
    """A piece whose edge is one outline."""

    @abstractmethod
    def depth(self, points: Array) -> Array:
        """Return how far points (n, 2) lie inside of the outline, mm, negative outside."""

    def edges(self, points: Array) -> dict[str, BoolArray]:
        """Return the outline; the edges of a rectangle have no point."""
        nothing = np.zeros(len(points), dtype=np.bool_)
        on = np.abs(self.depth(points)) < 1e-9 * self.reach
        return {**{name: nothing.copy() for name in EDGES}, OUTLINE: np.asarray(on)}


@dataclass(frozen=True)
class Circle(Outlined):
    """A circle about the origin."""

    radius: float

    @property
    def reach(self) -> float:
        """Return the radius."""
        return self.radius

    def depth(self, points: Array) -> Array:
        """Return the distance from the circle, positive inside."""
        return np.asarray(self.radius - np.hypot(points[..., 0], points[..., 1]))

    def snapped(self, places: Array, near: float) -> Array:
        """Return places with near ones moved along their radius."""
        size = np.hypot(places[..., 0], places[..., 1])
        on = (np.abs(size - self.radius) < near) & (size > 0.0)  # the centre has no radius to move along
        return np.asarray(places * np.where(on, self.radius / np.where(on, size, 1.0), 1.0)[..., None])

    def inside(self, start: Array, end: Array) -> tuple[Array, Array]:
        """Solve |start + s (end - start)| = radius for both shares s."""
        way = end - start
        square = np.einsum("kc,kc->k", way, way)
        half = np.einsum("kc,kc->k", start, way) / square
        rest = (np.einsum("kc,kc->k", start, start) - self.radius**2) / square
        room = half**2 - rest
        root = np.sqrt(np.maximum(room, 0.0))
        first, last = _rounded(-half - root), _rounded(-half + root)
        return np.maximum(first, 0.0), np.where(room > 0.0, np.minimum(last, 1.0), -1.0)

    def between(self, places: Array, share: Array) -> Array:
        """Return places on segments, cut ones exactly on the circle."""
        found = _along(places, share)
        cut = (share > 0.0) & (share < 1.0)
        size = np.hypot(found[:, 0], found[:, 1])
        return np.asarray(np.where(cut[:, None], found * (self.radius / np.where(cut, size, 1.0))[:, None], found))

    def area_below(self, distance: Array, normal: Array) -> Array:
        """Return d sqrt(R^2 - d^2) + R^2 asin(d / R), the area between a diameter and the line at d."""
        d = np.clip(distance / self.radius, -1.0, 1.0)
        return np.asarray(self.radius**2 * (d * np.sqrt(1.0 - d * d) + np.arcsin(d)))


@dataclass(frozen=True)
class Polygon(Outlined):
    """A convex polygon with its corners (c, 2) in turn, counter-clockwise, mm."""

    corners: tuple[tuple[float, float], ...]

    @cached_property
    def sides(self) -> tuple[Array, Array]:
        """Outward normals (c, 2) of the sides and their distances (c,) from the origin, mm."""
        corners = np.array(self.corners)
        way = np.roll(corners, -1, axis=0) - corners
        normal = np.stack([way[:, 1], -way[:, 0]], axis=1) / np.hypot(way[:, 0], way[:, 1])[:, None]
        return normal, np.einsum("cd,cd->c", normal, corners)

    @property
    def reach(self) -> float:
        """Return the distance of the farthest corner."""
        return float(np.hypot(*np.array(self.corners).T).max())

    def depth(self, points: Array) -> Array:
        """Return the least distance from the side lines."""
        normal, offset = self.sides
        return np.asarray((offset - points @ normal.T).min(axis=-1))

    def snapped(self, places: Array, near: float) -> Array:
        """Return places with near ones moved square onto the side lines, one after the other."""
        places = places.copy()
        for normal, offset in zip(*self.sides, strict=True):
            gap = offset - places @ normal
            places += np.where(np.abs(gap) < near, gap, 0.0)[..., None] * normal
        return places

    def inside(self, start: Array, end: Array) -> tuple[Array, Array]:
        """Cut segments by all sides in turn (Cyrus and Beck)."""
        first, last = np.zeros(len(start)), np.ones(len(start))
        for normal, offset in zip(*self.sides, strict=True):
            gap, rate = offset - start @ normal, (end - start) @ normal
            beside = (np.abs(rate) < 1e-12 * self.reach) & (gap < -1e-9 * self.reach)
            share = _rounded(np.divide(gap, rate, out=np.zeros(len(gap)), where=np.abs(rate) > 1e-12 * self.reach))
            first = np.where(rate < -1e-12 * self.reach, np.maximum(first, share), first)
            last = np.where(rate > 1e-12 * self.reach, np.minimum(last, share), last)
            last = np.where(beside, -1.0, last)
        return first, last

    def between(self, places: Array, share: Array) -> Array:
        """Return places on segments."""
        return _along(places, share)

    def area_below(self, distance: Array, normal: Array) -> Array:
        """Return the area below lines: the width, which runs straight between corners, summed up exactly."""
        corners = np.array(self.corners)
        levels = np.unique(corners @ normal)
        width = self._widths(levels, normal)
        below = np.concatenate([[0.0], np.cumsum(0.5 * (width[1:] + width[:-1]) * np.diff(levels))])
        at = np.clip(distance, levels[0], levels[-1])
        cell = np.clip(np.searchsorted(levels, at, side="right") - 1, 0, len(levels) - 2)
        over = at - levels[cell]
        slope = (width[cell + 1] - width[cell]) / (levels[cell + 1] - levels[cell])
        return np.asarray(below[cell] + over * (width[cell] + 0.5 * slope * over))

    def _widths(self, levels: Array, normal: Array) -> Array:
        """Return the widths of the polygon across `normal` at levels (l,); at an end a whole side may lie."""
        along = np.array([-normal[1], normal[0]])
        far = 4.0 * self.reach
        start, end = (
            level * normal + sign * far * along for level, sign in ((levels[:, None], -1), (levels[:, None], 1))
        )
        first, last = self.inside(start, end)
        return np.asarray(2.0 * far * np.maximum(last - first, 0.0))


def _rounded(share: Array) -> Array:
    """Return shares with those next to 0 and 1 set to them."""
    share = np.where(np.abs(share) < ROUNDING, 0.0, share)
    return np.asarray(np.where(np.abs(share - 1.0) < ROUNDING, 1.0, share))


def _along(places: Array, share: Array) -> Array:
    """Return the places (m, 2) at shares (m,) of segments (m, 2, 2), ends exactly."""
    found = places[:, 0] + share[:, None] * (places[:, 1] - places[:, 0])
    return np.where((share == 0.0)[:, None], places[:, 0], np.where((share == 1.0)[:, None], places[:, 1], found))
