r"""Explanations of the start of a curve that the curve itself does not decide between, in the covariance.

A coupon's curve may be the law alone, the law behind a progressive toe (`toe`), or the law from a preload on at which
strain and stress were set to zero (`zeroed`). One of them is taken. Each other one counts with its Akaike weight w
(Burnham and Anderson, Model Selection, 2002, section 2.9: exp(-AIC / 2), normalised), and adds

    w (d d^T + v a a^T)

to the covariance of (ln E, ln H, n): d is its departure from what is taken; v is what is not known of the strain x_0 of
a preload, and a how the parameters move with it. x_0 is normal about its fitted value and cannot be negative.

Specimens of one direction are mounted and set to zero in one way: what they say for an explanation is added up, and
what is left in doubt does not average out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from etextile.identify.least_squares import LawSolution
from etextile.identify.statistics import is_noise
from etextile.identify.toe import counts
from etextile.identify.zeroed import along, lost
from etextile.types import Array


UNKNOWNS = {"law": 0, "zeroed": 1, "toe": 2}
"""Unknowns of the start of a curve by its explanation."""
MOST = 50.0
"""Half a difference of AIC beyond which a weight is as good as zero."""


@dataclass(frozen=True)
class Rivals:
    """Explanations of one curve: half the AIC above that of the law alone, and what those not taken add (3, 3).

    `added` is without their weight. `surely` (3, 3): what is added whatever the weights are.
    """

    half: dict[str, float] = field(default_factory=dict)
    added: dict[str, Array] = field(default_factory=dict)
    surely: Array = field(default_factory=lambda: np.zeros((3, 3)))

    def doubt(self, weight: dict[str, float]) -> Array:
        """Return what the explanations that were not taken add to the covariance (3, 3)."""
        return np.asarray(self.surely + sum(weight[name] * added for name, added in self.added.items()))


def half_akaike(fits: dict[str, LawSolution], noise: float) -> dict[str, float]:
    """Return half the AIC of each explanation above that of the law alone; `noise`: of the truss stress, MPa."""
    variance = max(min(float(np.mean(fit.residuals**2)) for fit in fits.values()), noise**2, 1e-300)
    half = {name: UNKNOWNS[name] + 0.5 * float(np.sum(fit.residuals**2)) / variance for name, fit in fits.items()}
    return {name: value - half["law"] for name, value in half.items()}


def weights(specimens: Sequence[Rivals]) -> dict[str, float]:
    """Return the Akaike weight of each explanation for specimens that have the same one."""
    half = {name: sum(item.half.get(name, 0.0) for item in specimens) for item in specimens for name in item.half}
    least = min(half.values(), default=0.0)
    relative = {name: float(np.exp(max(least - value, -MOST))) for name, value in half.items()}
    return {name: value / sum(relative.values()) for name, value in relative.items()}


def rivals_of(fits: dict[str, LawSolution], half: dict[str, float], taken: str, noise: float) -> Rivals:
    """Return the explanations of a curve; where more than noise is left, one counts if it explains most of that.

    A toe that was left in does so whatever its weight, for a law that leaves more than noise says nothing of others.
    """
    best, added, surely = fits[taken], {}, np.zeros((3, 3))
    zeroed, toe = fits.get("zeroed"), fits.get("toe")
    if zeroed is not None and taken != "zeroed" and counts(zeroed, best, noise):
        added["zeroed"] = of_preload(zeroed, best)
    if toe is not None and taken != "toe" and counts(toe, best, noise):
        moved = departure(toe, best)
        if is_noise(best.residuals, noise):
            added["toe"] = np.outer(moved, moved)
        else:
            surely = np.outer(moved, moved)
    return Rivals(half, added, surely)


def departure(fit: LawSolution, taken: LawSolution) -> Array:
    """Return how far (ln E, ln H, n) of a fit lie from those of the fit that was taken (3,)."""
    first = _gained(fit) - _gained(taken)
    return np.array([first, np.log(fit.law.H / taken.law.H), fit.law.n - taken.law.n])


def of_preload(fit: LawSolution, taken: LawSolution) -> Array:
    """Return what a preload that was set to zero adds to the covariance (3, 3), at a weight of one."""
    variance = float(fit.covariance[3, 3])
    if not 0.0 < variance < np.inf:
        return np.zeros((3, 3))
    at = max(-fit.datum, 0.0)
    moved = departure(fit, taken) if at > 0.0 or taken.datum != 0.0 else np.zeros(3)
    unknown = second_moment(-fit.datum, float(np.sqrt(variance))) - at**2
    return np.outer(moved, moved) + unknown * np.outer(along(fit), along(fit))


def second_moment(mean: float, std: float) -> float:
    """Return <x^2> of a normal x that is cut off below zero."""
    from scipy.stats import norm

    at = mean / std
    hazard = float(np.exp(norm.logpdf(at) - norm.logcdf(at)))
    return float(max(std**2 + mean**2 + mean * std * hazard, 0.0))


def _gained(fit: LawSolution) -> float:
    """Return what ln E has gained by the datum: E = k exp(p), so less by a toe and more by a preload."""
    return lost(fit)[0] if fit.datum < 0.0 else -fit.datum
