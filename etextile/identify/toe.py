r"""The toe of a curve: strain without much stress while a coupon comes taut and its yarns straighten.

A slack coupon comes taut at once, which shifts the datum. Yarns straighten one after the other as the stress rises and
a toe t is taken up over a stress c, e = e_fabric(s) + t (1 - exp(-s / c)): the law's curve, bent at its start. Both are
fitted where the law alone leaves more than noise, and the toe is taken out where noise is all that is then left. Where
more is left, how far the toe moves H and n is what is not known of them.

A toe too faint to be seen is in the covariance.

A curve that rises as eps^n with n above 1 is nearly flat at first, so its datum is known to some deviation only, from
the fit with the datum free. Where the datum is left alone, that deviation, and how far the free fit would move it, go
into the covariance along d(ln E, ln H, n) / d datum; E = k exp(eps_0 - a / k) moves by -1 with it.
"""

from __future__ import annotations

import numpy as np

from etextile.identify.least_squares import CurveData, LawSolution, solve
from etextile.identify.statistics import is_noise
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


EVIDENCE = 11.0
"""A datum is moved when the fit gains so many times what chance would: F of one and many degrees at 1 in 1000."""
MUCH = 1.0
"""Share of what is left by which a toe or preload lessens the misfit for its doubt to count, where more is left."""
FIRST_TOE, FIRST_OVER = 0.05, 0.03
"""The progressive toe that the search starts from, as shares of the largest strain and stress."""
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


def progressive(law: PowerLaw, data: CurveData) -> LawSolution:
    """Return the best fit with a progressive toe that starts from `law`; `data`: loading."""
    first, over = FIRST_TOE * float(data.hencky[-1]), FIRST_OVER * float(data.stress.max())
    return solve(law, data, free_datum=True, datum=first, over=over)


def is_better(free: LawSolution, held: LawSolution, *, times: float | None = None) -> bool:
    """Tell whether a fit with more freedom lies closer to the points than one with less, by more than chance (F test).

    `times`: by so many times what is left at least, instead. A shift that gains nothing is no finding about the test.
    """
    count = max(len(free.residuals) - 3, 1)
    left, before = float(np.sum(free.residuals**2)), float(np.sum(held.residuals**2))
    return before - left > left * (EVIDENCE / count if times is None else times)


def progressive_note(found: LawSolution, area_ratio: float) -> str:
    """Say that a progressive toe was taken out."""
    return (
        f"a progressive toe of {found.datum:.4f}, taken up over {found.over / area_ratio:.2g} MPa as yarns straighten, "
        "taken out"
    )


def counts(free: LawSolution, held: LawSolution, noise: float) -> bool:
    """Tell whether the doubt of a freer fit counts: nothing is left to explain, or it explains most of it."""
    return is_noise(held.residuals, noise) or is_better(free, held, times=MUCH)


def left_in_note(held: LawSolution, toe: LawSolution, noise: float, area_ratio: float) -> tuple[str, ...]:
    """Return a sentence about a toe that was left in though it would explain most of what a fit leaves."""
    moved = toe.law.n - held.law.n
    if is_noise(held.residuals, noise) or not counts(toe, held, noise) or abs(moved) < WORTH_A_WORD * held.law.n:
        return ()
    return (
        f"a progressive toe of {toe.datum:.4f} over {toe.over / area_ratio:.2g} MPa would explain most of the misfit "
        f"and move n by {moved:+.2g}: it is left in, and in the intervals",
    )


def toe_note(n: float, added: Array, toe: float) -> tuple[str, ...]:
    """Return a sentence where an unseen toe may move n by a part that counts; `added`: covariance (3, 3)."""
    if float(np.sqrt(added[2, 2])) < WORTH_A_WORD * n:
        return ()
    return (f"a toe of {toe:.2%} strain would not be seen in the noise of the start: it is in the intervals",)
