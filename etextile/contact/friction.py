r"""Coulomb friction as a cone for the interior-point solver: no kink between stick and slip, none where slip turns.

A node pressed by P and moved by w along the body from its anchor bears L theta, L = mu P, in the direction of w, with

    w = (L / k) theta + g theta,     g (1 - |theta|^2) / 2 = delta,     g > 0,  |theta| < 1,

k the elastic stiffness of stick and g theta the slip; delta = 0 is Coulomb's law. Theta and g are unknowns beside the
positions and all steps are whole, as in `etextile.solve.barrier`. How L follows P within a step is left out of the
tangent, which stays symmetric.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.types import Array


KEEP = 0.02
"""Share of g and of 1 - |theta|^2 that a step leaves at least."""
LEAST_ROOM, LEAST_DELTA = 1e-10, 1e-11
"""Smallest (1 - |theta|^2) / 2, and delta (mm) below which nothing is left to gain."""
CENTRING = 0.1
"""Factor by which a step means to bring delta down."""


@dataclass(frozen=True)
class Cone:
    """Friction of m anchored nodes: direction and share theta (m, 3) of the limit, slip g (m,) mm per theta."""

    theta: Array
    slip: Array

    @classmethod
    def start(cls, offset: Array, reach: Array, delta: float) -> Cone:
        """Return the cone for offsets (m, 3) mm and elastic offsets `reach` = L / k (m,) mm at the limit."""
        size = np.linalg.norm(offset, axis=1)
        share = np.minimum(size / np.maximum(reach, 1e-30), 0.9)
        theta = (share / np.maximum(size, 1e-30))[:, None] * offset
        return cls(theta, 2.0 * delta / (1.0 - share**2))

    def turned(self, normal: Array) -> Cone:
        """Return the cone with directions turned into the tangent planes of new normals (m, 3)."""
        size = np.linalg.norm(self.theta, axis=1)
        theta = self.theta - np.einsum("ij,ij->i", self.theta, normal)[:, None] * normal
        theta *= (size / np.maximum(np.linalg.norm(theta, axis=1), 1e-30))[:, None]
        return Cone(theta, self.slip)

    @property
    def room(self) -> Array:
        """(1 - |theta|^2) / 2, shape (m,)."""
        return np.asarray(0.5 * (1.0 - np.einsum("ij,ij->i", self.theta, self.theta)))

    def linearised(self, offset: Array, reach: Array) -> LinearCone:
        """Return the cone at offsets (m, 3) mm, aiming at a tenth of its mean delta."""
        room = self.room
        delta = max(CENTRING * float(np.mean(self.slip * room)), LEAST_DELTA) if len(room) else 0.0
        give = reach + self.slip
        drift = self.slip / room
        off = offset - give[:, None] * self.theta - ((delta - self.slip * room) / room)[:, None] * self.theta
        return LinearCone(self, give, drift, off, delta)


@dataclass(frozen=True)
class LinearCone:
    """A cone linearised: d theta = A^-1 (dw + off) with A = give 1 + drift theta theta^T."""

    cone: Cone
    give: Array
    drift: Array
    off: Array
    delta: float

    def inverse(self, vectors: Array) -> Array:
        """Return A^-1 vectors (m, 3)."""
        theta = self.cone.theta
        square = np.einsum("ij,ij->i", theta, theta)
        part = self.drift * np.einsum("ij,ij->i", theta, vectors) / (self.give + self.drift * square)
        return np.asarray((vectors - part[:, None] * theta) / self.give[:, None])

    def blocks(self, plane: Array) -> Array:
        """Return A^-1 (m, 3, 3) in the tangent planes given by projectors (m, 3, 3)."""
        theta = self.cone.theta
        square = np.einsum("ij,ij->i", theta, theta)
        part = self.drift / (self.give + self.drift * square)
        return np.asarray(
            (plane - part[:, None, None] * theta[:, :, None] * theta[:, None, :]) / self.give[:, None, None]
        )

    def moved(self, shift: Array) -> Cone:
        """Return the cone after tangential shifts (m, 3) mm of the nodes; each node stays inside on its own."""
        cone = self.cone
        turn = self.inverse(shift + self.off)
        room = cone.room
        more = (self.delta - cone.slip * room + cone.slip * np.einsum("ij,ij->i", cone.theta, turn)) / room
        theta = cone.theta + turn
        least = np.maximum(KEEP * room, LEAST_ROOM)
        size = np.linalg.norm(theta, axis=1)
        most = np.sqrt(1.0 - 2.0 * least)
        theta *= np.minimum(1.0, most / np.maximum(size, 1e-30))[:, None]
        return Cone(theta, np.maximum(cone.slip + more, KEEP * cone.slip))
