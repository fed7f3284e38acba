"""Statistics of a wire as a bundle of filaments with scattered elongation at break: exact, no sampling.

A filament of excess length x over the tautest one sees the strain e - x of its loop; it breaks at an elongation that is
Weibull distributed with mean m and shape w, so with eta = m / Gamma(1 + 1/w) and the bending strain b at the exit

    P(broken | x) = 1 - exp(-((e - x + b) / eta)^w + (b / eta)^w)      for e > x, else 0.

The second term says that the wire was whole when it was mounted. Excess lengths are uniform between 0 and `spread`, and
filaments are independent given the loop's strain: the number broken is binomial. The loop's strain is imposed by the
fabric (it scatters between loops by `scatter`), so survivors carry their own share and no more: equal load sharing
under strain control. The bundle's force is the survivors' share of the unbroken one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import comb, gamma

from etextile.types import Array


_SPREAD_NODES, _SPREAD_WEIGHTS = np.polynomial.legendre.leggauss(40)
_SCATTER_NODES, _SCATTER_WEIGHTS = np.polynomial.hermite_e.hermegauss(33)


@dataclass(frozen=True)
class Bundle:
    """N filaments: mean elongation at break, Weibull shape, spread of excess lengths, scatter of loops' strain."""

    filaments: int
    elongation: float
    shape: float
    spread: float
    scatter: float

    @property
    def scale(self) -> float:
        """Weibull scale eta of the elongation at break."""
        return float(self.elongation / gamma(1.0 + 1.0 / self.shape))

    def broken_share(self, strain: Array, bending: Array | float = 0.0) -> Array:
        """Return the probability (...) that a filament is broken at loop strains (...) and bending strains (...)."""
        strain, bending = np.broadcast_arrays(np.asarray(strain, dtype=float), np.asarray(bending, dtype=float))
        if self.spread == 0.0:
            return self._taut(strain, bending)
        high = np.maximum(strain, 0.0)
        low = np.maximum(high - self.spread, 0.0)
        half = 0.5 * (high - low)[..., None]
        nodes = low[..., None] + half * (1.0 + _SPREAD_NODES)
        mean = (self._taut(nodes, bending[..., None]) * half) @ _SPREAD_WEIGHTS / self.spread
        return np.clip(mean, 0.0, 1.0)

    def counts(self, strain: Array, bending: Array | float = 0.0) -> Array:
        """Return the probability (..., N + 1) that k = 0 ... N filaments are broken, over the scatter of loops."""
        share = self._scattered(strain, bending)[..., None]
        k = np.arange(self.filaments + 1)
        each = comb(self.filaments, k) * share**k * (1.0 - share) ** (self.filaments - k)
        counts = np.einsum("...zk,z->...k", each, _SCATTER_WEIGHTS / _SCATTER_WEIGHTS.sum())
        whole = np.zeros(self.filaments + 1)
        whole[0] = 1.0
        return np.where((np.asarray(strain) > 0.0)[..., None], counts, whole)

    def failure_probability(self, strain: Array, bending: Array | float = 0.0) -> Array:
        """Return the probability (...) that at least one filament is broken."""
        none = (1.0 - self._scattered(strain, bending)) ** self.filaments
        return self._mean(1.0 - none, strain)

    def open_probability(self, strain: Array, bending: Array | float = 0.0) -> Array:
        """Return the probability (...) that all filaments are broken."""
        return self._mean(self._scattered(strain, bending) ** self.filaments, strain)

    def strain_at(self, share: float, bending: Array) -> Array:
        """Return the loop strain (n,) at which `share` of the filaments is broken, by bisection."""
        bending = np.asarray(bending, dtype=float)
        low, high = np.zeros(bending.shape), np.full(bending.shape, 10.0 * self.scale + self.spread)
        for _ in range(60):
            middle = 0.5 * (low + high)
            beyond = self.broken_share(middle, bending) >= share
            low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
        return high

    def _taut(self, strain: Array, bending: Array) -> Array:
        """Return the probability that a filament without excess length is broken."""
        stretched = np.maximum(strain, 0.0)
        hazard = ((stretched + bending) / self.scale) ** self.shape - (bending / self.scale) ** self.shape
        return np.asarray(-np.expm1(-hazard))

    def _scattered(self, strain: Array, bending: Array | float) -> Array:
        """Return the broken share (..., Z) at the nodes of the scatter between loops."""
        nodes = np.asarray(strain, dtype=float)[..., None] + self.scatter * _SCATTER_NODES
        return self.broken_share(nodes, np.asarray(bending, dtype=float)[..., None])

    def _mean(self, values: Array, strain: Array) -> Array:
        """Return the mean (...) of values (..., Z) over loops; nothing breaks in an unstrained one."""
        mean = values @ (_SCATTER_WEIGHTS / _SCATTER_WEIGHTS.sum())
        return np.where(np.asarray(strain) > 0.0, np.clip(mean, 0.0, 1.0), 0.0)
