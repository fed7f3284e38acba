"""Sphere: the punch of the standard test, with an exact signed distance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.contact.body import Distance, evaluation_points, require_positive
from etextile.types import Array, IntArray


@dataclass(frozen=True)
class Sphere:
    """Sphere of `radius` mm about the origin: gap = |x| - radius."""

    radius: float

    def distance(self, points: Array) -> Distance:
        """Return the exact signed distance of `points` (n, 3)."""
        from etextile.contact import kernels

        return Distance(*kernels.sphere_distance(evaluation_points(points), self.radius))

    def surface(self) -> tuple[Array, IntArray]:
        """Return an icosphere of 5120 triangles."""
        vertices, faces = unit_icosphere()
        return self.radius * vertices, faces

    def bounds(self) -> Array:
        """Return the box (2, 3) around the sphere."""
        return self.radius * np.array([[-1.0] * 3, [1.0] * 3])

    def support(self, direction: Array) -> float:
        """Return radius |direction|."""
        return float(self.radius * np.linalg.norm(direction))


def sphere(*, radius: float) -> Sphere:
    """Return a sphere of `radius` mm; raises BadInput unless that is positive."""
    require_positive(radius=radius)
    return Sphere(float(radius))


def unit_icosphere() -> tuple[Array, IntArray]:
    """Return vertices and triangles of a sphere of radius 1 as an icosahedron split four times."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=4)
    return np.array(ball.vertices, dtype=np.float64), np.array(ball.faces, dtype=np.int64)
