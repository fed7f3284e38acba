"""Force and slack of one-sided elements as a pair of unknowns: F(t) s = mu with s = t - stretch of the geometry.

Linearised at (t, s) with r = s - (t - g), D = s F' + F and the change dg of the stretch along the step,

    dt = (mu - F s + F r + F dg) / D,      ds = dt - dg - r,

so seen from the nodes the element bears F + F' (mu - F s + F r) / D with the stiffness F F' / D: anything between none
and that of the law, with no kink. A pair that would turn negative stops at `KEEP` of itself on its own; cutting the
step of all elements for the sake of a few is what makes textbook interior-point steps tiny here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.compiled import njit
from etextile.mechanics.onesided import OneSided
from etextile.types import Array


KEEP = 0.02
"""Share of a stretch or slack that a step leaves at least."""
LEAST = 1e-30
"""Smallest stretch and slack, mm."""
LEAST_CENTRING, MOST_CENTRING = 0.02, 0.5
"""Bounds of the factor by which a step means to bring down the mean of F s."""


@dataclass
class Pair:
    """Stretches t (n,) and slacks s (n,), mm, of one set of elements, and their law F (n,) N, F' (n,) N/mm at t."""

    side: OneSided
    stretch: Array
    slack: Array
    force: Array
    slope: Array

    @classmethod
    def centred(cls, side: OneSided, mu: float) -> Pair:
        """Return about F s = mu (N mm), exactly so for a linear law."""
        product = mu / side.stiffness
        half = 0.5 * side.stretch
        large = np.abs(half) + np.sqrt(half * half + product)
        small = np.maximum(product / large, LEAST)
        stretch, slack = (np.where(half > 0.0, one, other) for one, other in ((large, small), (small, large)))
        return cls(side, stretch, slack, *side.bear(stretch))

    @property
    def product(self) -> float:
        """Mean of F s, N mm."""
        return float(self.force @ self.slack) / len(self.force)

    def gap(self) -> Array:
        """Return r = s - (t - g) (n,), mm: what the pair is off the geometry."""
        return np.asarray(self.slack - self.stretch + self.side.stretch)

    def slopes(self, *, exact: bool) -> Array:
        """Return F' (n,): with `exact` softening is kept as far as D stays positive, else it is left out."""
        least = -0.5 * self.force / self.slack if exact else np.zeros(len(self.force))
        return np.maximum(self.slope, least)

    def moved(self, side: OneSided, rise: Array, widening: Array) -> Pair:
        """Return the pair at the next trial after changes of stretch and slack (n,)."""
        stretch, slack = np.empty(len(rise)), np.empty(len(rise))
        _move(self.stretch, self.slack, rise, widening, side.stretch, stretch, slack)
        return Pair(side, stretch, slack, *side.bear(stretch))


@dataclass(frozen=True)
class Linear:
    """A set linearised: force F, slope F' as used, slack s, D, and r, each (n,)."""

    force: Array
    slope: Array
    slack: Array
    spread: Array
    gap: Array

    @classmethod
    def of(cls, pair: Pair, *, exact: bool) -> Linear:
        """Linearise a pair."""
        slope = pair.slopes(exact=exact)
        spread = pair.slack * slope + pair.force
        return cls(pair.force, slope, pair.slack, np.where(spread > 0.0, spread, 1.0), pair.gap())

    @property
    def along(self) -> Array:
        """Stiffness (n,) seen from the nodes, N/mm."""
        return np.asarray(self.force * self.slope / self.spread)

    def borne(self, aim: Array | float, bulge: Array | float = 0.0) -> Array:
        """Return the force (n,) on the right-hand side for F s = aim and a stretch that gains `bulge` (n,)."""
        off = aim + self.force * (self.gap + bulge - self.slack)
        return np.asarray(self.force + self.slope * off / self.spread)

    def change(self, rate: Array, aim: Array | float, bulge: Array | float = 0.0) -> tuple[Array, Array]:
        """Return changes of stretch and slack (n,) when the geometry stretches by `rate` (n,)."""
        gap = self.gap + bulge
        rise = (aim + self.force * (gap + rate - self.slack)) / self.spread
        return rise, rise - rate - gap

    def foresee(self, rise: Array, widening: Array, length: float) -> tuple[float, Array]:
        """Return the mean of F s after the changes, cut at zero, and the second-order part (n,) of their product."""
        force = np.maximum(self.force + length * self.slope * rise, 0.0)
        slack = np.maximum(self.slack + length * widening, 0.0)
        return float(force @ slack) / len(force), length**2 * self.slope * rise * widening


def centring(now: float, foreseen: float, floor: float) -> float:
    """Return the next mu: the better the step that aims at zero does, the smaller (Mehrotra), never below `floor`."""
    share = (foreseen / now) ** 2 if now > 0.0 else 1.0
    return max(min(max(share, LEAST_CENTRING), MOST_CENTRING) * now, floor)


@njit
def _move(t, s, rise, widening, geometry, t_new, s_new):  # type: ignore[no-untyped-def]
    """Fill the moved pair; a slack that agrees with the geometry to its tenth is set to it."""
    for e in range(t.shape[0]):
        t_new[e] = max(t[e] + rise[e], KEEP * t[e], LEAST)
        slack = max(s[e] + widening[e], KEEP * s[e])
        found = t_new[e] - geometry[e]
        s_new[e] = max(found if found > 0.1 * slack else slack, LEAST)
