"""Survival without a distribution: Kaplan and Meier's product limit, Turnbull's estimate for lives between inspections.

Lives that are known or go on are left to scipy. Between inspections the estimate is lifelines'; it takes an interval
as closed at both ends, so that a failure between 1000 and 2000 cycles and one between 2000 and 3000 would share the
cycle 2000 and be put there. A life is greater than `low`: the lower ends are moved up by a part in 10^9.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.stats import CensoredData, ecdf

from etextile.life.lives import Lives
from etextile.types import Array


NUDGE = 1e-9
NEEDS = "lives between inspections need the extra 'life' (pip install 'etextile[life]')"


@dataclass(frozen=True)
class SurvivalCurve:
    """Share (n,) still whole from each of `cycles` (n,) on; `low`, `high` its bounds, NaN where there are none."""

    method: str
    cycles: Array
    survival: Array
    low: Array
    high: Array


def survival(lives: Lives, confidence: float = 0.95) -> SurvivalCurve | str:
    """Return the curve of lives, or in words why there is none."""
    if not lives.failed.any():
        return "no specimen failed"
    exact = (lives.low == lives.high) | np.isinf(lives.high)
    return _product_limit(lives, confidence) if exact.all() else _turnbull(lives)


def _product_limit(lives: Lives, confidence: float) -> SurvivalCurve:
    """Return Kaplan and Meier's estimate with log-log bounds by Greenwood's variance."""
    failed = lives.failed
    found = ecdf(CensoredData(uncensored=lives.low[failed], right=lives.low[~failed])).sf
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")  # no variance where all or none have failed: the bounds are nan there
        bounds = found.confidence_interval(confidence, method="log-log")
    return SurvivalCurve(
        "Kaplan-Meier", found.quantiles, found.probabilities, bounds.low.probabilities, bounds.high.probabilities
    )


def _turnbull(lives: Lives) -> SurvivalCurve | str:
    """Return Turnbull's estimate; the share is given from the end of each interval in which some failed."""
    try:
        from lifelines import KaplanMeierFitter
    except ImportError:
        return NEEDS
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # remarks about other methods
        fitter = KaplanMeierFitter().fit_interval_censoring(
            np.where(lives.low < lives.high, lives.low * (1.0 + NUDGE), lives.low), lives.high
        )
    table = fitter.survival_function_
    cycles = np.asarray(table.index, dtype=np.float64)
    share = np.asarray(table["NPMLE_estimate_lower"], dtype=np.float64)
    ends = np.unique(lives.high[lives.failed])
    whole = np.array([share[cycles <= end * (1.0 + 0.5 * NUDGE)].min() for end in ends])
    none = np.full(len(ends), np.nan)
    return SurvivalCurve("Turnbull", ends, whole, none, none)
