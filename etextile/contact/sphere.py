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
    """Return vertices and outward triangles of a sphere of radius 1 as an icosahedron split four times."""
    vertices, faces = _icosahedron()
    for _ in range(4):
        sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
        edges, middle = np.unique(sides.reshape(-1, 2), axis=0, return_inverse=True)
        a, b, c = faces.T
        ab, bc, ca = (middle.reshape(-1, 3) + len(vertices)).T
        vertices = np.concatenate([vertices, vertices[edges].sum(axis=1)])
        vertices /= np.linalg.norm(vertices, axis=1)[:, None]
        faces = np.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=1).reshape(-1, 3)
    return vertices, faces


def _icosahedron() -> tuple[Array, IntArray]:
    """Return the 12 vertices, two poles and two rings of five, and the 20 outward triangles."""
    height, width = 1.0 / np.sqrt(5.0), 2.0 / np.sqrt(5.0)
    turn = np.arange(5) * 2.0 * np.pi / 5.0
    rings = [
        np.stack([width * np.cos(angle), width * np.sin(angle), np.full(5, z)], axis=1)
        for angle, z in ((turn, height), (turn + np.pi / 5.0, -height))
    ]
    vertices = np.concatenate([[[0.0, 0.0, 1.0]], *rings, [[0.0, 0.0, -1.0]]])
    k, onward = np.arange(5), (np.arange(5) + 1) % 5
    top, low, pole = np.zeros(5, dtype=np.int64), 6 + k, np.full(5, 11)
    fans = ((top, 1 + k, 1 + onward), (1 + k, low, 1 + onward), (1 + onward, low, 6 + onward), (low, pole, 6 + onward))
    return vertices, np.concatenate([np.stack(fan, axis=1) for fan in fans])
