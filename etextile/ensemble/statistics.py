"""From the samples' own probabilities to probabilities with 95 % intervals, and to what the inputs have to do with it.

Within a sample the failure criterion gives each loop a probability (its strength scatters from loop to loop). The
probability over all specimens is the mean of these over the samples. A run that found no equilibrium is kept as a pair
of bounds: what it had shown up to there, and certain failure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit
from scipy.stats import rankdata

from etextile.types import Array, IntArray


NORMAL_95 = 1.959964
RESAMPLES = 1000
LEAST_RANKED = 12
"""Samples below which nothing is ranked: the bootstrap knows no doubt there."""


@dataclass(frozen=True)
class Probability:
    """Probabilities with 95 % intervals, all of one shape."""

    value: Array
    low: Array
    high: Array


@dataclass(frozen=True)
class Correlation:
    """Spearman's rank correlation with its 95 % interval; `samples` is how many could be ranked."""

    value: float
    low: float
    high: float
    samples: int

    @property
    def matters(self) -> bool:
        """Whether the interval leaves out zero."""
        return self.low > 0.0 or self.high < 0.0


def bounds(values: Array) -> tuple[Array, Array]:
    """Return lower and upper bounds of probabilities (N, S, ...) over S steps, NaN from where a run broke off.

    Damage does not heal, so the last known probability stays a lower bound; the upper one is 1.
    """
    known = ~np.isnan(values)
    low = np.maximum.accumulate(np.where(known, values, 0.0), axis=1)
    return low, np.where(known, values, 1.0)


def probability(low: Array, high: Array) -> Probability:
    """Return the probability over samples (N, ...) known within [low, high], with its 95 % interval.

    The value is the middle of the two means. The interval reaches from the lower end for `low` to the upper for `high`.
    """
    value = 0.5 * (low.mean(axis=0) + high.mean(axis=0))
    return Probability(value, interval(low)[0], interval(high)[1])


def interval(values: Array) -> tuple[Array, Array]:
    """Return the 95 % interval of the mean of values (N, ...) in [0, 1].

    Agresti and Coull (Am. Stat. 52 (1998) 119) carried over from counts to values in [0, 1]: z^2 / 2 samples of 0 and
    as many of 1 are added, then m +- z s / sqrt(N + z^2). For values of 0 and 1 it is theirs; it never has zero width
    and is wide of the mark on the safe side for Sobol points, whose means scatter less than those of random ones.
    """
    added = NORMAL_95**2
    count = len(values) + added
    mean = (values.sum(axis=0) + 0.5 * added) / count
    square = ((values**2).sum(axis=0) + 0.5 * added) / count
    half = NORMAL_95 * np.sqrt(np.maximum(square - mean**2, 0.0) / count)
    return np.maximum(mean - half, 0.0), np.minimum(mean + half, 1.0)


def difference(first: tuple[Array, Array], second: tuple[Array, Array]) -> Probability:
    """Return the mean of second less first with its 95 % interval; both are bounds (N, ...) of paired samples.

    For events: differences lie in [-1, 1]; moved to [0, 1] they have the interval of `interval`, which allows for
    specimens of which no sample happened to be like.
    """
    low, high = second[0] - first[1], second[1] - first[0]
    moved = probability(0.5 * (low + 1.0), 0.5 * (high + 1.0))
    return Probability(*(2.0 * part - 1.0 for part in (moved.value, moved.low, moved.high)))


def mean_difference(first: tuple[Array, Array], second: tuple[Array, Array]) -> Probability:
    """Return the mean of second less first with Student's 95 % interval; both are bounds (N, ...) of paired samples.

    For smooth numbers (shares of many wires, displacements). The interval is infinite for fewer than two samples.
    """
    low, high = second[0] - first[1], second[1] - first[0]
    value = 0.5 * (low.mean(axis=0) + high.mean(axis=0))
    return Probability(value, low.mean(axis=0) - _student(low), high.mean(axis=0) + _student(high))


def _student(values: Array) -> Array:
    """Return half the width of Student's 95 % interval of the mean of values (N, ...)."""
    count = len(values)
    if count < 2:
        return np.full(values.shape[1:], np.inf)
    return np.asarray(stdtrit(count - 1, 0.975) * values.std(axis=0, ddof=1) / np.sqrt(count))


def mean_of(values: Array, copies: IntArray) -> Array:
    """Return the expected share (N, S) of the things that fail: sum (copies p) / sum copies."""
    return np.asarray(values @ copies / copies.sum())


def crossing(displacement: Array, values: Array, level: float = 0.5) -> float | None:
    """Return where a curve (S,) over displacement (S,) first reaches a level, linear between; None when it does not."""
    reached = np.flatnonzero(values >= level)
    if not len(reached):
        return None
    step = int(reached[0])
    if step == 0:
        return float(displacement[0])
    below, above = values[step - 1], values[step]
    weight = (level - below) / (above - below)
    return float(displacement[step - 1] + weight * (displacement[step] - displacement[step - 1]))


def rank_correlation(x: Array, y: Array, *, seed: int = 0) -> Correlation | None:
    """Return Spearman's correlation of x and y (N,) with a bootstrapped 95 % interval; None for constants or too few.

    Equal values share their mean rank; infinite values are ranked like others. Percentile bootstrap over samples.
    """
    if len(x) < LEAST_RANKED or np.ptp(rankdata(x)) == 0.0 or np.ptp(rankdata(y)) == 0.0:
        return None
    picks = np.random.default_rng(seed).integers(0, len(x), (RESAMPLES, len(x)))
    found = _spearman(x[picks], y[picks])
    low, high = np.percentile(found[np.isfinite(found)], [2.5, 97.5])
    return Correlation(float(_spearman(x[None], y[None])[0]), float(low), float(high), len(x))


def _spearman(x: Array, y: Array) -> Array:
    """Return the correlation of the ranks along the last axis; NaN where one is constant."""
    a, b = (rankdata(values, axis=-1) for values in (x, y))
    a, b = (ranks - ranks.mean(axis=-1, keepdims=True) for ranks in (a, b))
    scale = np.sqrt((a**2).sum(axis=-1) * (b**2).sum(axis=-1))
    return np.asarray(np.where(scale > 0.0, (a * b).sum(axis=-1) / np.where(scale > 0.0, scale, 1.0), np.nan))
