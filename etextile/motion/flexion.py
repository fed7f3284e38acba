"""A joint that bends in a sleeve: the limb grows into it (donning), then turns; skin, cuffs and moment go with it.

The travel is the flexion in degrees; below zero it counts the mm by which the limb is still too thin while it grows.
A point of the skin turns about the hinge by a blend of the angles of the two segments: with psi its polar angle
on the straight limb and x = rho sin(psi) its place along it, w = x / (2 L) + 1/2, cut to [0, 1], the share of the lower
segment (the weights of linear blend skinning, turned about the hinge so that a point keeps its distance from it). The
skin of the outer side is stretched by r theta / (2 L), by 0.42 on a limb of 40 mm at 120 degrees with the default of
L = 100 mm, and that of the crook shortened as much: 0.3 to 0.5 are measured on elbow and knee. Stretch is what the
fabric feels through friction alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from etextile.contact.bending import Bending, about_y
from etextile.contact.body import Body
from etextile.motion.protocol import STILL, BodyMotion, Touch
from etextile.types import Array, IntArray


TURNS = 40
"""Most Newton steps for the place of a skin point on the straight limb."""


@dataclass(frozen=True)
class Flexion(BodyMotion):
    """Growth of a limb by `donning` mm up to travel 0, then flexion.

    step_deg: longest increment of the flexion; step_mm: of the growth.
    """

    limb: Bending
    donning: float = 0.0
    step_deg: float = 5.0
    step_mm: float = 2.0
    direction: Array = field(default_factory=STILL.copy)

    @property
    def skin(self) -> float:
        """Half the length L of blended skin, mm."""
        return 0.5 * self.limb.skin_length

    def pose(self, travel: float) -> tuple[float, float]:
        """Return by how much (mm) the limb is too thin, and its flexion (rad)."""
        return max(-travel, 0.0), float(np.radians(max(travel, 0.0)))

    def grows(self, travel: float, *, onward: bool = False) -> bool:
        """Tell whether the limb grows at `travel`; at the end of the growth it does, but not `onward`."""
        return travel < 0.0 or (travel == 0.0 < self.donning and not onward)

    def place(self, x: Array, travel: float) -> Array:
        """Return positions as they are: anchors are kept in space, at the travel they were set."""
        return x

    def posed(self, body: Body, travel: float) -> Body:
        """Return the limb in its pose; bodies of another kind stay as they are."""
        return self._bent(body, travel) if isinstance(body, Bending) else body

    def _bent(self, body: Bending, travel: float) -> Bending:
        deflated, flexion = self.pose(travel)
        return body.posed(flexion=flexion, deflated=deflated)

    def carried(self, anchor: Array, before: float, travel: float) -> Array:
        """Return skin points (n, 3) at travel `before` turned on to `travel`."""
        turn = self.share(anchor, before) * (self.pose(travel)[1] - self.pose(before)[1])
        cos, sin = np.cos(turn), np.sin(turn)
        x, z = anchor[:, 0], anchor[:, 2]
        return np.stack([cos * x + sin * z, anchor[:, 1], cos * z - sin * x], axis=1)

    def share(self, points: Array, travel: float) -> Array:
        """Return by how many rad skin points (n, 3) at `travel` turn about the hinge per rad of flexion."""
        return self._share_at(*self._straight(points, travel))

    def along(self, points: Array, travel: float) -> Array:
        """Return where along the straight limb the skin under points (n, 3) at `travel` lies, mm."""
        psi, reach = self._straight(points, travel)
        return np.asarray(reach * np.sin(psi))

    def _straight(self, points: Array, travel: float) -> tuple[Array, Array]:
        """Return polar angles (n,) on the straight limb, rad, and distances (n,) from the hinge of skin points."""
        flexion = self.pose(travel)[1]
        angle, reach = np.arctan2(points[:, 0], points[:, 2]), np.hypot(points[:, 0], points[:, 2])
        psi = angle - self._share_at(angle, reach, np.zeros_like(angle)) * flexion
        for _ in range(TURNS):
            share, slope = self._share_at(psi, reach), self._slope_at(psi, reach)
            off = np.mod(psi + share * flexion - angle + np.pi, 2.0 * np.pi) - np.pi
            if np.abs(off).max(initial=0.0) < 1e-12:
                break
            psi = psi - np.clip(off / np.maximum(1.0 + slope * flexion, 0.2), -0.5, 0.5)
        return psi, reach

    def _share_at(self, psi: Array, reach: Array, weight: Array | None = None) -> Array:
        """Return the turn per rad of flexion at polar angles on the straight limb."""
        if weight is None:
            weight = np.clip(0.5 + reach * np.sin(psi) / (2.0 * self.skin), 0.0, 1.0)
        return self.limb.lower_share - 1.0 + weight

    def _slope_at(self, psi: Array, reach: Array) -> Array:
        inside = np.abs(reach * np.sin(psi)) < self.skin
        return np.where(inside, reach * np.cos(psi) / (2.0 * self.skin), 0.0)

    def driving_force(self, body: Body, travel: float, touch: Touch, *, onward: bool = False) -> float:
        """Return the force (N) on the growth, or the moment (N mm per degree) on the flexion."""
        if not isinstance(body, Bending):
            return 0.0
        if self.grows(travel, onward=onward):
            return float(touch.pressure.sum())
        per_rad = -float(touch.pressure @ self._bent(body, travel).rate(touch.place))
        if np.any(touch.traction):
            share = self.share(touch.anchor, travel)
            speed = share[:, None] * np.stack([touch.anchor[:, 2], np.zeros(len(share)), -touch.anchor[:, 0]], axis=1)
            per_rad -= float(np.vdot(touch.traction, speed))
        return float(np.radians(per_rad))

    def longest_step(self, body: Body) -> float:
        """Return the longest increment; what is left of the growth is an output of its own."""
        return self.step_deg

    def surroundings(self, body: Body) -> Array:
        """Return the box around the limb from straight to bent by half a turn."""
        if not isinstance(body, Bending):
            return body.bounds()
        low, high = body.bounds()
        reach = float(np.abs([low, high]).max())
        return np.array([[-reach, low[1], -reach], [reach, high[1], reach]])


@dataclass(frozen=True)
class Cuffs:
    """Nodes (n,) that move with a segment, by share (n,) of the flexion, from start (n, 3) mm on the straight limb.

    grown (n, 3) mm: where they stand when the limb has grown to its own size.
    """

    motion: Flexion
    nodes: IntArray
    start: Array
    grown: Array
    share: Array

    def positions(self, travel: float) -> Array:
        """Return the positions (n, 3) mm."""
        deflated, flexion = self.motion.pose(travel)
        full = self.motion.donning
        done = 1.0 if full == 0.0 else 1.0 - deflated / full
        place = self.start + done * (self.grown - self.start)
        return np.asarray(np.einsum("nij,nj->ni", self._turns(flexion), place))

    def rate(self, travel: float, *, onward: bool = False) -> Array:
        """Return the derivative (n, 3) by the travel: per mm of growth, per degree of flexion."""
        if self.motion.grows(travel, onward=onward):
            return np.asarray((self.grown - self.start) / self.motion.donning)
        x = self.positions(travel)
        about = np.stack([x[:, 2], np.zeros(len(x)), -x[:, 0]], axis=1)
        return np.asarray(np.radians(self.share)[:, None] * about)

    def _turns(self, flexion: float) -> Array:
        return np.stack([about_y(share * flexion) for share in self.share]) if len(self.share) else np.zeros((0, 3, 3))
