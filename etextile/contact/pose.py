"""Where a body stands: the same signed distance in the coordinates of the specimen."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from etextile.contact.body import Body, Distance, evaluation_points
from etextile.types import Array, IntArray


LEVEL = 1e-4
"""Vertices lie on the top when they are less than this share of the body's size below the highest one."""


@dataclass(frozen=True)
class PlacedBody:
    """A body turned by `rotation` (3, 3) and then shifted by `translation` (3,) mm: x = R X + t."""

    body: Body
    rotation: Array
    translation: Array

    def distance(self, points: Array) -> Distance:
        """Return the signed distance of `points` (n, 3) given in world coordinates."""
        from etextile.contact import kernels

        local = kernels.to_body(evaluation_points(points), self.rotation, self.translation)
        found = self.body.distance(local)
        if np.array_equal(self.rotation, np.eye(3)):
            return found
        return Distance(found.gap, *kernels.turn(found.normal, found.hessian, self.rotation))

    def surface(self) -> tuple[Array, IntArray]:
        """Return vertices in world coordinates and triangles."""
        vertices, faces = self.body.surface()
        return vertices @ self.rotation.T + self.translation, faces

    def bounds(self) -> Array:
        """Return the box (2, 3) around the turned body."""
        upper = np.array([self.support(axis) for axis in np.eye(3)])
        lower = np.array([-self.support(-axis) for axis in np.eye(3)])
        return np.stack([lower, upper])

    def support(self, direction: Array) -> float:
        """Return the maximum of x . direction over the placed body."""
        return self.body.support(self.rotation.T @ direction) + float(self.translation @ direction)

    def moved(self, shift: Array) -> PlacedBody:
        """Return the body shifted by `shift` (3,) mm from where it is."""
        return replace(self, translation=self.translation + shift)


def place(
    body: Body,
    position_xy: tuple[float, float] = (0.0, 0.0),
    *,
    rotation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0),
    centred: bool = False,
) -> PlacedBody:
    """Return `body` turned and put so that its highest point lies exactly at z = 0.

    The body's own origin comes to stand below or above `position_xy` (mm): elbow and knee have their tip there.
    `rotation_deg` turns about the fixed axes x, then y, then z. `centred`: the highest point, not the body's own
    origin, comes to stand there.
    """
    rotation = rotation_matrix(rotation_deg)
    top = body.support(rotation.T @ np.array([0.0, 0.0, 1.0]))
    place_xy = np.array(position_xy)
    if centred:
        place_xy = place_xy - highest(body.surface()[0] @ rotation.T).mean(axis=0)
    return PlacedBody(body, rotation, np.array([place_xy[0], place_xy[1], -top]))


def highest(vertices: Array) -> Array:
    """Return the box (2, 2) in x and y around the highest of vertices (n, 3); a flat top has an extent."""
    size = float(np.ptp(vertices, axis=0).max())
    top = vertices[vertices[:, 2] > vertices[:, 2].max() - LEVEL * size, :2]
    return np.stack([top.min(axis=0), top.max(axis=0)])


def rotation_matrix(rotation_deg: tuple[float, float, float]) -> Array:
    """Return Rz Ry Rx (3, 3) for the angles about the fixed axes x, y, z in degrees; exact for multiples of 90."""
    matrix = np.eye(3)
    for axis, angle in enumerate(rotation_deg):
        quarter = angle % 360.0 / 90.0
        cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        if quarter == int(quarter):
            cos, sin = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[int(quarter) % 4]
        turn = np.eye(3)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn[i, i], turn[i, j], turn[j, i], turn[j, j] = cos, -sin, sin, cos
        matrix = turn @ matrix
    return matrix
