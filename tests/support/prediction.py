"""A predicted curve against a measured one: the strain datum that the measured curve itself shows, and the error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.identify.curves import TensileCurve
from etextile.identify.fit import NamedLaw, fit_direction
from etextile.types import Array


FIRST_STRAIN = 0.005
"""Measured strain from which relative errors count: below it they compare a preload with nothing."""


@dataclass(frozen=True)
class Prediction:
    """Measured strain and stress (n,), predicted stress (n,) there, MPa, and the Hencky strain of the datum.

    `mean_error`, `mean_absolute_error`: relative, over strains above 0.5 %; `rms`: root mean square difference over
    that of the measured stress; `at_end`: relative error at the largest strain.
    """

    strain: Array
    measured: Array
    predicted: Array
    datum: float

    @property
    def relative_error(self) -> Array:
        """Predicted over measured, minus one, (n,)."""
        return self.predicted / self.measured - 1.0

    @property
    def mean_error(self) -> float:
        """Mean relative error."""
        return float(self.relative_error[self.strain > FIRST_STRAIN].mean())

    @property
    def mean_absolute_error(self) -> float:
        """Mean of the absolute relative error."""
        return float(np.abs(self.relative_error[self.strain > FIRST_STRAIN]).mean())

    @property
    def rms(self) -> float:
        """Root mean square difference over the root mean square of the measured stress."""
        return float(np.linalg.norm(self.predicted - self.measured) / np.linalg.norm(self.measured))

    @property
    def at_end(self) -> float:
        """Relative error at the largest strain."""
        return float(self.relative_error[-1])


def datum_of(curve: TensileCurve, area_ratio: float, *, named: NamedLaw) -> float:
    """Return the Hencky strain to take off a measured curve: below zero when it starts with a preload.

    It is found from the shape of that curve alone, as in its identification with A_n / A_0 = `area_ratio`; `named`
    lends E when nothing unloads.
    """
    return fit_direction([curve], area_ratio, named=named).specimens[0].hardening.datum


def compare(curve: TensileCurve, strain: Array, stress: Array, *, datum: float) -> Prediction:
    """Return the comparison of a predicted curve (n,) with a measured one, loading only.

    Raises ValueError when the predicted curve ends before the measured one.
    """
    own = np.expm1(np.log1p(curve.strain) - datum)
    if own.max() > strain[-1] * (1.0 + 1e-9):
        raise ValueError(
            f"the predicted curve ends at a strain of {strain[-1]:.4g}, the measured one at {own.max():.4g}"
        )
    from scipy.interpolate import PchipInterpolator

    predicted = PchipInterpolator(np.append(0.0, strain), np.append(0.0, stress))(np.maximum(own, 0.0))
    return Prediction(curve.strain, curve.stress, np.asarray(predicted), datum)
