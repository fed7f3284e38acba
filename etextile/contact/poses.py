r"""Distance grids of a mesh at many flexions, joined by cubic splines in the angle too.

The signed distance d(x, theta) is sampled on one grid in space and at poses in the angle, and interpolated by cubic
B-splines in all four: d = sum_k B_k(theta) d_k(x) is twice continuously differentiable, and the rate that moment and
energy balance need is the derivative of the very gap that presses, sum_k B_k'(theta) d_k(x). At one flexion the sum is
a grid like that of any mesh. Between poses 5 degrees apart the error is of the order step^4 / 384 times the fourth
derivative, 1e-6 mm for a segment that turns; where nearest points jump (in the crook, deep inside) it is larger.

A skinned mesh runs into itself in the crook. Inside is where the winding number is above zero, and sheets of the mesh
that lie inside are left out (grid.py), so that the distance is that of the union of what overlaps.
"""

from __future__ import annotations

import hashlib
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np

from etextile.contact import grid
from etextile.contact.grid import DistanceGrid
from etextile.contact.skinning import CREASE_DEG, SkinnedMesh
from etextile.kept import keep, recall
from etextile.types import Array


STEP_DEG, LAST_DEG = 5.0, 160.0
"""Poses stand so far apart, from straight to as far as a joint bends."""

POSES = tuple(np.radians(np.arange(0.0, LAST_DEG + 0.5 * STEP_DEG, STEP_DEG)).tolist())
"""Flexions, rad."""

REMEMBERED = 4
"""Grids of single flexions that are kept at hand: of the increment and of what it starts from, with their rates."""


@dataclass(frozen=True, eq=False)
class PosedGrids:
    """Spline coefficients (k, i, j, l) of the distance over flexions (k,) and grid; origin (3,) and spacing of it."""

    poses: tuple[float, ...] = field(repr=False)
    coefficients: Array = field(repr=False)
    origin: Array
    spacing: float

    def at(self, flexion: float) -> DistanceGrid:
        """Return the distance grid at a flexion (rad)."""
        return _blended(self, flexion, 0)

    def rate_at(self, flexion: float) -> DistanceGrid:
        """Return the grid of the distance's derivative by the flexion, mm per rad."""
        return _blended(self, flexion, 1)


@lru_cache(maxsize=REMEMBERED)
def _blended(grids: PosedGrids, flexion: float, order: int) -> DistanceGrid:
    """Return the grid at a flexion (rad), or its derivative."""
    shares = basis(grids.poses, flexion, order)
    chosen = np.flatnonzero(shares)
    blended = np.tensordot(shares[chosen], grids.coefficients[chosen], 1)
    return DistanceGrid(np.ascontiguousarray(blended), grids.origin, grids.spacing)


def basis(poses: tuple[float, ...], flexion: float, order: int = 0) -> Array:
    """Return the splines (P,) at a flexion (rad), or their derivatives by it, for coefficients per pose."""
    from scipy.interpolate import BSpline

    spline = BSpline(_knots(poses), np.eye(len(poses)), 3)
    return np.asarray((spline.derivative(order) if order else spline)(np.clip(flexion, poses[0], poses[-1])))


def _knots(poses: tuple[float, ...]) -> Array:
    """Return the knots of a cubic spline through the poses: all but the second and the last but one (not a knot)."""
    return np.concatenate([np.full(4, poses[0]), poses[2:-2], np.full(4, poses[-1])])


@dataclass(frozen=True, eq=False)
class PosedMesh:
    """A skinned mesh whose grids are made when they are asked for: from memory, from disk or newly baked.

    poses: flexions (rad) at which they are baked, five or more.
    """

    mesh: SkinnedMesh
    spacing: float
    poses: tuple[float, ...] = field(default=POSES, repr=False)

    @cached_property
    def key(self) -> str:
        """Hash of all that the grids depend on."""
        mesh = self.mesh
        sizes = f"{mesh.vertices.shape} {mesh.faces.shape}"
        head = f"{grid.BAKING} {CREASE_DEG} {self.spacing!r} {mesh.rest!r} {mesh.kind} {sizes}"
        digest = hashlib.sha256(f"{head} {self.poses!r}".encode())
        for values, kind in ((mesh.vertices, "<f8"), (mesh.faces, "<i8"), (mesh.weight, "<f8")):
            digest.update(np.ascontiguousarray(values, dtype=kind).tobytes())
        return digest.hexdigest()

    @property
    def grids(self) -> PosedGrids:
        """The grids at all poses."""
        return _kept(self)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, PosedMesh) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)


@lru_cache(maxsize=2)
def _kept(posed: PosedMesh) -> PosedGrids:
    file = grid.cache_folder() / f"poses-{posed.key[:32]}.npz"
    found = _read(file, posed)
    if found is None:
        found = _baked(posed)
        with suppress(OSError):
            content = {"coefficients": found.coefficients, "origin": found.origin, "spacing": found.spacing}
            keep(file, content, packed=False)
    found.coefficients.setflags(write=False)
    return found


def _baked(posed: PosedMesh) -> PosedGrids:
    """Return grids newly baked, pose by pose in one box."""
    from scipy.interpolate import make_interp_spline
    from scipy.ndimage import spline_filter

    mesh, poses = posed.mesh, posed.poses
    origin, shape = grid.box(everywhere(mesh, poses), posed.spacing)

    def samples(flexion: float) -> Array:
        solid = mesh.bent(flexion), mesh.faces
        found = grid.signed(solid, posed.spacing, origin, shape, crease=CREASE_DEG)
        return np.asarray(spline_filter(found, order=3, mode="mirror"))

    stack = np.stack([samples(flexion) for flexion in poses])
    spline = make_interp_spline(poses, stack.reshape(len(stack), -1), k=3, t=_knots(poses))
    return PosedGrids(poses, np.ascontiguousarray(spline.c).reshape(stack.shape), origin, posed.spacing)


def _read(file: Path, posed: PosedMesh) -> PosedGrids | None:
    """Return the grids stored in `file`; None when there are none or they are damaged."""
    stored = recall(file, ("coefficients", "origin", "spacing"))
    if stored is None:
        return None
    found = PosedGrids(posed.poses, stored["coefficients"], stored["origin"], float(stored["spacing"]))
    shape = (len(posed.poses), *grid.grid_shape(everywhere(posed.mesh, posed.poses), posed.spacing))
    sound = found.coefficients.shape == shape and found.spacing == posed.spacing
    return found if sound and bool(np.isfinite(found.coefficients).all()) else None


def everywhere(mesh: SkinnedMesh, poses: tuple[float, ...] = POSES) -> Array:
    """Return the vertices of all poses (P v, 3), for their common box."""
    return np.concatenate([mesh.bent(flexion) for flexion in poses])
