"""What a simulation would have measured: every channel predicted at the measured points.

A `Record` is what is kept of one simulator run: the motion of all nodes and the force, small enough to cache. Between
output steps it is interpolated by cubic splines, along the edge too (mirrored at symmetry planes), so that a coarse
lattice adds no interpolation error of its own where the answer is smooth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.diagnose.data.points import Points
from etextile.types import Array
from etextile.vocabulary import CLAMP, EDGE, FORCE, STRAIN


PEAKS = ("warp_strain", "weft_strain", "diagonal_strain", "clamp_line_force", "shear_angle", "strain_rate")
MIN_STEPS = 4
"""Internal variables a record keeps the largest value of, per step (engineering strains, N/mm, deg, 1/s), and the
steps (the start included) that a run must have reached to be interpolated."""


@dataclass(frozen=True)
class Record:
    """One simulator run on a rectangular lattice, the flat start included as first step.

    displacement (S,) mm as an instrument records it, force (S,) N, positions (S, X, Y, 3) mm of the nodes on lines
    x (X,) and y (Y,); both symmetry flags; peaks (S, len(PEAKS)). `completed` False: no equilibrium beyond the end.
    """

    x: Array
    y: Array
    symmetry: tuple[bool, bool]
    displacement: Array
    force: Array
    positions: Array
    peaks: Array
    completed: bool = True

    @property
    def reach(self) -> float:
        """Largest displacement that was reached, mm."""
        return float(self.displacement[-1])


def observe(record: Record, points: Points) -> Array:
    """Return the predicted values (n,) at measured points; NaN beyond what the run reached."""
    predicted = np.full(len(points), np.nan)
    if len(record.displacement) < MIN_STEPS:
        return predicted
    for i, item in enumerate(points.series):
        mask = points.owner == i
        if np.any(mask):
            predicted[mask] = _OBSERVERS[item.channel](record, points.where(mask), item.quantity)
    predicted[points.displacement > record.reach * (1.0 + 1e-9)] = np.nan
    return predicted


def _clipped(record: Record, points: Points) -> Array:
    return np.clip(points.displacement, record.displacement[0], record.reach)


def _force(record: Record, points: Points, quantity: str) -> Array:
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(record.displacement, record.force)(_clipped(record, points)))


def _edge(record: Record, points: Points, quantity: str) -> Array:
    """Return a coordinate of points of a free edge, y = y_max (side +) or y = y_min (side -)."""
    component = ("warp", "weft", "height").index(quantity)
    upper = points.weft0 > 0.0
    found = _along(record, -1, component, points)
    if np.all(upper):
        return found
    if record.symmetry[1]:
        return np.where(upper, found, -found if component == 1 else found)
    return np.where(upper, found, _along(record, 0, component, points))


def _along(record: Record, line: int, component: int, points: Points) -> Array:
    """Return a coordinate on a line of nodes along x at displacements and material warp coordinates of the points."""
    from scipy.interpolate import CubicSpline

    x, values = _mirrored(record.x, record.positions[:, :, line, component], cut=record.symmetry[0], odd=component == 0)
    places, number = np.unique(points.warp0, return_inverse=True)
    at_places = np.asarray(CubicSpline(x, values, axis=1)(np.clip(places, x[0], x[-1])))
    times, when = np.unique(_clipped(record, points), return_inverse=True)
    table = np.asarray(CubicSpline(record.displacement, at_places, axis=0)(times))
    return np.asarray(table[when, number])


def _mirrored(lines: Array, values: Array, *, cut: bool, odd: bool) -> tuple[Array, Array]:
    """Return lines and values (S, X) continued to the other side of a symmetry plane at 0."""
    if not cut:
        return lines, values
    sign = -1.0 if odd else 1.0
    return np.concatenate([-lines[:0:-1], lines]), np.concatenate([sign * values[:, :0:-1], values], axis=1)


def _strain(record: Record, points: Points, quantity: str) -> Array:
    """Return engineering strain of warp or weft segments, interpolated between their midpoints."""
    from scipy.interpolate import RegularGridInterpolator

    axis = 0 if quantity == "strain_warp" else 1
    lines = record.x if axis == 0 else record.y
    rest = np.diff(lines)
    length = np.linalg.norm(np.diff(record.positions, axis=1 + axis), axis=-1)
    strain = length / (rest[None, :, None] if axis == 0 else rest[None, None, :]) - 1.0
    middle = 0.5 * (lines[1:] + lines[:-1])
    x, y = (middle, record.y) if axis == 0 else (record.x, middle)
    places = [
        np.clip(np.abs(place) if cut else place, grid[0], grid[-1])
        for place, cut, grid in zip((points.warp0, points.weft0), record.symmetry, (x, y), strict=True)
    ]
    at = np.stack([_clipped(record, points), *places], axis=1)
    return np.asarray(RegularGridInterpolator((record.displacement, x, y), strain)(at))


def _clamp(record: Record, points: Points, quantity: str) -> Array:
    """Return how far the fabric that lay at the clamp line x_max has come out of the clamp, mm along the fabric."""
    from scipy.interpolate import RegularGridInterpolator

    slip = np.linalg.norm(record.positions[:, -1] - record.positions[0, -1], axis=2)
    place = np.abs(points.weft0) if record.symmetry[1] else points.weft0
    at = np.stack([_clipped(record, points), np.clip(place, record.y[0], record.y[-1])], axis=1)
    return np.asarray(RegularGridInterpolator((record.displacement, record.y), slip)(at))


_OBSERVERS = {FORCE: _force, EDGE: _edge, STRAIN: _strain, CLAMP: _clamp}
