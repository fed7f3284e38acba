"""Refinement by simulated coupons: laws for which the lattice, not a single truss, returns the measured curves.

The direct identification lets each coupon be carried by one family alone. A simulated coupon knows better: diagonals
take part in warp and weft tension, a bias coupon at 45 degrees loads diagonals that lie at 29 degrees, clamps
constrain. Each round multiplies a family's own curve by target / simulated and fits H and n again; E, which acts in
unloading, stays. The simulator is handed in, so that this package stays below the solver.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from etextile.identify.coupon import loading_curve
from etextile.identify.least_squares import CurveData, solve
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


ROUNDS = 8
TOLERANCE = 2e-3
# A simulated stress is corrected by at most this factor in one round.
MAX_FACTOR = 2.0


class CouponSimulator(Protocol):
    """Pulls a virtual coupon in the direction that identifies `family`, with all families at work.

    Returns fabric engineering stress (n,), MPa, at rising engineering strains (n,), measured as the coupon's were.
    """

    def __call__(self, family: str, laws: Mapping[str, PowerLaw], strain: Array) -> Array:
        """Return the stress of the virtual coupon."""
        ...


@dataclass(frozen=True)
class TargetCurve:
    """Curve a simulated coupon shall return: engineering strain (n,) and fabric stress (n,) in MPa; A_n / A_0."""

    strain: Array
    stress: Array
    area_ratio: float


@dataclass(frozen=True)
class Refined:
    """Refined laws, and per family the relative departure (n,) of the simulated from the target curve.

    `before`: with the laws of the direct identification, that is how far the direct use of the curve was off, over the
    strains of the target; `after`: with the refined laws. `misfit`: largest root mean square of `after`, in stress
    relative to the target's.
    """

    laws: dict[str, PowerLaw]
    before: dict[str, Array]
    after: dict[str, Array]
    rounds: int
    misfit: float
    converged: bool


def target_of(law: PowerLaw, area_ratio: float, strain_max: float, *, points: int = 40) -> TargetCurve:
    """Return the smooth curve of an identified law up to `strain_max`, which stands for the measured ones."""
    strain = np.linspace(0.0, strain_max, points + 1)[1:]
    return TargetCurve(strain, loading_curve(law, np.log1p(strain)).stress / area_ratio, area_ratio)


def refine(
    laws: Mapping[str, PowerLaw],
    targets: Mapping[str, TargetCurve],
    simulate: CouponSimulator,
    *,
    rounds: int = ROUNDS,
    tolerance: float = TOLERANCE,
) -> Refined:
    """Adjust H and n of the families with a target until the simulated coupons return the targets.

    Ends when no misfit changes by more than `tolerance` any more; `converged` is False when `rounds` ran out.
    """
    now = dict(laws)
    simulated = _simulate(now, targets, simulate)
    before = _departure(simulated, targets)
    best, best_misfit, done, converged = (now, simulated), _misfit(simulated, targets), 0, False
    while done < rounds and not converged:
        done += 1
        now = {**now, **{family: _corrected(now[family], targets[family], simulated[family]) for family in targets}}
        simulated = _simulate(now, targets, simulate)
        misfit = _misfit(simulated, targets)
        change = best_misfit - misfit
        if change > 0.0:
            best, best_misfit = (now, simulated), misfit
        converged = abs(change) < tolerance
    return Refined(best[0], before, _departure(best[1], targets), done, best_misfit, converged)


def _simulate(
    laws: Mapping[str, PowerLaw], targets: Mapping[str, TargetCurve], simulate: CouponSimulator
) -> dict[str, Array]:
    return {family: np.asarray(simulate(family, laws, target.strain), float) for family, target in targets.items()}


def _departure(simulated: Mapping[str, Array], targets: Mapping[str, TargetCurve]) -> dict[str, Array]:
    """Return simulated over target, minus one."""
    return {family: simulated[family] / target.stress - 1.0 for family, target in targets.items()}


def _misfit(simulated: Mapping[str, Array], targets: Mapping[str, TargetCurve]) -> float:
    """Return the largest relative root mean square difference over the families."""
    return max(
        float(np.linalg.norm(simulated[family] - target.stress) / np.linalg.norm(target.stress))
        for family, target in targets.items()
    )


def _corrected(law: PowerLaw, target: TargetCurve, simulated: Array) -> PowerLaw:
    """Return the law whose own curve is multiplied by target / simulated, in the least-squares sense."""
    hencky = np.log1p(target.strain)
    factor = np.clip(target.stress / np.maximum(simulated, 1e-12), 1.0 / MAX_FACTOR, MAX_FACTOR)
    return solve(law, CurveData(hencky, loading_curve(law, hencky).stress * factor, 0.0)).law
