"""Smooth distance grid: the signed distance of a mesh, baked once into a tricubic B-spline.

The distance to triangles has kinks, and a kink under a fabric node stalls Newton. Sampled on a regular grid and
interpolated by cubic B-splines it is twice continuously differentiable, costs the same for any mesh, and its gap,
gradient and Hessian belong to one function. Baking takes about a second, so the result is kept on disk.
"""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

import numpy as np

from etextile.contact.body import Distance
from etextile.kept import keep, recall
from etextile.types import Array, BoolArray, IntArray


BAKING = 2
"""Version of the baking: a change of it makes grids on disk unknown."""

PADDING, RIM = 7, 4
"""Grid cells around the mesh, and how many of them, outermost, only keep the end of the spline away."""

SMOOTHNESS = 4e-3
"""Largest distance of the small triangles behind the samples from the smooth surface, in mm per (mm spacing)^2."""

SHEET = 1
"""Cells around a triangle that must all lie inside for it to be a sheet within a body that runs into itself."""

BAND = 1.5
"""Cells around the mesh in which every triangle is asked for its distance."""


@dataclass(frozen=True)
class DistanceGrid:
    """Spline coefficients (i, j, k) of a signed distance in mm; node (i, j, k) lies at origin + spacing (i, j, k)."""

    coefficients: Array = field(repr=False)
    origin: Array
    spacing: float

    def distance(self, points: Array) -> Distance:
        """Return the interpolated distance of `points` (n, 3); outside the grid a positive lower bound."""
        from etextile.contact import kernels

        return Distance(*kernels.spline_distance(points, self.coefficients, self.origin, self.spacing, RIM))


def grid_shape(vertices: Array, spacing: float) -> tuple[int, int, int]:
    """Return the number of nodes per axis of the padded grid around `vertices`."""
    extent = np.ceil(np.ptp(vertices, axis=0) / spacing).astype(int) + 2 * PADDING + 1
    return int(extent[0]), int(extent[1]), int(extent[2])


def box(vertices: Array, spacing: float) -> tuple[Array, tuple[int, int, int]]:
    """Return the origin (3,) and the number of nodes per axis of the padded grid around `vertices`."""
    shape = grid_shape(vertices, spacing)
    extent = (np.array(shape) - 1) * spacing
    return 0.5 * (vertices.min(axis=0) + vertices.max(axis=0) - extent), shape


def bake(vertices: Array, faces: IntArray, spacing: float) -> DistanceGrid:
    """Return the distance grid of a watertight mesh wound outward.

    The spline adds an error of the order spacing^4 / radius^3 / 400 to the samples of `signed`.
    """
    from scipy.ndimage import spline_filter

    from etextile.contact.refine import CREASE_DEG

    origin, shape = box(vertices, spacing)
    samples = signed((vertices, faces), spacing, origin, shape, crease=CREASE_DEG)
    return DistanceGrid(spline_filter(samples, order=3, mode="mirror"), origin, spacing)


def signed(
    mesh: tuple[Array, IntArray], spacing: float, origin: Array, shape: tuple[int, int, int], *, crease: float
) -> Array:
    """Return the signed distance (shape) of a watertight mesh wound outward at the nodes of a grid.

    The mesh is taken as the smooth surface through its vertices (refine.py): small triangles plus the bulge of the
    curved patch over them; edges of more than `crease` deg stay sharp. Where it runs into itself the distance is that
    of the union.
    """
    from etextile.contact import refine, triangles

    tolerance = float(np.clip(SMOOTHNESS * spacing**2, 4e-3, 4e-2))
    fine = refine.refined(*mesh, tolerance=tolerance, crease=crease)
    corners = np.ascontiguousarray((fine.vertices - origin)[fine.faces])
    winding = triangles.crossings(corners, spacing, shape)
    shifts = refine.midpoint_shifts(fine)
    faces = fine.faces
    if winding.max(initial=0) > 1:
        outer = ~_within(corners, winding > 0, spacing)
        corners, faces, shifts = np.ascontiguousarray(corners[outer]), faces[outer], shifts[outer]
    squared, closest = np.full(shape, np.inf), np.full(shape, -1, dtype=np.int32)
    fixed = (BAND - 0.5) * spacing
    triangles.band(corners, spacing, BAND, squared, closest)
    triangles.sweep(corners, spacing, fixed, squared, closest)
    order = np.argsort(faces.reshape(-1), kind="stable")
    starts = np.searchsorted(faces.reshape(-1)[order], np.arange(len(fine.vertices) + 1))
    triangles.descend(corners, faces, (starts, order // 3), spacing, fixed, squared, closest)
    found = np.where(winding > 0, -np.sqrt(squared), np.sqrt(squared))
    return np.asarray(found - triangles.bulge(corners, shifts, spacing, closest))


def _within(corners: Array, inside: BoolArray, spacing: float) -> BoolArray:
    """Return which triangles (f,) lie inside of a solid, more than a cell from where it ends."""
    from scipy.ndimage import minimum_filter

    deep = minimum_filter(inside, size=2 * SHEET + 1, mode="constant", cval=False)
    node = np.rint(corners.mean(axis=1) / spacing).astype(np.int64)
    return np.asarray(deep[tuple(np.clip(node, 0, np.array(inside.shape) - 1).T)])


def baked(vertices: Array, faces: IntArray, spacing: float) -> DistanceGrid:
    """Return the distance grid of a mesh from memory, from disk or newly baked (and then kept in both)."""
    digest = hashlib.sha256(f"{BAKING} {spacing!r} {vertices.shape} {faces.shape}".encode())
    digest.update(np.ascontiguousarray(vertices, dtype="<f8").tobytes())
    digest.update(np.ascontiguousarray(faces, dtype="<i8").tobytes())
    return _baked(_Mesh(vertices, faces, spacing, digest.hexdigest()))


@dataclass(frozen=True, eq=False)
class _Mesh:
    """What is to be baked, compared by `key` alone."""

    vertices: Array
    faces: IntArray
    spacing: float
    key: str

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Mesh) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)


@lru_cache(maxsize=8)
def _baked(mesh: _Mesh) -> DistanceGrid:
    file = cache_folder() / f"distance-{mesh.key[:32]}.npz"
    grid = _read(file, mesh)
    if grid is None:
        grid = bake(mesh.vertices, mesh.faces, mesh.spacing)
        with suppress(OSError):
            _write(file, grid)
    grid.coefficients.setflags(write=False)
    return grid


def cache_folder() -> Path:
    """Return the folder for baked grids: ETEXTILE_CACHE_DIR, or the platform's folder for caches."""
    from platformdirs import user_cache_dir

    return Path(os.environ.get("ETEXTILE_CACHE_DIR") or user_cache_dir("etextile", appauthor=False))


def _read(file: Path, mesh: _Mesh) -> DistanceGrid | None:
    """Return the grid stored in `file`; None when there is none or it is damaged."""
    stored = recall(file, ("coefficients", "origin", "spacing"))
    if stored is None:
        return None
    grid = DistanceGrid(stored["coefficients"], stored["origin"], float(stored["spacing"]))
    sound = grid.coefficients.shape == grid_shape(mesh.vertices, mesh.spacing) and grid.spacing == mesh.spacing
    return grid if sound and bool(np.isfinite(grid.coefficients).all()) else None


def _write(file: Path, grid: DistanceGrid) -> None:
    """Store the grid; no reader ever sees half a file."""
    keep(file, {"coefficients": grid.coefficients, "origin": grid.origin, "spacing": grid.spacing}, packed=False)
