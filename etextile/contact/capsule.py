"""Capsule: a rod with round ends, the simplest model of a limb or a finger, with an exact signed distance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.contact.body import Distance, evaluation_points, require_positive
from etextile.contact.implicit import capped_cone, implicit_mesh
from etextile.types import Array, IntArray


@dataclass(frozen=True)
class Capsule:
    """Capsule along x: all points within `radius` mm of a line of `length` mm centred in the origin.

    `length` is that of the straight part, from cap centre to cap centre; from end to end the body measures
    length + 2 radius. The Hessian jumps where the straight part meets the caps.
    """

    radius: float
    length: float

    def distance(self, points: Array) -> Distance:
        """Return the exact signed distance of `points` (n, 3)."""
        from etextile.contact import kernels

        return Distance(*kernels.capsule_distance(evaluation_points(points), self.radius, 0.5 * self.length))

    def surface(self) -> tuple[Array, IntArray]:
        """Return a mesh of some thousand nearly equilateral triangles."""
        area = 2 * np.pi * self.radius * (self.length + 2 * self.radius)
        ends = np.array([[-0.5 * self.length, 0, 0], [0.5 * self.length, 0, 0]])
        edge = min(float(np.sqrt(area / 2000)), self.radius / 4)
        return implicit_mesh(capped_cone(ends[0], ends[1], self.radius, self.radius), self.bounds(), edge=edge)

    def bounds(self) -> Array:
        """Return the box (2, 3) around the capsule."""
        corner = np.array([0.5 * self.length + self.radius, self.radius, self.radius])
        return np.stack([-corner, corner])

    def support(self, direction: Array) -> float:
        """Return radius |direction| + |direction_x| length / 2."""
        return float(self.radius * np.linalg.norm(direction) + 0.5 * self.length * abs(direction[0]))


def capsule(*, radius: float, length: float) -> Capsule:
    """Return a capsule along x (mm; `length` between the cap centres); raises BadInput unless both are positive."""
    require_positive(radius=radius, length=length)
    return Capsule(float(radius), float(length))
