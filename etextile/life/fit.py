"""Two-parameter Weibull and lognormal lives by maximum likelihood, with bounds by the likelihood ratio.

Both are families of location mu and scale sigma on the logarithm of the life, with z = (ln t - mu) / sigma:

    Weibull      S(t) = exp(-e^z)        shape beta = 1 / sigma, characteristic life eta = e^mu (63.2 % have failed)
    lognormal    S(t) = 1 - Phi(z)       median e^mu

Each life adds to the log likelihood ln f(t) when it is known, ln(S(low) - S(high)) when it lies between two
inspections, ln S(low) when it goes on. A bound of a quantity q is where the profile

    2 (max L - max over the other parameter of L at q) = chi2(confidence, 1)

which, unlike q plus or minus two standard errors, keeps its promise for few and censored lives (Meeker and Escobar,
Statistical Methods for Reliability Data, chapter 8). A bound that does not exist is infinite (or 0).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, minimize, minimize_scalar
from scipy.special import log_ndtr, ndtr, ndtri
from scipy.stats import chi2

from etextile.life.lives import Lives
from etextile.types import Array


LEAST_SCALE, MOST_SCALE = 1e-4, 50.0
"""Scales of ln t outside of these are no scatter of lives: the likelihood has no maximum between them."""
FAR = 700.0
"""Standardised logarithms beyond this overflow the exponential."""
WIDE = 6.0
"""How far from its estimate the logarithm of the other parameter is sought on a profile."""
OUTWARD = 60
"""Doublings of the step in search of a bound before it is taken not to exist."""


@dataclass(frozen=True)
class LifeDistribution:
    """A standard distribution of ln t: log density, log survival, log of failed, quantile and cumulative by z."""

    name: str
    log_density: Callable[[Array], Array]
    log_survival: Callable[[Array], Array]
    log_failed: Callable[[Array], Array]
    quantile: Callable[[float], float]
    failed: Callable[[float], float]


def _log_share(z: Array) -> Array:
    """Return ln(1 - exp(-e^z))."""
    return np.asarray(np.log(-np.expm1(-np.exp(z))))


WEIBULL = LifeDistribution(
    "weibull",
    lambda z: np.asarray(z - np.exp(z)),
    lambda z: np.asarray(-np.exp(z)),
    _log_share,
    lambda p: math.log(-math.log1p(-p)),
    lambda z: -math.expm1(-math.exp(min(z, FAR))),
)
LOGNORMAL = LifeDistribution(
    "lognormal",
    lambda z: np.asarray(-0.5 * z**2 - 0.5 * math.log(2.0 * math.pi)),
    lambda z: np.asarray(log_ndtr(-z)),
    lambda z: np.asarray(log_ndtr(z)),
    lambda p: float(ndtri(p)),
    lambda z: float(ndtr(z)),
)
FAMILIES: Mapping[str, LifeDistribution] = {family.name: family for family in (WEIBULL, LOGNORMAL)}


@dataclass(frozen=True)
class Bounded:
    """A number with the bounds that the likelihood ratio gives it."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class LifeFit:
    """A family fitted to lives: location `mu` and scale `sigma` of ln t, and the greatest log likelihood."""

    family: LifeDistribution
    mu: float
    sigma: float
    log_likelihood: float
    lives: Lives

    @property
    def aic(self) -> float:
        """Akaike's criterion, 2 x 2 parameters - 2 L; the smaller the better."""
        return 4.0 - 2.0 * self.log_likelihood

    def quantile(self, share: float) -> float:
        """Return the cycles by which `share` have failed."""
        return math.exp(self.mu + self.sigma * self.family.quantile(share))

    def failed(self, cycles: float) -> float:
        """Return the share that has failed by `cycles`."""
        return self.family.failed((math.log(cycles) - self.mu) / self.sigma) if cycles > 0.0 else 0.0

    def quantile_bounds(self, share: float, confidence: float = 0.95) -> Bounded:
        """Return the life by which `share` have failed (0.1: B10) with its bounds."""
        z = self.family.quantile(share)
        start = self.mu + self.sigma * z
        low, high = _bounds(
            self, lambda q, log_sigma: (q - math.exp(log_sigma) * z, log_sigma), start, math.log(self.sigma), confidence
        )
        return Bounded(math.exp(start), _exp(low), _exp(high))

    def failed_bounds(self, cycles: float, confidence: float = 0.95) -> Bounded:
        """Return the share that has failed by `cycles` with its bounds."""
        log_t = math.log(cycles)
        start = (log_t - self.mu) / self.sigma
        low, high = _bounds(
            self,
            lambda z, log_sigma: (log_t - math.exp(log_sigma) * z, log_sigma),
            start,
            math.log(self.sigma),
            confidence,
        )
        ends = (self.family.failed(low) if math.isfinite(low) else 0.0, self.family.failed(high))
        return Bounded(self.family.failed(start), *ends)

    def sigma_bounds(self, confidence: float = 0.95) -> Bounded:
        """Return the scale of ln t with its bounds."""
        low, high = _bounds(
            self, lambda log_sigma, mu: (mu, log_sigma), math.log(self.sigma), self.mu, confidence, spread=self.sigma
        )
        return Bounded(self.sigma, _exp(low), _exp(high))


