"""A weak hold of a garment on its limb, for what nothing else resolves: a loose sleeve could slide along and turn.

Each node is tied by a spring to the place where it began, which goes with the skin. At 10 mm it pulls about as much as
a light fabric weighs (`WEAK`), and what it stores is shown beside the work of the motion, so that nobody need believe
that it does not matter.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.mechanics import kernels
from etextile.mechanics.protocol import Contribution, Energy, Response
from etextile.motion.flexion import Cuffs
from etextile.types import Array, IntArray


WEAK = 1e-7
"""Stiffness of the hold per area of fabric, N/mm per mm2: 1 N/m2 at 10 mm, the weight of 100 g/m2."""


@dataclass(frozen=True)
class WeakHold(Contribution):
    """Springs of stiffness (n,) N/mm from nodes (n, 1) to the places that `led` leads."""

    nodes: IntArray
    led: Cuffs
    stiffness: Array
    name: str = "weak hold"

    def initial_state(self) -> None:
        """Return None: springs remember nothing."""

    def respond(self, x: Array, travel: float, state: None) -> HoldResponse:
        """Evaluate the springs at positions x (P, 3)."""
        return HoldResponse(self, travel, x[self.nodes[:, 0]] - self.led.positions(travel))


@dataclass(frozen=True)
class HoldResponse(Response):
    """The hold at a trial: how far (n, 3) mm the nodes are away from their places."""

    hold: WeakHold
    travel: float
    away: Array

    @property
    def state(self) -> None:
        """Nothing to carry over."""

    def energy(self) -> Energy:
        """Return the stored energy, N mm."""
        return Energy(stored=0.5 * float(self.hold.stiffness @ (self.away**2).sum(axis=1)))

    def add_gradient(self, gradient: Array) -> None:
        """Add the forces of the springs."""
        np.add.at(gradient, self.hold.nodes[:, 0], self.hold.stiffness[:, None] * self.away)

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add the stiffness of the springs."""
        blocks = self.hold.stiffness[:, None, None] * np.eye(3)
        kernels.add_node_blocks(self.hold.nodes[:, 0], blocks, rows, values)

    @property
    def driving_force(self) -> float:
        """Derivative of the energy by the travel at unmoved nodes."""
        return self._drive(onward=False)

    @property
    def force_onward(self) -> float:
        """The same for the motion that begins here."""
        return self._drive(onward=True)

    def _drive(self, *, onward: bool) -> float:
        rate = self.hold.led.rate(self.travel, onward=onward)
        return -float(np.vdot(self.hold.stiffness[:, None] * self.away, rate))
