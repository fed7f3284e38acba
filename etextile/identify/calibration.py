r"""Nonlinear least squares over simulator runs: parameters, covariance, what the data leave open.

Minimises |r(y) / s|^2 + |(y - y0) / t|^2 over unknowns y of order one (logarithms of moduli), s the noise, t the spread
of what is known before, by Levenberg-Marquardt on finite differences. Misfits of a model are not independent from one
point to the next, so the covariance of the estimate is never below the robust one: scores are summed over all points of
a load, and correlated from load to load by a Newey-West window (Newey and West, Econometrica 55, 1987), per specimen.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.types import Array, BoolArray, IntArray


DAMPING, LEAST_GAIN, MOST_STEP = 1e-2, 1e-4, 0.7
"""First damping, share by which the sum of squares has to fall for another step, longest step of an unknown."""
LOUDER = 1.05
"""Root mean square of the residuals over the noise from which on the noise is raised to them."""
OPEN = 0.5
"""An unknown whose spread stays above this share of what was allowed before the data is not identified."""
COLLINEAR = 0.98
"""Correlation of two estimates from which on only a combination of them is known."""


@dataclass(frozen=True)
class Unknowns:
    """Start y (p,), steps of the differences (p,), what is known before: mean and spread (p,), bounds (p,)."""

    names: tuple[str, ...]
    start: Array
    step: Array
    known: Array
    spread: Array
    low: Array
    high: Array


@dataclass(frozen=True)
class Data:
    """Noise (n,) of the residuals; cluster (n,): numbers of the loads in order; series (n,): specimen and channel."""

    noise: Array
    cluster: IntArray
    series: IntArray

    def where(self, mask: BoolArray) -> Data:
        """Return a part of the points."""
        return Data(self.noise[mask], self.cluster[mask], self.series[mask])


@dataclass(frozen=True)
class PosteriorEstimate:
    """Solution y (p,), covariance (p, p), residuals (n,), Jacobian (n, p) in units of the noise, evaluations.

    scale: root mean square of the residuals over the noise; freedom: of Student's t for intervals; open: unknowns that
    the data do not identify; pairs: numbers of unknowns of which only a combination is known, with the correlation.
    """

    y: Array
    covariance: Array
    residual: Array
    jacobian: Array
    evaluations: int
    converged: bool
    scale: float
    freedom: float
    open: BoolArray
    pairs: tuple[tuple[int, int, float], ...]

    @property
    def std(self) -> Array:
        """Standard deviations (p,)."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))


Predict = Callable[[Sequence[Array]], list[Array]]
"""Returns predicted minus measured (n,) at each of several y; NaN where no equilibrium was found."""


def calibrate(
    predict: Predict, unknowns: Unknowns, data: Data, *, most: int = 12, tell: Callable[[str], None] | None = None
) -> PosteriorEstimate:
    """Return the estimate; raises ValueError when the start itself cannot be simulated.

    Where the residuals are larger than the noise (which a model that misfits brings about) the noise is raised to them
    and the search goes on, so that what is known before keeps its weight; `scale` is what it was raised by.
    """
    first = _search(predict, unknowns, data, most=most, tell=tell)
    if first.scale <= LOUDER:
        return first
    louder = Data(first.scale * data.noise, data.cluster, data.series)
    second = _search(predict, replace(unknowns, start=first.y), louder, most=most, tell=tell)
    # misfits that hang together are fewer than their number
    freedom = max(1.5 * (second.freedom + len(first.y)) / max(_window(int(second.freedom) + len(first.y)), 1), 2.0)
    return replace(
        second, scale=second.scale * first.scale, evaluations=first.evaluations + second.evaluations, freedom=freedom
    )


def _search(
    predict: Predict, unknowns: Unknowns, data: Data, *, most: int, tell: Callable[[str], None] | None
) -> PosteriorEstimate:
    """Return the estimate for this noise."""
    y = unknowns.start.copy()
    residual = predict([y])[0]
    if not np.all(np.isfinite(residual)):
        raise ValueError("the start finds no equilibrium")
    damping, count, converged = DAMPING, 1, False
    cost = _cost(residual, y, unknowns, data)
    jacobian = _jacobian(predict, y, residual, unknowns)
    count += len(y)
    for turn in range(most):
        step = _step(jacobian, residual, y, unknowns=unknowns, data=data, damping=damping)
        trial = np.clip(y + step, unknowns.low, unknowns.high)
        found = predict([trial])[0]
        count += 1
        new = _cost(found, trial, unknowns, data)
        if not np.isfinite(new) or new > cost:
            damping *= 8.0
            converged = bool(np.abs(step).max() < 1e-4) or damping > 1e8
            if converged:
                break
            continue
        gain = (cost - new) / max(cost, 1e-300)
        y, residual, cost, damping = trial, found, new, damping / 4.0
        jacobian = _jacobian(predict, y, residual, unknowns)
        count += len(y)
        if tell is not None:
            tell(f"step {turn + 1}: misfit {np.sqrt(np.mean((residual / data.noise) ** 2)):.4g} of the noise")
        if gain < LEAST_GAIN or np.abs(step).max() < 1e-5:
            converged = True
            break
    return _estimate(y, residual, jacobian, unknowns=unknowns, data=data, evaluations=count, converged=converged)


