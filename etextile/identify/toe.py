r"""What a toe too faint to be seen does to the parameters: slack of the coupon that hides in the noise of its start.

A curve that rises as eps^n with n above 1 is nearly flat at first, so its datum is known to some deviation only, from
the fit with the datum free. Where the datum is left alone, that deviation, and how far the free fit would move it, go
into the covariance along d(ln E, ln H, n) / d datum; E = k exp(eps_0 - a / k) moves by -1 with it.
"""

from __future__ import annotations

import numpy as np

from etextile.identify.least_squares import CurveData, solve
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


WORTH_A_WORD = 0.02
"""Share of n by which an unseen toe has to move it for a sentence about it."""


def hidden_toe(law: PowerLaw, data: CurveData, *, slack_limit: float) -> tuple[Array, float]:
    """Return what an unseen toe adds to the covariance (3, 3) of (ln E, ln H, n), and its deviation (Hencky strain).

    `data`: loading; `slack_limit`: strain up to which the stress does not stand out of the noise.
    """
    if slack_limit <= 0.0:
        return np.zeros((3, 3)), 0.0
    free = solve(law, data, free_datum=True)
    variance = float(free.covariance[3, 3])
    if not 0.0 < variance < np.inf:
        return np.zeros((3, 3)), 0.0
    along = np.array([-1.0, free.covariance[1, 3] / variance, free.covariance[2, 3] / variance])
    toe = min(float(np.sqrt(variance + max(free.datum, 0.0) ** 2)), float(np.log1p(slack_limit)))
    return toe**2 * np.outer(along, along), toe


def toe_note(n: float, added: Array, toe: float) -> tuple[str, ...]:
    """Return a sentence where an unseen toe may move n by a part that counts; `added`: covariance (3, 3)."""
    if float(np.sqrt(added[2, 2])) < WORTH_A_WORD * n:
        return ()
    return (f"a toe of {toe:.2%} strain would not be seen in the noise of the start: it is in the intervals",)
