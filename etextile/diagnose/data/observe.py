"""What a simulation would have measured: every channel predicted at the measured points.

A `Record` is what is kept of one simulator run: the motion of all nodes and the force, small enough to cache. Between
output steps it is interpolated by cubic splines, along the edge too (mirrored at symmetry planes), so that a coarse
lattice adds no interpolation error of its own where the answer is smooth.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from etextile.diagnose.data.points import Points, Series
from etextile.diagnose.data.surface import Surface, pulls
from etextile.types import Array
from etextile.vocabulary import BEND, CLAMP, EDGE, FIELD, FORCE, HEIGHT, MOMENT, PULL, SLIP, STRAIN


PEAKS = ("warp_strain", "weft_strain", "diagonal_strain", "clamp_line_force", "shear_angle", "strain_rate")
MIN_STEPS = 4
MOTIONS = ("warp", "weft", "height")
"""Internal variables a record keeps the largest value of, per step (engineering strains, N/mm, deg, 1/s); the steps
(the start included) that a run must have reached to be interpolated; components of a position or motion."""


@dataclass(frozen=True)
class Record:
    """One simulator run, the flat start included as first step.

    displacement (S,) mm as an instrument records it (or pressure, bar; angle, deg), force (S,) N (or moment, N mm),
    positions (S, X, Y, 3) mm of the
    nodes on lines x (X,) and y (Y,); of a cut piece (S, N, 1, 3), its flat nodes at x (N,), y (N,). Both symmetry
    flags; peaks (S, len(PEAKS)); angle (deg) of the warp to x. `completed` False: no equilibrium beyond the end.
    Of a worn piece the first step is the straight limb, and slip (S, X, Y) mm is how far nodes have slipped along the
    skin since. `solves`: linear solves that the run took.
    """

    x: Array
    y: Array
    symmetry: tuple[bool, bool]
    displacement: Array
    force: Array
    positions: Array
    peaks: Array
    completed: bool = True
    angle: float = 0.0
    slip: Array = field(default_factory=lambda: np.zeros((0, 0, 0)))
    solves: int = 0

    @property
    def rectangular(self) -> bool:
        """Whether the nodes stand on lines along x and y."""
        return self.positions.shape[1:3] == (len(self.x), len(self.y))

    @property
    def cell(self) -> float:
        """Size of a cell along x, mm; of a cut piece the mean distance of nodes."""
        if self.rectangular:
            return float(self.x[1] - self.x[0])
        return float(np.sqrt(np.ptp(self.x) * np.ptp(self.y) / len(self.x)))

    @cached_property
    def surface(self) -> Surface:
        """The run as motion of material points over its load."""
        x, y = (self.x, self.y)
        if self.rectangular:
            x, y = (axis.ravel() for axis in np.meshgrid(self.x, self.y, indexing="ij"))
        flat = np.stack([x, y, np.zeros(len(x))], axis=1)
        motion = self.positions.reshape(len(self.displacement), -1, 3) - flat
        return Surface(
            self.displacement, self.force, flat[:, :2], motion, self.symmetry, float(np.radians(self.angle)),
            self.completed,
        )  # fmt: skip

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
            predicted[mask] = _OBSERVERS[item.channel](record, points.where(mask), item)
    predicted[points.displacement > record.reach * (1.0 + 1e-9)] = np.nan
    return predicted


def _clipped(record: Record, points: Points) -> Array:
    return np.clip(points.displacement, record.displacement[0], record.reach)


def _force(record: Record, points: Points, item: Series) -> Array:
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(record.displacement, record.force)(_clipped(record, points)))


def _moment(record: Record, points: Points, item: Series) -> Array:
    """Return the bending moment, which a softening law bends too sharply for a spline."""
    return record.surface.at_load(record.force, points.displacement)


def _edge(record: Record, points: Points, item: Series) -> Array:
    """Return a coordinate of points of a free edge, y = y_max (side +) or y = y_min (side -)."""
    component = MOTIONS.index(item.quantity)
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


def _strain(record: Record, points: Points, item: Series) -> Array:
    """Return engineering strain of warp or weft segments, interpolated between their midpoints."""
    from scipy.interpolate import RegularGridInterpolator

    axis = 0 if item.quantity == "strain_warp" else 1
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


def _clamp(record: Record, points: Points, item: Series) -> Array:
    """Return how far the fabric that lay at the clamp line x_max has come out of the clamp, mm along the fabric."""
    from scipy.interpolate import RegularGridInterpolator

    slip = np.linalg.norm(record.positions[:, -1] - record.positions[0, -1], axis=2)
    place = np.abs(points.weft0) if record.symmetry[1] else points.weft0
    at = np.stack([_clipped(record, points), np.clip(place, record.y[0], record.y[-1])], axis=1)
    return np.asarray(RegularGridInterpolator((record.displacement, record.y), slip)(at))


def _mark(record: Record, points: Points, item: Series) -> Array:
    """Return how far marks have slipped along the skin, mm; the sides of the plane of flexion are alike."""
    from scipy.interpolate import RegularGridInterpolator

    weft0 = np.abs(points.weft0) if record.symmetry[1] else points.weft0
    places = (np.clip(points.warp0, record.x[0], record.x[-1]), np.clip(weft0, record.y[0], record.y[-1]))
    at = np.stack([_clipped(record, points), *places], axis=1)
    return np.asarray(RegularGridInterpolator((record.displacement, record.x, record.y), record.slip)(at))


def _pull(record: Record, points: Points, item: Series) -> Array:
    """Return the force at displacements that count from where the force is the preload."""
    return pulls(record.surface, points.displacement, item.preload)


def _height(record: Record, points: Points, item: Series) -> Array:
    surface = record.surface
    return surface.at_load(surface.height, points.displacement)


def _motion(record: Record, points: Points, item: Series) -> Array:
    """Return a component of the motion of material points."""
    places = np.stack([points.warp0, points.weft0], axis=1)
    return record.surface.motion_of(places, points.displacement)[:, MOTIONS.index(item.quantity)]


_OBSERVERS = {
    FORCE: _force, PULL: _pull, EDGE: _edge, STRAIN: _strain, CLAMP: _clamp, HEIGHT: _height, FIELD: _motion,
    BEND: _moment, MOMENT: _force, SLIP: _mark,
}  # fmt: skip
