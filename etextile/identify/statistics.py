r"""Honest uncertainty from few specimens: correlated points within a curve, scatter between curves.

Within a curve: neighbouring residuals share the misfit of the law and slow drifts, so N points count as N / tau with
tau = 1 + 2 sum rho_k (Geyer's initial positive sequence). Between curves: two or three specimens say little about their
own scatter; a plain standard deviation of two values is too small half of the time and Student's t for one degree of
freedom gives intervals 13 standard deviations wide. So the scatter t is integrated out,

    p(t | x) ~ p(t) prod N(x_i | mean, w_i + t^2),   p(t) half-normal,

where w_i is the variance within a curve and the half-normal scale says what repeats of strip tests scatter by.
(Geyer, Statistical Science 7, 1992; Gelman, Bayesian Analysis 1, 2006, section 5.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.types import Array


# Half-normal scales of the scatter between specimens: relative for E and for stress, relative for n.
SCATTER_E, SCATTER_STRESS, SCATTER_N = 0.03, 0.03, 0.015
# Limits on residuals that are noise: autocorrelation factor, and variance over that of the noise.
MAX_CORRELATION, MAX_MISFIT = 2.0, 2.0
_GRID = np.linspace(0.0, 6.0, 241)


@dataclass(frozen=True)
class Pooled:
    """Mean over specimens, its standard deviation, and the standard deviation between specimens (posterior mean)."""

    mean: float
    std: float
    between: float


def autocorrelation_factor(residuals: Array) -> float:
    """Return tau >= 1, by which the variance of a smooth fit grows because residuals (n,) in order are correlated."""
    n = len(residuals)
    centred = residuals - residuals.mean() if n else residuals
    power = float(centred @ centred)
    if n < 8 or power <= 0.0:
        return 1.0
    lags = np.array([float(centred[: n - k] @ centred[k:]) for k in range(1, n // 3 + 1)]) / power
    pairs = lags[: len(lags) // 2 * 2].reshape(-1, 2).sum(axis=1)
    ends = np.flatnonzero(pairs <= 0.0)
    return float(max(1.0, 1.0 + 2.0 * pairs[: ends[0] if len(ends) else len(pairs)].sum()))


def residual_variance(residuals: Array, *, parameters: int, floor: float = 0.0) -> float:
    """Return the variance that makes variance * inv(J^T J) an honest covariance of a smooth fit's parameters.

    Mean square of the residuals (n,) per degree of freedom, at least `floor`, times the autocorrelation factor.
    """
    freedom = max(len(residuals) - parameters, 1)
    return max(float(residuals @ residuals) / freedom, floor) * autocorrelation_factor(residuals)


def pool(values: Sequence[float], variances: Sequence[float], *, scatter: float) -> Pooled:
    """Return the mean over specimens with the scatter between them integrated out.

    `variances`: within each specimen's curve; `scatter`: half-normal scale of the standard deviation between specimens.
    One specimen: the scatter is what the scale says.
    """
    x, w = np.asarray(values, float), np.maximum(np.asarray(variances, float), 1e-18)
    t = scatter * _GRID
    total = w[None, :] + t[:, None] ** 2
    weights = 1.0 / total
    precision = weights.sum(axis=1)
    means = (weights * x).sum(axis=1) / precision
    log_p = -0.5 * _GRID**2 - 0.5 * np.log(total).sum(axis=1) - 0.5 * np.log(precision)
    log_p -= 0.5 * (weights * (x - means[:, None]) ** 2).sum(axis=1)
    p = np.exp(log_p - log_p.max())
    p /= p.sum()
    mean = float(p @ means)
    return Pooled(mean, float(np.sqrt(p @ (1.0 / precision + (means - mean) ** 2))), float(p @ t))


def sample_covariance(values: Array) -> Array:
    """Return the covariance between specimens of values (specimens, parameters); zeros for fewer than two."""
    count, parameters = values.shape
    if count < 2:
        return np.zeros((parameters, parameters))
    return np.atleast_2d(np.cov(values, rowvar=False))


def with_deviations(covariance: Array, deviations: Array) -> Array:
    """Return the covariance with the correlations of `covariance` and the given standard deviations (n,)."""
    own = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    scale = np.divide(deviations, own, out=np.zeros_like(deviations), where=own > 0.0)
    scaled = scale[:, None] * covariance * scale[None, :]
    np.fill_diagonal(scaled, deviations**2)
    return np.asarray(scaled)


def is_noise(residuals: Array, noise: float) -> bool:
    """Tell whether residuals (n,) look like noise of a standard deviation, by their size and their order."""
    misfit = float(np.mean(residuals**2))
    return misfit <= MAX_MISFIT * noise**2 and autocorrelation_factor(residuals) <= MAX_CORRELATION
