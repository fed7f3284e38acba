"""A rigid body that travels straight, or stands still: punch, elbow and knee pressed into a flat specimen."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.contact.body import Body
from etextile.motion.protocol import BodyMotion, Touch
from etextile.types import Array


@dataclass(frozen=True)
class Straight(BodyMotion):
    """Translation by travel x direction (3,); the frame moves with the body, so anchors stay where they are in it."""

    direction: Array

    def place(self, x: Array, travel: float) -> Array:
        """Return positions relative to the body."""
        return np.asarray(x - travel * self.direction)

    def posed(self, body: Body, travel: float) -> Body:
        """Return the body as it is."""
        return body

    def carried(self, anchor: Array, before: float, travel: float) -> Array:
        """Return the anchors as they are."""
        return anchor

    def driving_force(self, body: Body, travel: float, touch: Touch, *, onward: bool = False) -> float:
        """Return the force (N) of the body on the fabric along the direction."""
        forces = touch.pressure[:, None] * touch.found.normal - touch.traction
        return float((forces @ self.direction).sum())

    def longest_step(self, body: Body) -> float:
        """Return half the radius of the body's leading point, at most a quarter of its smallest extent, mm.

        A node pushed in deeper than that could be nearer to the far side, and be put there.
        """
        if not np.any(self.direction):
            return np.inf
        vertices, _ = body.surface()
        leading = vertices[np.argmax(vertices @ self.direction)]
        curvature = float(np.linalg.eigvalsh(body.distance(leading[None, :]).hessian[0])[-1])
        extent = float(np.ptp(body.bounds(), axis=0).min())
        return min(0.5 / max(curvature, 1e-6), 0.25 * extent)

    def surroundings(self, body: Body) -> Array:
        """Return the body's own box."""
        return body.bounds()