def _cost(residual: Array, y: Array, unknowns: Unknowns, data: Data) -> float:
    before = (y - unknowns.known) / unknowns.spread
    return float(np.sum((residual / data.noise) ** 2) + before @ before)


def _jacobian(predict: Predict, y: Array, residual: Array, unknowns: Unknowns) -> Array:
    """Return differences (n, p), away from the nearer bound; an unknown whose neighbour cannot be run counts zero."""
    sign = np.where(y + unknowns.step > unknowns.high, -1.0, 1.0)
    places = [y + sign[i] * unknowns.step[i] * np.eye(len(y))[i] for i in range(len(y))]
    columns = [
        (found - residual) / (place - y)[i]
        for i, (found, place) in enumerate(zip(predict(places), places, strict=True))
    ]
    return np.asarray(np.nan_to_num(np.stack(columns, axis=1)))


def _step(jacobian: Array, residual: Array, y: Array, *, unknowns: Unknowns, data: Data, damping: float) -> Array:
    """Return the damped step; unknowns on a bound that it would leave stay there."""
    free = np.ones(len(y), dtype=bool)
    step = np.zeros(len(y))
    for _ in range(len(y)):
        scaled = jacobian[:, free] / data.noise[:, None]
        normal = scaled.T @ scaled + np.diag(1.0 / unknowns.spread[free] ** 2)
        right = -(scaled.T @ (residual / data.noise) + (y - unknowns.known)[free] / unknowns.spread[free] ** 2)
        step = np.zeros(len(y))
        step[free] = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), right)
        leaves = free & (((y <= unknowns.low) & (step < 0.0)) | ((y >= unknowns.high) & (step > 0.0)))
        if not leaves.any():
            break
        free &= ~leaves
    return step * min(1.0, MOST_STEP / max(float(np.abs(step).max()), 1e-300))


def _estimate(
    y: Array, residual: Array, jacobian: Array, *, unknowns: Unknowns, data: Data, evaluations: int, converged: bool
) -> PosteriorEstimate:
    scaled = jacobian / data.noise[:, None]
    misfit = residual / data.noise
    scale = float(np.sqrt(np.sum(misfit**2) / max(len(misfit) - len(y), 1)))
    before = np.diag(1.0 / unknowns.spread**2)
    plain = np.asarray(np.linalg.inv(scaled.T @ scaled + before), dtype=float)
    meat, clusters = scores_covariance(scaled, misfit, data)
    covariance = _larger(plain, np.asarray(plain @ (meat + before) @ plain, dtype=float))
    std = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(std, std)
    pairs = tuple(
        (i, j, float(correlation[i, j])) for i in range(len(y)) for j in range(i) if abs(correlation[i, j]) > COLLINEAR
    )
    return PosteriorEstimate(
        y, covariance, residual, scaled, evaluations, converged, scale, float(max(clusters - len(y), 2)),
        std > OPEN * unknowns.spread, pairs,
    )  # fmt: skip


def scores_covariance(scaled: Array, misfit: Array, data: Data) -> tuple[Array, int]:
    """Return the covariance (p, p) of the summed scores, and the number of clusters of points."""
    size = scaled.shape[1]
    total, clusters = np.zeros((size, size)), 0
    for series in np.unique(data.series):
        own = data.series == series
        _, number = np.unique(data.cluster[own], return_inverse=True)
        scores = np.zeros((int(number.max()) + 1, size))
        np.add.at(scores, number, scaled[own] * misfit[own, None])
        count = len(scores)
        clusters += count
        window = _window(count)
        part = scores.T @ scores
        for lag in range(1, min(window, count - 1) + 1):
            shifted = scores[lag:].T @ scores[:-lag]
            part += (1.0 - lag / (window + 1.0)) * (shifted + shifted.T)
        total += part
    return total * clusters / max(clusters - size, 1), clusters


def _window(count: int) -> int:
    """Return over how many loads misfits may be correlated (Lazarus et al., J. Bus. Econ. Stat. 36, 2018)."""
    return int(np.ceil(1.3 * np.sqrt(count))) if count > 3 else 0


def _larger(first: Array, second: Array) -> Array:
    """Return the first covariance plus what the second is larger in any direction."""
    root = np.linalg.cholesky(first)
    inverse = np.linalg.inv(root)
    values, vectors = np.linalg.eigh(inverse @ second @ inverse.T)
    grown = (vectors * np.maximum(values, 1.0)) @ vectors.T
    return np.asarray(root @ grown @ root.T)