def log_likelihood(lives: Lives, family: LifeDistribution, mu: float, sigma: float) -> float:
    """Return the log likelihood of lives (densities are per cycle, so that families compare)."""
    low, high = lives.low, lives.high
    known, goes_on, early = low == high, np.isinf(high), (low == 0.0) & np.isfinite(high)
    between = ~(known | goes_on | early)

    def standard(cycles: Array) -> Array:
        return np.clip((np.log(cycles) - mu) / sigma, -FAR, FAR)

    total = float(np.sum(family.log_density(standard(low[known])) - math.log(sigma) - np.log(low[known])))
    total += float(np.sum(family.log_survival(standard(low[goes_on]))))
    total += float(np.sum(family.log_failed(standard(high[early]))))
    return total + float(np.sum(_log_between(family, standard(low[between]), standard(high[between]))))


def _log_between(family: LifeDistribution, low: Array, high: Array) -> Array:
    """Return ln(S(low) - S(high)), from the side on which no digits cancel."""
    above = low > 0.0
    first = np.where(above, family.log_survival(low), family.log_failed(high))
    less = np.where(above, family.log_survival(high), family.log_failed(low))
    return np.asarray(first + np.log(np.maximum(-np.expm1(np.minimum(less - first, 0.0)), 1e-300)))


def fit(lives: Lives, family: LifeDistribution) -> LifeFit | str:
    """Return the fit of greatest likelihood, or in words why there is none."""
    failed = lives.failed
    if not failed.any():
        return "no specimen failed"
    if lives.low.max() <= lives.high.min():
        return "one life would explain all of them, so their scatter cannot be told"
    middle = np.log(
        np.where(failed, 0.5 * (lives.low + np.where(failed, lives.high, 0.0)), np.maximum(lives.low, 1e-9))
    )
    start = np.array([float(middle.mean()), math.log(max(float(middle.std()), 0.05))])
    best = minimize(
        lambda x: -log_likelihood(lives, family, x[0], math.exp(np.clip(x[1], -20.0, 20.0))),
        start,
        method="Nelder-Mead",
        options={"xatol": 1e-9, "fatol": 1e-11, "maxiter": 5000, "maxfev": 5000},
    )
    mu, sigma = float(best.x[0]), math.exp(float(np.clip(best.x[1], -20.0, 20.0)))
    if not best.success or not LEAST_SCALE < sigma < MOST_SCALE:
        return "the lives do not bound the likelihood"
    return LifeFit(family, mu, sigma, -float(best.fun), lives)


def _bounds(
    found: LifeFit,
    parameters: Callable[[float, float], tuple[float, float]],
    start: float,
    other: float,
    confidence: float,
    *,
    spread: float = 1.0,
) -> tuple[float, float]:
    """Return where the profile of a quantity drops by half of chi2, below and above its estimate `start`.

    parameters(quantity, other) -> (mu, ln sigma); `other` is its estimate, sought within WIDE times `spread` of it.
    """
    drop = 0.5 * float(chi2.ppf(confidence, 1))

    def lost(quantity: float) -> float:
        def against(value: float) -> float:
            mu, log_sigma = parameters(quantity, value)
            return -log_likelihood(found.lives, found.family, mu, math.exp(log_sigma))

        best = minimize_scalar(
            against, bounds=(other - WIDE * spread, other + WIDE * spread), method="bounded", options={"xatol": 1e-9}
        )
        return found.log_likelihood + float(best.fun) - drop

    return _outward(lost, start, -1.0), _outward(lost, start, 1.0)


def _outward(lost: Callable[[float], float], start: float, sign: float) -> float:
    """Return the first crossing of 0 on one side of `start`; infinite when there is none."""
    inner, step = start, 0.05
    for _ in range(OUTWARD):
        outer = inner + sign * step
        if lost(outer) > 0.0:
            return float(brentq(lost, *sorted((inner, outer)), xtol=1e-9))
        inner, step = outer, min(2.0 * step, 5.0)
    return sign * math.inf


def _exp(value: float) -> float:
    return math.exp(value) if value < FAR else math.inf
