"""Cross-sections of a straight limb: girths, and where a fabric that lies around it comes to stand.

A section is the ring in which the plane x = const cuts the smooth surface through the mesh (refine.py), its points in
the order of their polar angle about the ring's middle, so a limb must be seen from there as a star. Rings are
resampled by their length from the outer line (towards +z) on, first towards +y.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from etextile.contact.refine import refined
from etextile.contact.skinning import CREASE_DEG, SkinnedMesh
from etextile.types import Array, IntArray


STATIONS, RING = 81, 128
"""Sections along a limb, and points of each."""
TOLERANCE = 3e-4
"""Largest distance of the refined mesh from the smooth surface over the length of the segments."""
MARGIN = 0.02
"""Share of the length at either end that is not cut: there the caps are."""


@dataclass(frozen=True)
class Sections:
    """Stations (S,) along x, rings (S, RING, 2) in y and z, their middles (S, 2) and girths (S,), box (2, 3); mm."""

    stations: Array = field(repr=False)
    rings: Array = field(repr=False)
    middles: Array = field(repr=False)
    girths: Array
    box: Array

    @property
    def middle(self) -> Array:
        """Mean middle (2,) of the sections."""
        return np.asarray(self.middles.mean(axis=0))

    def radius(self, along: Array) -> Array:
        """Return the girth (n,) over 2 pi at places along the limb (n,); beyond the ends that of the last section."""
        return np.interp(along, self.stations, self.girths) / (2.0 * np.pi)

    def fitted(self, places: Array) -> Array:
        """Return nodes (n, 3) of a round piece about the mean middle as far round on the sections, grown if loose."""
        off = places[:, 1:] - self.middle
        turn = np.mod(np.arctan2(off[:, 0], off[:, 1]) / (2.0 * np.pi), 1.0)
        ring, middle = self._at(places[:, 0], turn)
        ease = np.maximum(np.hypot(off[:, 0], off[:, 1]) / self.radius(places[:, 0]), 1.0)
        return np.column_stack([places[:, 0], middle + ease[:, None] * (ring - middle)])

    def _at(self, along: Array, turn: Array) -> tuple[Array, Array]:
        """Return points (n, 2) of the skin at places along and shares of the girth around, and the middles (n, 2)."""
        place = np.interp(along, self.stations, np.arange(len(self.stations), dtype=float))
        low = np.minimum(place.astype(np.int64), len(self.stations) - 2)
        up = (place - low)[:, None]
        round_ = turn * RING
        first = round_.astype(np.int64) % RING
        on = (round_ - np.floor(round_))[:, None]
        rings = [(1.0 - on) * self.rings[at, first] + on * self.rings[at, (first + 1) % RING] for at in (low, low + 1)]
        middle = (1.0 - up) * self.middles[low] + up * self.middles[low + 1]
        return (1.0 - up) * rings[0] + up * rings[1], middle


def sections_of(mesh: SkinnedMesh, length: float) -> Sections:
    """Return the sections of the straight limb whose segments are `length` mm long."""
    straight = mesh.bent(0.0)
    fine = refined(straight, mesh.faces, tolerance=TOLERANCE * length, crease=CREASE_DEG)
    sides = np.sort(fine.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges = np.unique(sides, axis=0)
    reach = (1.0 - MARGIN) * min(length, -float(straight[:, 0].min()), float(straight[:, 0].max()))
    stations = np.linspace(-reach, reach, STATIONS)
    found = [_ring(fine.vertices, edges, x) for x in stations]
    poses = np.concatenate([mesh.bent(angle) for angle in np.radians([0.0, 40.0, 80.0, 120.0, 160.0])])
    return Sections(
        stations,
        np.stack([ring for ring, _, _ in found]),
        np.stack([middle for _, middle, _ in found]),
        np.array([girth for _, _, girth in found]),
        np.stack([poses.min(axis=0), poses.max(axis=0)]),
    )


def _ring(vertices: Array, edges: IntArray, x: float) -> tuple[Array, Array, float]:
    """Return points (RING, 2) of a section by their share of the girth, its middle (2,) and its girth, mm."""
    start, end = vertices[edges[:, 0]], vertices[edges[:, 1]]
    crossed = (start[:, 0] <= x) != (end[:, 0] <= x)
    start, end = start[crossed], end[crossed]
    share = ((x - start[:, 0]) / (end[:, 0] - start[:, 0]))[:, None]
    points = (start + share * (end - start))[:, 1:]
    middle = _area_middle(_sorted(points, 0.5 * (points.min(axis=0) + points.max(axis=0))))
    points = _sorted(points, middle)
    # the ring begins on the outer line, whose point is put in between
    turn = np.arctan2(*(points - middle).T)
    begin = np.searchsorted(turn, 0.0)
    before, after = points[begin - 1], points[begin % len(points)]
    way = (middle[0] - before[0]) / (after[0] - before[0]) if after[0] != before[0] else 0.0
    outer = before + np.clip(way, 0.0, 1.0) * (after - before)
    ring = np.concatenate([outer[None], np.roll(points, -begin, axis=0), outer[None]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(ring, axis=0), axis=1))])
    wanted = np.arange(RING) / RING * along[-1]
    resampled = np.stack([np.interp(wanted, along, ring[:, axis]) for axis in (0, 1)], axis=1)
    return resampled, middle, float(along[-1])


def _sorted(points: Array, middle: Array) -> Array:
    """Return points (n, 2) by their angle about a middle, from -pi to pi, 0 towards +z and growing towards +y."""
    return points[np.argsort(np.arctan2(*(points - middle).T))]


def _area_middle(ring: Array) -> Array:
    """Return the middle of the area that a ring (n, 2) encloses."""
    after = np.roll(ring, -1, axis=0)
    twice = ring[:, 0] * after[:, 1] - ring[:, 1] * after[:, 0]
    return np.asarray(((ring + after) * twice[:, None]).sum(axis=0) / (3.0 * twice.sum()))
