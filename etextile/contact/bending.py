"""What a body that bends at a joint is to motion and case: a distance at any flexion, its rate, and a girth to wear.

The hinge lies in the origin along y; straight, the limb lies along x, the upper segment towards -x, and its outer side
looks to +z. Motion, fabric and drawing know limbs through this file only, so a new one is one class with these methods.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Self

import numpy as np

from etextile.contact.body import Distance
from etextile.contact.skinning import SkinnedMesh
from etextile.types import Array, IntArray


RAYS, HALVINGS = 180, 30
"""Rays from the hinge on which the skin is looked for, and how often their length is halved."""


class Bending(ABC):
    """A limb in a pose, mm; it is a `Body` in that pose."""

    @property
    @abstractmethod
    def lower_share(self) -> float:
        """Share of the flexion that the lower segment turns; the upper turns the rest, the other way."""

    @property
    @abstractmethod
    def skin_length(self) -> float:
        """Length of the skin that stretches over the joint, mm."""

    @property
    @abstractmethod
    def middle(self) -> Array:
        """Place (2,) in y and z of the axis about which a piece lies before it is put on, mm."""

    @abstractmethod
    def posed(self, *, flexion: float, deflated: float) -> Self:
        """Return the limb bent by `flexion` (rad), standing `deflated` mm inside of its own surface."""

    @abstractmethod
    def distance(self, points: Array) -> Distance:
        """Return the signed distance of `points` (n, 3)."""

    @abstractmethod
    def rate(self, points: Array) -> Array:
        """Return the derivative (n,) of the signed distance of fixed points by the flexion, mm per rad."""

    @abstractmethod
    def radius(self, along: Array) -> Array:
        """Return the girth (n,) over 2 pi of the straight limb at places `along` (n,) x, mm."""

    @abstractmethod
    def fitted(self, places: Array) -> Array:
        """Return where on the grown, straight limb nodes (n, 3) of a round piece about `middle` stand.

        A piece that is too tight there comes to lie on the skin, a loose one keeps its girth.
        """

    @abstractmethod
    def surface(self, *, edge: float = 4.0) -> tuple[Array, IntArray]:
        """Return vertices (v, 3) and triangles (f, 3), wound outward, for drawing.

        Their sides are about `edge` mm long where they are made for that; a mesh is returned as it is.
        """

    @abstractmethod
    def bounds(self) -> Array:
        """Return the lower and upper corner (2, 3) of the box around the straight and the bent limb."""

    @abstractmethod
    def support(self, direction: Array) -> float:
        """Return the maximum of x . direction over the limb (mm times the length of `direction`)."""

    @property
    def skin(self) -> SkinnedMesh | None:
        """How the surface bends, of a limb that is a skinned mesh."""
        return None

    def girth(self, along: Array) -> Array:
        """Return the girth (n,) mm of the straight limb at places `along` (n,) x, mm."""
        return 2.0 * np.pi * self.radius(along)

    def bend_girth(self, flexion: float) -> float:
        """Return the girth (mm) of the limb bent by `flexion` (rad) in the plane that halves its joint.

        A tube that is narrower is stretched round the crook, whatever becomes of its ends. The plane holds the hinge;
        the skin is found on rays from it by bisection.
        """
        around = np.linspace(0.0, 2.0 * np.pi, RAYS, endpoint=False)
        rays = np.stack([np.zeros(RAYS), np.sin(around), np.cos(around)], axis=1)
        rays = rays @ about_y((self.lower_share - 0.5) * flexion).T
        posed = self.posed(flexion=flexion, deflated=0.0)
        low, high = np.zeros(RAYS), np.full(RAYS, float(np.ptp(self.bounds(), axis=0).max()))
        for _ in range(HALVINGS):
            middle = 0.5 * (low + high)
            inside = posed.distance(middle[:, None] * rays).gap < 0.0
            low, high = np.where(inside, middle, low), np.where(inside, high, middle)
        skin = (0.5 * (low + high))[:, None] * rays
        return float(np.linalg.norm(skin - np.roll(skin, 1, axis=0), axis=1).sum())


def about_y(angle: float) -> Array:
    """Return the rotation (3, 3) about y that turns +x towards -z."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]])
