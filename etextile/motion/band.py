"""An elastic band in the end of a sleeve: it is let go while the limb grows, and squeezes the fabric onto the skin.

The band is a chain of springs between neighbouring nodes: force K (l / r - 1) when longer than its free length r, none
when shorter. While a sleeve is put on (travel below 0) r goes evenly from the length it is put on with, at which it is
slack, to its own, so that everything starts from zero force; that work is done by the travel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.mechanics import kernels
from etextile.mechanics.protocol import Contribution, Energy, Response
from etextile.types import Array, IntArray


@dataclass(frozen=True)
class Band(Contribution):
    """Springs between nodes (n, 2): K (N per strain), free lengths (n,) mm at the start of `donning` mm and behind it.

    Half of a band, as other parts of a half model, is a chain of whole springs.
    """

    nodes: IntArray
    stiffness: float
    put_on: Array
    own: Array
    donning: float
    name: str = "band"

    def initial_state(self) -> None:
        """Return None: a band remembers nothing."""

    def free_length(self, travel: float) -> tuple[Array, Array]:
        """Return free lengths (n,) mm and their derivative by the travel; both of the growth where it ends."""
        if travel > 0.0 or self.donning == 0.0:
            return self.own, np.zeros_like(self.own)
        rate = (self.own - self.put_on) / self.donning
        return self.own + travel * rate, rate

    def respond(self, x: Array, travel: float, state: None) -> BandResponse:
        """Evaluate the springs at positions x (P, 3)."""
        apart = x[self.nodes[:, 1]] - x[self.nodes[:, 0]]
        length = np.maximum(np.linalg.norm(apart, axis=1), 1e-12)
        return BandResponse(self, travel, apart / length[:, None], length)


@dataclass(frozen=True)
class BandResponse(Response):
    """A band at a trial: unit vectors (n, 3) and lengths (n,) mm."""

    band: Band
    travel: float
    unit: Array
    length: Array

    @property
    def strain(self) -> Array:
        """Strain (n,), zero where slack."""
        return np.maximum(self.length / self.band.free_length(self.travel)[0] - 1.0, 0.0)

    @property
    def force(self) -> Array:
        """Tension (n,) N."""
        return self.band.stiffness * self.strain

    @property
    def state(self) -> None:
        """Nothing to carry over."""

    def energy(self) -> Energy:
        """Return the stored energy K r e^2 / 2."""
        free = self.band.free_length(self.travel)[0]
        return Energy(stored=0.5 * self.band.stiffness * float(free @ self.strain**2))

    def add_gradient(self, gradient: Array) -> None:
        """Add the nodal forces."""
        kernels.add_truss_gradient(self.band.nodes, self._weights, self.unit, self.force, gradient)

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add the tangent, which is never indefinite."""
        free = self.band.free_length(self.travel)[0]
        along = np.where(self.strain > 0.0, self.band.stiffness / free, 0.0)
        kernels.add_truss_tangent(
            self.band.nodes, self._weights, self.unit, along, self.force / self.length, damping, rows, pairs, values
        )

    @property
    def driving_force(self) -> float:
        """Derivative of the energy by the travel at unmoved nodes, N: of the growth, which shortens the band."""
        return self._drive(self.band.free_length(self.travel)[1])

    @property
    def force_onward(self) -> float:
        """The same behind the growth: the band stays as it is."""
        return self.driving_force if self.travel < 0.0 else 0.0

    def _drive(self, rate: Array) -> float:
        strain = self.strain
        return float((-self.band.stiffness * (strain + 0.5 * strain**2)) @ rate)

    @property
    def _weights(self) -> Array:
        return np.tile(np.array([-1.0, 1.0]), (len(self.length), 1))
