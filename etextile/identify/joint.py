"""Modulus and hardening from loading and unloading of one specimen together, where the law describes the loading.

The line through the top of unloading then starts on the fitted loading curve, which all its points support: the
standard deviation of E falls by a quarter. Where the law does not describe the loading within its noise, its misfit
would end up in E; the modulus from the unloading alone stays.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from etextile.identify.hardening import HardeningFit
from etextile.identify.least_squares import CurveData, solve
from etextile.identify.modulus import ModulusFit
from etextile.identify.segments import Segments
from etextile.identify.statistics import is_noise
from etextile.types import Array


def describes(hardening: HardeningFit, segments: Segments) -> bool:
    """Tell whether the residuals of loading look like the noise of the curve."""
    return is_noise(hardening.residuals, segments.noise)


def fit_jointly(
    modulus: ModulusFit, hardening: HardeningFit, segments: Segments, *, area_ratio: float
) -> tuple[ModulusFit, HardeningFit, Array]:
    """Return modulus, hardening and the covariance (3, 3) of (ln E, ln H, n) from both parts of the curve."""
    data = CurveData(
        np.log1p(segments.strain), segments.stress * area_ratio, segments.noise * area_ratio,
        modulus.turning, modulus.hencky, modulus.stress, hardening.zeroed,
    )  # fmt: skip
    shifted = hardening.datum != 0.0
    joint = solve(
        hardening.law,
        data,
        free_modulus=True,
        free_datum=shifted,
        datum=hardening.datum,
        over=hardening.over,
    )
    slope = joint.law.E / modulus.plastic_stretch
    return (
        replace(modulus, E=joint.law.E, variance=float(joint.covariance[0, 0]), line=(modulus.line[0], slope)),
        replace(
            hardening, law=joint.law, covariance=joint.covariance[1:3, 1:3], datum=joint.datum, over=joint.over,
            residuals=joint.residuals / area_ratio,
        ),
        joint.covariance[:3, :3],
    )  # fmt: skip
