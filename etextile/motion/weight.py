"""The fabric's own weight as a dead load: what bends a strip over an edge (cantilever test).

The energy is sum_n w_n z_n with w_n = g (mass per area) (area of node n). The path parameter is the mass per area in
g/m2, so that one run serves every fabric: where the tip of a strip of length L reaches an angle at the mass w, the
overhang at the mass W is L (w / W)^(1/3), for bending scales with w L^3 / G (Peirce 1930).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.mechanics.protocol import Contribution, Energy, Response
from etextile.types import Array, IntArray


GRAVITY = 9.80665e-9
"""Weight of 1 g/m2 of fabric, N/mm2."""


@dataclass(frozen=True)
class Weight(Contribution):
    """Nodes (n, 1) with the area (n,) of fabric each stands for, mm2."""

    nodes: IntArray
    area: Array
    name: str = "weight"
    onset_power: float = 1.0

    def initial_state(self) -> None:
        """Return nothing."""

    def respond(self, x: Array, travel: float, state: None) -> WeightResponse:
        """Evaluate at positions x (P, 3) with `travel` g/m2."""
        return WeightResponse(self, x[self.nodes[:, 0], 2], GRAVITY * travel * self.area)

    def among(self, elements: IntArray, number: IntArray) -> Weight:
        """Return some of the nodes."""
        return Weight(number[self.nodes[elements]], self.area[elements])


@dataclass(frozen=True)
class WeightResponse(Response):
    """Heights (n,) mm at a trial and the weights (n,) N."""

    part: Weight
    height: Array
    weight: Array

    @property
    def state(self) -> None:
        """Nothing to carry over."""
        return

    def energy(self) -> Energy:
        """Return the potential of the weights, N mm."""
        return Energy(stored=float(self.weight @ self.height))

    def add_gradient(self, gradient: Array) -> None:
        """Add the weights, which pull down."""
        np.add.at(gradient[:, 2], self.part.nodes[:, 0], self.weight)

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add nothing: the load does not follow."""

    @property
    def driving_force(self) -> float:
        """Derivative of the potential by the mass per area, N mm per g/m2."""
        return GRAVITY * float(self.part.area @ self.height)

    @property
    def load(self) -> float:
        """Weight of the modelled part, N."""
        return float(self.weight.sum())
