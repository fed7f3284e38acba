"""Modulus from loading and unloading of one specimen together, where the law describes the loading within its noise.

The line through the top of unloading then starts on the fitted loading curve, which all its points support: the standard
deviation of E falls by a quarter. Where the law does not describe the loading this well, its misfit would end up in E;
the modulus from the unloading alone stays.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from etextile.identify.hardening import fit_hardening
from etextile.identify.least_squares import CurveData, solve
from etextile.identify.modulus import ModulusFit
from etextile.identify.segments import Segments
from etextile.identify.statistics import autocorrelation_factor

# Limits on the residuals of loading: autocorrelation factor, and variance over that of the noise.
MAX_CORRELATION = 2.0
MAX_MISFIT = 2.0


def refit_modulus(modulus: ModulusFit, segments: Segments, area_ratio: float, *, sigma_y0: float) -> ModulusFit:
    """Return the modulus of the joint fit, or `modulus` when law or unloading do not fit the loading."""
    first = fit_hardening(segments, area_ratio, E=modulus.E, sigma_y0=sigma_y0)
    noise = segments.noise**2
    misfit = float(np.mean(first.residuals**2))
    if modulus.notes or autocorrelation_factor(first.residuals) > MAX_CORRELATION or misfit > MAX_MISFIT * noise:
        return modulus
    data = CurveData(
        np.log1p(segments.strain), segments.stress * area_ratio, segments.noise * area_ratio,
        modulus.turning, modulus.hencky, modulus.stress,
    )  # fmt: skip
    joint = solve(first.law, data, free_modulus=True, free_datum=first.datum != 0.0, datum=first.datum)
    slope = joint.law.E / modulus.plastic_stretch
    return replace(modulus, E=joint.law.E, variance=float(joint.covariance[0, 0]), line=(modulus.line[0], slope))
