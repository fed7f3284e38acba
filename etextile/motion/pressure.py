r"""Gas under a piece that is clamped all round: a follower load on the deformed surface, from a potential.

With the rim held in its plane the volume under the surface is V = sum_t w_t Z D / 6 over its triangles, where

    Z = z1 + z2 + z3,      D = x1 (y2 - y3) + x2 (y3 - y1) + x3 (y1 - y2)

is twice the area of a triangle's projection. The energy of the gas, -p V, has the exact follower forces as its gradient
and a symmetric tangent (Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, section 6.5).
Planes of symmetry close the volume as the rim does. Cells are not plane: the mean of their two pairs of triangles is
taken. The path parameter is the pressure in bar; the piece is flat and slack at zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from etextile.lattice.piece import Lattice
from etextile.mechanics.kernels import add_dense_blocks
from etextile.mechanics.protocol import Contribution, Energy, Response
from etextile.types import Array, IntArray


BAR = 0.1
"""One bar in MPa."""


@dataclass(frozen=True)
class Pressure(Contribution):
    """Triangles (T, 3) with weights (T,): 1, or 1/2 where two pairs of triangles make a cell."""

    nodes: IntArray
    weights: Array
    name: str = "pressure"
    onset_power: float = 1.0 / 3.0

    @classmethod
    def on(cls, lattice: Lattice) -> Pressure:
        """Return the pressure on all cells of a piece, whole and cut ones, from below."""
        cells = np.concatenate([lattice.quads, lattice.edge_cells])
        pairs = np.concatenate([cells[:, corners] for corners in ([0, 1, 2], [0, 2, 3], [0, 1, 3], [1, 2, 3])])
        a, b, c = (lattice.points[pairs[:, k], :2] for k in range(3))
        area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
        turned = np.where((area < 0.0)[:, None], pairs[:, [0, 2, 1]], pairs)
        real = np.abs(area) > 1e-12 * float(np.abs(area).max())
        return cls(turned[real].astype(np.int64), np.full(int(real.sum()), 0.5))

    def initial_state(self) -> None:
        """Return nothing: gas has no memory."""

    def respond(self, x: Array, travel: float, state: None) -> PressureResponse:
        """Evaluate at positions x (P, 3) under `travel` bar."""
        return PressureResponse(self, x[self.nodes], BAR * travel)

    def among(self, elements: IntArray, number: IntArray) -> Pressure:
        """Return some of the triangles."""
        return Pressure(number[self.nodes[elements]], self.weights[elements])

    def volume(self, x: Array) -> float:
        """Return the volume (mm3) under the surface at positions x (P, 3), of the modelled part."""
        return self.respond(x, 0.0, None).volume


@dataclass(frozen=True)
class PressureResponse(Response):
    """Corners (T, 3, 3) mm of the triangles at a trial, pressure in MPa."""

    part: Pressure
    corners: Array
    pressure: float

    @property
    def state(self) -> None:
        """Nothing to carry over."""
        return

    @cached_property
    def height(self) -> Array:
        """Sum Z (T,) of the heights of the corners, mm."""
        return np.asarray(self.corners[:, :, 2].sum(axis=1))

    @cached_property
    def turn(self) -> Array:
        """dD/dx and dD/dy (T, 3, 2) of each corner, mm."""
        following, before = np.roll(self.corners, -1, axis=1), np.roll(self.corners, -2, axis=1)
        return np.stack([following[..., 1] - before[..., 1], before[..., 0] - following[..., 0]], axis=-1)

    @cached_property
    def projection(self) -> Array:
        """D (T,), twice the projected area, mm2."""
        return np.asarray(np.einsum("tk,tk->t", self.corners[:, :, 0], self.turn[:, :, 0]))

    @cached_property
    def volume(self) -> float:
        """Volume under the surface, mm3."""
        return float(self.part.weights @ (self.height * self.projection)) / 6.0

    def energy(self) -> Energy:
        """Return the potential of the gas, -p V, N mm."""
        return Energy(stored=-self.pressure * self.volume)

    def add_gradient(self, gradient: Array) -> None:
        """Add minus the forces of the gas to gradient (P, 3)."""
        scale = self.pressure * self.part.weights / 6.0
        sideways = (scale * self.height)[:, None, None] * self.turn
        up = np.broadcast_to((scale * self.projection)[:, None, None], (*sideways.shape[:2], 1))
        np.add.at(gradient, self.part.nodes, -np.concatenate([sideways, up], axis=2))

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add the symmetric load stiffness; it has no sign, so its semidefinite part is taken as nothing."""
        if not exact or self.pressure == 0.0:
            return
        scale = -self.pressure * self.part.weights / 6.0
        blocks = np.zeros((len(self.corners), 3, 3, 3, 3))
        tilt = scale[:, None, None] * self.turn
        for corner in range(3):
            blocks[:, corner, 2, :, :2] += tilt
            blocks[:, :, :2, corner, 2] += tilt
            for other, sign in (((corner + 1) % 3, 1.0), ((corner + 2) % 3, -1.0)):
                blocks[:, corner, 0, other, 1] += sign * scale * self.height
                blocks[:, other, 1, corner, 0] += sign * scale * self.height
        add_dense_blocks(self.part.nodes, blocks.reshape(-1, 9, 9), rows, pairs, values)

    @property
    def driving_force(self) -> float:
        """Derivative of the potential by the pressure in bar at unmoved nodes: -V, in N mm per bar."""
        return -BAR * self.volume

    @property
    def load(self) -> float:
        """Upward resultant of the gas on the modelled part, N."""
        return 0.5 * self.pressure * float(self.part.weights @ self.projection)
