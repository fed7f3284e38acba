r"""A curve whose strain and stress were set to zero at a preload: what it has lost.

At a preload of stress s_0 and Hencky strain x_0 a zeroed record shows s(x + x_0) - s(x_0). A power law of n above 1
loses its flat start by that, so that such a curve looks like one of smaller n and larger H, and E, which is taken from
the slope of unloading at a plastic strain, comes out smaller by the plastic strain at x_0. Where the law alone leaves
more than noise and the law with x_0 free leaves no more, the curve is taken so. Elsewhere x_0 is a doubt (`rivals`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from etextile.identify.coupon import D_STRAIN, loading_curve
from etextile.identify.least_squares import CurveData, LawSolution, solve
from etextile.identify.statistics import is_noise
from etextile.identify.toe import is_better
from etextile.types import Array


FIRST = -0.05
"""Datum that the search starts from, as a share of the largest strain."""


def set_to_zero(held: LawSolution, data: CurveData) -> LawSolution:
    """Return the best fit of a curve that was set to zero at a preload; its datum is minus the strain there."""
    return solve(held.law, replace(data, zeroed=True), free_datum=True, datum=FIRST * float(data.hencky[-1]))


def is_seen(found: LawSolution, held: LawSolution, noise: float) -> bool:
    """Tell whether a preload alone explains what the law without one leaves; `noise`: of the truss stress, MPa."""
    return (
        not is_noise(held.residuals, noise)
        and found.datum < 0.0
        and is_better(found, held)
        and is_noise(found.residuals, noise)
    )


def zeroed_note(found: LawSolution, area_ratio: float) -> str:
    """Say what a curve that was set to zero at a preload has lost."""
    stress = float(loading_curve(found.law, np.array([-found.datum])).stress[0]) / area_ratio
    return (
        f"strain and stress were set to zero at a preload: the curve fits the law from a strain of about "
        f"{-found.datum:.2g} and {stress:.2g} MPa on and is taken so; better record from before the preload"
    )


def lost(found: LawSolution) -> tuple[float, float]:
    """Return what ln E gains by the preload of a fit, and by a Hencky strain more there."""
    start = loading_curve(found.law, np.array([max(-found.datum, 0.0)]))
    slope = float(start.plastic_slopes[0, D_STRAIN]) if found.datum < 0.0 else 1.0
    return float(start.plastic_strain[0]), slope


def along(found: LawSolution) -> Array:
    """Return how (ln E, ln H, n) move with the strain at the preload (3,)."""
    covariance = found.covariance
    return np.concatenate([[lost(found)[1]], -covariance[1:3, 3] / covariance[3, 3]])
