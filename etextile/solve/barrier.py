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
        return float(_mean_product(self.force, self.slack))

    def moved(self, side: OneSided, change: tuple[Array, Array], length: float) -> Pair:
        """Return the pair at the next trial after `length` times the changes of stretch and slack (n,)."""
        stretch, slack = np.empty(len(self.stretch)), np.empty(len(self.stretch))
        _move(self.stretch, self.slack, *change, length, side.stretch, stretch, slack)
        return Pair(side, stretch, slack, *side.bear(stretch))


@dataclass(frozen=True)
class LinearSet:
    """A set linearised: force F, slope F' as used, slack s, D, r = s - (t - g), and stiffness seen, each (n,)."""

    force: Array
    slope: Array
    slack: Array
    spread: Array
    gap: Array
    along: Array

    @classmethod
    def of(cls, pair: Pair, *, exact: bool) -> LinearSet:
        """Linearise a pair; with `exact` softening is kept as far as D stays positive, else it is left out."""
        slope, spread, gap, along = (np.empty(len(pair.force)) for _ in range(4))
        _linearise(
            pair.force, pair.slope, pair.slack, pair.stretch, pair.side.stretch, exact, slope, spread, gap, along
        )
        return cls(pair.force, slope, pair.slack, spread, gap, along)

    def borne(self, target: Target) -> Array:
        """Return the force (n,) on the right-hand side."""
        force = np.empty(len(self.force))
        _borne(self.force, self.slope, self.slack, self.spread, self.gap, target.product, target.bulge, force)
        return force

    def change(self, rate: Array, target: Target) -> tuple[Array, Array]:
        """Return changes of stretch and slack (n,) when the geometry stretches by `rate` (n,)."""
        rise, widening = np.empty(len(rate)), np.empty(len(rate))
        _change(self.force, self.slack, self.spread, self.gap, rate, target.product, target.bulge, rise, widening)
        return rise, widening

    def aim(self, change: tuple[Array, Array], length: float, floor: float) -> Array:
        """Return the products (n,) to aim at once the step that aims at zero is known, cut to `length` of itself.

        The better that step does, the smaller the mean (Mehrotra), never below `floor`; the second-order part of the
        product along it is taken off.
        """
        aim = np.empty(len(self.force))
        _aim(self.force, self.slope, self.slack, *change, length, floor, aim)
        return aim


@dataclass(frozen=True)
class Target:
    """What a step aims at: F s (n,) N mm, and what stretches gain (n,) mm beyond their rate, both 0 for a predictor."""

    product: Array
    bulge: Array

    @classmethod
    def zero(cls, count: int) -> Target:
        """Return the target of a predictor for `count` elements."""
        nothing = np.zeros(count)
        return cls(nothing, nothing)


@njit
def _mean_product(force, slack):  # type: ignore[no-untyped-def]
    """Return the mean of F s."""
    total = 0.0
    for e in range(force.shape[0]):
        total += force[e] * slack[e]
    return total / max(force.shape[0], 1)


@njit
def _linearise(force, slope, slack, stretch, geometry, exact, used, spread, gap, along):  # type: ignore[no-untyped-def]
    """Fill F' as used, D, r and F F' / D."""
    for e in range(force.shape[0]):
        used[e] = max(slope[e], -0.5 * force[e] / slack[e] if exact else 0.0)
        d = slack[e] * used[e] + force[e]
        spread[e] = d if d > 0.0 else 1.0
        gap[e] = slack[e] - stretch[e] + geometry[e]
        along[e] = force[e] * used[e] / spread[e]


@njit
def _borne(force, slope, slack, spread, gap, product, bulge, out):  # type: ignore[no-untyped-def]
    """Fill F + F' (mu - F s + F (r + bulge)) / D."""
    for e in range(force.shape[0]):
        off = product[e] + force[e] * (gap[e] + bulge[e] - slack[e])
        out[e] = force[e] + slope[e] * off / spread[e]


@njit
def _change(force, slack, spread, gap, rate, product, bulge, rise, widening):  # type: ignore[no-untyped-def]
    """Fill dt and ds of the module's equations."""
    for e in range(force.shape[0]):
        off = gap[e] + bulge[e]
        rise[e] = (product[e] + force[e] * (off + rate[e] - slack[e])) / spread[e]
        widening[e] = rise[e] - rate[e] - off


@njit
def _aim(force, slope, slack, rise, widening, length, floor, aim):  # type: ignore[no-untyped-def]
    """Fill the products to aim at: mu less the second-order part, which is held within the present product and mu."""
    now = foreseen = 0.0
    for e in range(force.shape[0]):
        now += force[e] * slack[e]
        borne = max(force[e] + length * slope[e] * rise[e], 0.0)
        foreseen += borne * max(slack[e] + length * widening[e], 0.0)
    count = max(force.shape[0], 1)
    share = (foreseen / now) ** 2 if now > 0.0 else 1.0
    mu = max(min(max(share, LEAST_CENTRING), MOST_CENTRING) * now / count, floor)
    for e in range(force.shape[0]):
        product = force[e] * slack[e]
        bend = length * length * slope[e] * rise[e] * widening[e]
        aim[e] = mu - min(max(bend, -product), max(product, mu))


@njit
def _move(t, s, rise, widening, length, geometry, t_new, s_new):  # type: ignore[no-untyped-def]
    """Fill the moved pair; a slack that agrees with the geometry to its tenth is set to it."""
    for e in range(t.shape[0]):
        t_new[e] = max(t[e] + length * rise[e], KEEP * t[e], LEAST)
        slack = max(s[e] + length * widening[e], KEEP * s[e])
        found = t_new[e] - geometry[e]
        s_new[e] = max(found if found > 0.1 * slack else slack, LEAST)
