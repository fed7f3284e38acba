r"""Scatter between specimens: each has a factor of its own, drawn from a population that only a few of them show.

With b_s +- sqrt(v_s) the logarithm of the factor of specimen s, b_s ~ N(mu, tau^2 + v_s): mu has no prior, tau a
half-Cauchy one (Gelman, Bayesian Analysis 1 (2006) 515), which lets few specimens say little and many all. What a
further specimen will have is the mixture over tau of N(mean(tau), tau^2 + variance of mu).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.types import Array


SCALE = 0.15
"""Half of all fabrics are taken to scatter by less than this (log stiffness), before any is seen."""
GRID = 400


@dataclass(frozen=True)
class Population:
    """Posterior of the scatter: tau (k,), its weights (k,), and mean and standard deviation (k,) of a further specimen.

    `centre` (k,), `spread` (k,): mean of the population and its deviation, by tau.
    """

    tau: Array
    weight: Array
    centre: Array
    spread: Array

    def scatter(self, shares: Sequence[float] | Array) -> Array:
        """Return quantiles (q,) of tau."""
        return np.interp(shares, np.cumsum(self.weight) - 0.5 * self.weight, self.tau)

    def mean(self, shares: Sequence[float] | Array) -> Array:
        """Return quantiles (q,) of the population's mean."""
        return self._quantiles(shares, self.spread)

    def further(self, shares: Sequence[float] | Array) -> Array:
        """Return quantiles (q,) of a further specimen."""
        return self._quantiles(shares, np.hypot(self.spread, self.tau))

    def _quantiles(self, shares: Sequence[float] | Array, deviation: Array) -> Array:
        """Return quantiles of the mixture of normals by bisection."""
        from scipy.special import ndtr

        low = np.full(len(shares), float((self.centre - 40.0 * deviation).min()))
        high = np.full(len(shares), float((self.centre + 40.0 * deviation).max()))
        for _ in range(80):
            middle = 0.5 * (low + high)
            reached = ndtr((middle[:, None] - self.centre) / deviation) @ self.weight
            low, high = np.where(reached < shares, middle, low), np.where(reached < shares, high, middle)
        return np.asarray(0.5 * (low + high))


def population(own: Array, variance: Array, *, scale: float = SCALE) -> Population:
    """Return what specimens with the values own (s,) and their variances (s,) > 0 say of all that there are.

    Raises ValueError for less than two: one says nothing of the others.
    """
    if len(own) < 2:
        raise ValueError("a scatter needs two specimens")
    top = max(20.0 * scale, 20.0 * float(np.ptp(own)))
    tau = np.geomspace(1e-3 * scale, top, GRID)
    total = tau[:, None] ** 2 + variance
    precision = (1.0 / total).sum(axis=1)
    centre = (own / total).sum(axis=1) / precision
    misfit = ((own - centre[:, None]) ** 2 / total).sum(axis=1)
    log_p = -0.5 * (np.log(total).sum(axis=1) + np.log(precision) + misfit)
    log_p += np.log(tau) - np.log1p((tau / scale) ** 2)  # the grid is even in ln tau
    weight = np.exp(log_p - log_p.max())
    return Population(tau, weight / weight.sum(), centre, 1.0 / np.sqrt(precision))
