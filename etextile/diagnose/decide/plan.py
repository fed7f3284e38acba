r"""The next measurement by what it is expected to tell.

K explanations with probabilities p_k predict a measurement y ~ N(m_k, C_k). What it tells is the mutual information

    I = H(p) - E_y H(p | y)   (bits),

and what a person wants to know is how probable the likeliest explanation will be, E_y max_k p(k | y). Both are means
over draws of y from the mixture. For more repeats of the same test there is a closed form: with d^2 the squared
distance of two predictions under the covariance of n specimens, the log odds for the right one are N(d^2 / 2, d^2).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.diagnose.decide.foretell import Foretold
from etextile.diagnose.decide.rivals import DECISIVE
from etextile.diagnose.infer.gauss import Whitener, log_sum
from etextile.types import Array


DRAWS = 400
ENOUGH = 0.8
"""Chance of decisive odds from which on a measurement counts as deciding."""
MOST_REPEATS = 30


@dataclass(frozen=True)
class Gain:
    """What a measurement is expected to tell, bits; the expected probability of the explanation that then leads.

    `decisive`: chance that it leads with odds of `DECISIVE` to one against every other.
    """

    bits: float
    probability: float
    decisive: float


def gain(foretold: Sequence[Foretold], *, seed: int = 0, draws: int = DRAWS) -> Gain:
    """Return what a measurement is expected to tell of these explanations."""
    p = np.array([item.probability for item in foretold])
    p = p / p.sum()
    rng = np.random.default_rng(seed)
    whiteners = [Whitener.of(item.covariance) for item in foretold]
    counts = np.maximum(1, np.round(draws * p).astype(int))
    bits, best, decisive = 0.0, 0.0, 0.0
    for share, count, item, own in zip(p, counts, foretold, whiteners, strict=True):
        y = item.mean[:, None] + own.factor @ rng.standard_normal((len(item.mean), count))
        after = _posterior(y, foretold, whiteners, p)
        entropy = -(after * np.log2(np.maximum(after, 1e-300))).sum(axis=0)
        ordered = np.sort(after, axis=0)
        second = ordered[-2] if len(ordered) > 1 else np.zeros(count)
        bits -= share * float(entropy.mean())
        best += share * float(ordered[-1].mean())
        decisive += share * float(np.mean(ordered[-1] >= DECISIVE * second))
    bits -= float((p * np.log2(np.maximum(p, 1e-300))).sum())
    return Gain(max(bits, 0.0), best, decisive)


def _posterior(y: Array, foretold: Sequence[Foretold], whiteners: Sequence[Whitener], p: Array) -> Array:
    """Return probabilities (K, b) of the explanations after measurements y (n, b)."""
    rows = [
        np.log(max(float(share), 1e-300)) + log_density(y - item.mean[:, None], own)
        for share, item, own in zip(p, foretold, whiteners, strict=True)
    ]
    log_p = np.stack(rows)
    return np.asarray(np.exp(log_p - log_sum(log_p, axis=0)))


def log_density(difference: Array, whiten: Whitener) -> Array:
    """Return the log density (b,) of differences (n, b) but for the constant that all share."""
    return np.asarray(-0.5 * (whiten(difference) ** 2).sum(axis=0) - 0.5 * whiten.log_determinant)


@dataclass(frozen=True)
class Repeats:
    """How many specimens in all tell two explanations apart with a power; None: no number up to the most does.

    `power` (n,): chance of decisive odds with 1, 2, ... specimens.
    """

    specimens: int | None
    wished: float
    power: Array


def repeats(difference: Array, single: Array, common: Array, *, wished: float = 0.8) -> Repeats:
    """Return how many specimens tell two predictions apart that differ by `difference` (n,).

    `single` (n, n): covariance that falls as 1 / specimens; `common` (n, n): what they share (fabric, lattice, form).
    """
    from scipy.stats import norm

    power = []
    for count in range(1, MOST_REPEATS + 1):
        d = float(np.linalg.norm(Whitener.of(single / count + common)(difference)))
        power.append(float(norm.cdf((0.5 * d**2 - np.log(DECISIVE)) / max(d, 1e-9))))
    enough = [i for i, value in enumerate(power, start=1) if value >= wished]
    return Repeats(enough[0] if enough else None, wished, np.array(power))
