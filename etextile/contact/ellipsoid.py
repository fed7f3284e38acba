"""Ellipsoid: the simplest body whose two curvatures differ, with an exact signed distance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.contact.body import Distance, evaluation_points, require
from etextile.contact.sphere import unit_icosphere
from etextile.types import Array, IntArray


@dataclass(frozen=True)
class Ellipsoid:
    """Ellipsoid (x/a)^2 + (y/b)^2 + (z/c)^2 = 1 with `semi_axes` = (a, b, c) mm.

    The closest point is found as in D. Eberly, "Distance from a point to an ellipse, an ellipse arc, an ellipsoid"
    (Geometric Tools, 2013), inside and outside, also for equal axes and for points on the focal disc.
    """

    semi_axes: tuple[float, float, float]

    def distance(self, points: Array) -> Distance:
        """Return the exact signed distance of `points` (n, 3)."""
        from etextile.contact import kernels

        return Distance(*kernels.ellipsoid_distance(evaluation_points(points), np.array(self.semi_axes)))

    def surface(self) -> tuple[Array, IntArray]:
        """Return a stretched icosphere of 5120 triangles."""
        vertices, faces = unit_icosphere()
        return vertices * self.semi_axes, faces

    def bounds(self) -> Array:
        """Return the box (2, 3) around the ellipsoid."""
        return np.outer([-1.0, 1.0], self.semi_axes)

    def support(self, direction: Array) -> float:
        """Return |(a dx, b dy, c dz)|."""
        return float(np.linalg.norm(np.array(self.semi_axes) * direction))


def ellipsoid(*, semi_axes: tuple[float, float, float]) -> Ellipsoid:
    """Return an ellipsoid with the three `semi_axes` along x, y, z in mm; raises BadInput unless all are positive."""
    if len(semi_axes) != 3:
        require([(f"needs three lengths, along x, y and z (got {len(semi_axes)})", "semi_axes")])
    a, b, c = (float(axis) for axis in semi_axes)
    if not all(np.isfinite(axis) and axis > 0 for axis in (a, b, c)):
        require([(f"must be three positive lengths (got [{a:g}, {b:g}, {c:g}])", "semi_axes")])
    if max(a, b, c) > 1000.0 * min(a, b, c):
        require([(f"must not differ by more than a factor of 1000 (got [{a:g}, {b:g}, {c:g}])", "semi_axes")])
    return Ellipsoid((a, b, c))
