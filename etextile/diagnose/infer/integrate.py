"""Integrals over the parameters of a hypothesis: a mesh along one, adaptive importance sampling over several.

Likelihoods of several parameters are narrow, correlated and bent (an onset against a slope), so a mesh along the axes
misses them. Points are drawn from Student-t distributions that close in on the likely region: first on one sample of
the noise (`guide`), at a temperature that keeps enough points effective, then on the whole likelihood. All points of
the last rounds count, weighted by the mixture they came from (Cornuet, Marin, Mira and Robert, Scand. J. Stat. 39
(2012) 798).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import lgamma

import numpy as np

from etextile.diagnose.infer.gauss import log_sum
from etextile.types import Array


LogLikelihood = Callable[[Array], Array]
# Points along one parameter, rounds of closing in, and the depth below the best from which points do not count.
MESH, ROUNDS, DEPTH = 41, 9, 14.0
# Points per round over so many parameters, rounds of closing in and of counting, and effective points to arrive at.
DRAWN = {2: 128, 3: 256, 4: 512}
MOST_DRAWN = 1024
CLOSING, COUNTING, EFFECTIVE = 12, 3, 120.0
# Rounds are repeated with so many times as many points, from where they ended, until enough are effective.
MORE = (1, 1, 3, 9)
# Degrees of freedom of the distributions that are drawn from, and how much wider they are than what was found.
FREEDOM, WIDER = 5.0, 1.3
# Weight relative to the largest below which a point is forgotten.
NEGLIGIBLE = 1e-6


@dataclass(frozen=True)
class Integral:
    """Log of the mean likelihood over a box; posterior points (b, d), weights (b,), log likelihoods (b,).

    `best` (d,), `log_best`: the likeliest point and its log likelihood.
    """

    log_mean: float
    points: Array
    weights: Array
    log_likelihood: Array
    best: Array
    log_best: float


@dataclass(frozen=True)
class _Cloud:
    """A multivariate Student-t: centre (d,), factor (d, d) of its scale matrix."""

    centre: Array
    factor: Array

    def draw(self, count: int, rng: np.random.Generator) -> Array:
        normal = rng.standard_normal((count, len(self.centre)))
        stretch = np.sqrt(FREEDOM / rng.chisquare(FREEDOM, count))
        return np.asarray(self.centre + (stretch[:, None] * normal) @ self.factor.T)

    def log_density(self, points: Array) -> Array:
        d = len(self.centre)
        z = (points - self.centre) @ np.linalg.inv(self.factor).T
        constant = lgamma(0.5 * (FREEDOM + d)) - lgamma(0.5 * FREEDOM) - 0.5 * d * np.log(FREEDOM * np.pi)
        constant -= float(np.log(np.diag(self.factor)).sum())
        return np.asarray(constant - 0.5 * (FREEDOM + d) * np.log1p((z**2).sum(axis=1) / FREEDOM))


def integrate(
    log_likelihood: LogLikelihood, whole: Array, *, guide: LogLikelihood | None = None, seed: int = 0
) -> Integral | None:
    """Return the integral over a box `whole` (d, 2) with a uniform prior; None when nothing in it is possible.

    Both functions map points (b, d) to (b,); `guide` is a cheaper one that is likely in the same region.
    """
    if len(whole) == 1:
        return _mesh(log_likelihood, whole)
    rng = np.random.default_rng(seed)
    count = DRAWN.get(len(whole), MOST_DRAWN)
    cloud = _closed_in(guide or log_likelihood, whole, count, rng)
    if cloud is None:
        return None
    for factor in MORE:
        found = _counted(log_likelihood, whole, cloud, factor * count, rng)
        if found is None:
            return None
        integral, cloud, effective = found
        if effective >= EFFECTIVE:
            break
    return integral


def _mesh(log_likelihood: LogLikelihood, whole: Array) -> Integral | None:
    """Return the integral over one parameter on a mesh that closes in on the likely region."""
    box = whole
    shares = (np.arange(MESH) + 0.5) / MESH
    for _ in range(ROUNDS):
        points = box[:, 0] + shares[:, None] * (box[:, 1] - box[:, 0])
        values = log_likelihood(points)
        top = float(values.max())
        if not np.isfinite(top):
            return None
        likely = points[values > top - DEPTH]
        cell = (box[:, 1] - box[:, 0]) / MESH
        closer = np.stack([
            np.maximum(likely.min(axis=0) - cell, whole[:, 0]), np.minimum(likely.max(axis=0) + cell, whole[:, 1])
        ], axis=1)  # fmt: skip
        if np.ptp(closer) > 0.6 * np.ptp(box):
            break
        box = closer
    total = float(log_sum(values)) - np.log(len(values)) + np.log(np.ptp(box)) - np.log(np.ptp(whole))
    weights = np.exp(values - top)
    return Integral(
        float(total), points, weights / weights.sum(), values, points[int(np.argmax(values))], top
    )  # fmt: skip


def _closed_in(guide: LogLikelihood, whole: Array, count: int, rng: np.random.Generator) -> _Cloud | None:
    """Return a cloud around the likely region, from points spread over the whole range."""
    from scipy.stats import qmc

    low, high = whole.T
    points = low + qmc.Sobol(len(whole), rng=rng).random(4 * count) * (high - low)
    values = guide(points)
    if not np.isfinite(values.max()):
        return None
    log_density = np.full(len(points), -np.log(high - low).sum())
    arrived = 0
    for _ in range(CLOSING):
        cloud, temperature = _cloud(points, values, log_density, whole)
        arrived += temperature == 1.0
        if arrived == 2:
            break
        drawn = _inside(cloud.draw(count, rng), whole)
        if not len(drawn):
            break
        points, values = np.concatenate([points, drawn]), np.concatenate([values, guide(drawn)])
        log_density = np.concatenate([log_density, cloud.log_density(drawn)])
    return cloud


def _cloud(points: Array, values: Array, log_density: Array, whole: Array) -> tuple[_Cloud, float]:
    """Return the cloud of weighted points, at the lowest temperature at which enough of them count."""
    d = points.shape[1]
    for temperature in np.geomspace(1.0, 1e6, 60):
        log_weight = values / temperature - log_density
        weights = np.exp(log_weight - log_weight.max())
        if weights.sum() ** 2 / (weights**2).sum() >= 12.0 * d:
            break
    weights /= weights.sum()
    centre = weights @ points
    apart = points - centre
    spread = (apart * weights[:, None]).T @ apart + np.diag((1e-7 * np.ptp(whole, axis=1)) ** 2)
    return _Cloud(centre, np.linalg.cholesky(WIDER * spread)), float(temperature)


def _counted(
    log_likelihood: LogLikelihood, whole: Array, cloud: _Cloud, count: int, rng: np.random.Generator
) -> tuple[Integral, _Cloud, float] | None:
    """Return the integral from a few rounds of points, each drawn around what was found before.

    With the cloud that the rounds ended with, and the number of effective points.
    """
    clouds = [cloud]
    points, values = np.zeros((0, len(whole))), np.zeros(0)
    drawn_in_all = 0
    for _ in range(COUNTING):
        drawn = _inside(clouds[-1].draw(count, rng), whole)
        drawn_in_all += count
        points, values = np.concatenate([points, drawn]), np.concatenate([values, log_likelihood(drawn)])
        if not len(values) or not np.isfinite(values.max()):
            return None
        clouds.append(_cloud(points, values, _mixture(clouds, points), whole)[0])
    log_weight = values - _mixture(clouds[:-1], points)
    top = float(log_weight.max())
    weights = np.exp(log_weight - top)
    log_mean = top + np.log(weights.sum() / drawn_in_all) - np.log(np.ptp(whole, axis=1)).sum()
    effective = float(weights.sum() ** 2 / (weights**2).sum())
    kept = weights > NEGLIGIBLE
    points, values, weights = points[kept], values[kept], weights[kept]
    best, log_best = _polished(log_likelihood, points, values, whole)
    return Integral(float(log_mean), points, weights / weights.sum(), values, best, log_best), clouds[-1], effective


def _mixture(clouds: Sequence[_Cloud], points: Array) -> Array:
    """Return the log density (b,) of the equal mixture of clouds."""
    return np.asarray(log_sum(np.stack([cloud.log_density(points) for cloud in clouds]), axis=0) - np.log(len(clouds)))


def _inside(points: Array, whole: Array) -> Array:
    return points[np.all((points >= whole[:, 0]) & (points <= whole[:, 1]), axis=1)]


def _polished(log_likelihood: LogLikelihood, points: Array, values: Array, whole: Array) -> tuple[Array, float]:
    """Return the likeliest point: the best drawn, or the maximum of the parabola through the likely ones."""
    at = int(np.argmax(values))
    best, log_best = points[at], float(values[at])
    shape = parabola(points, values)
    if shape is None:
        return best, log_best
    centre, _ = shape
    steps = np.array([0.25, 0.5, 0.75, 1.0])[:, None]
    trials = np.clip(best + steps * (centre - best), whole[:, 0], whole[:, 1])
    found = log_likelihood(trials)
    better = int(np.argmax(found))
    return (trials[better], float(found[better])) if found[better] > log_best else (best, log_best)


def parabola(points: Array, values: Array, *, depth: float = 3.0) -> tuple[Array, Array] | None:
    """Return maximum (d,) and Hessian (d, d) of the parabola through the points within `depth` of the best log value.

    None when they are too few, or when it has no maximum.
    """
    near = values > values.max() - depth
    d = points.shape[1]
    rows, columns = np.triu_indices(d)
    if np.count_nonzero(near) < 2 * (1 + d + len(rows)):
        return None
    middle, scale = points[near].mean(axis=0), np.maximum(points[near].std(axis=0), 1e-12)
    z = (points[near] - middle) / scale
    design = np.concatenate([np.ones((len(z), 1)), z, z[:, rows] * z[:, columns]], axis=1)
    coefficients = np.linalg.lstsq(design, values[near], rcond=None)[0]
    hessian = np.zeros((d, d))
    hessian[rows, columns] = coefficients[1 + d :]
    hessian = hessian + hessian.T
    if np.linalg.eigvalsh(hessian).max() >= 0.0:
        return None
    centre = -np.linalg.solve(hessian, coefficients[1 : 1 + d])
    return middle + scale * centre, hessian / np.outer(scale, scale)
