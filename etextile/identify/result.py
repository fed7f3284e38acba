"""What identification hands on: a fabric's three truss families with uncertainty, range of validity and residuals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from etextile.errors import BadInput, Problem
from etextile.identify.curves import TensileCurve
from etextile.identify.fit import SIGMA_Y0, DirectionFit, NamedLaw, fit_direction
from etextile.identify.modulus import Procedure
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


# Direction of the coupon to the truss family it identifies: the bias curve is used for the diagonals as it is.
FAMILY_OF = {"warp": "warp", "weft": "weft", "bias": "diagonal"}
DIRECTION_OF = {family: direction for direction, family in FAMILY_OF.items()}
PARAMETERS = ("E", "H", "n")
NORMAL_95 = 1.959964


@dataclass(frozen=True)
class Estimate:
    """A parameter with its standard deviation and 95 % interval; `std` None when it was not identified."""

    value: float
    std: float | None
    low: float | None
    high: float | None


@dataclass(frozen=True)
class IdentifiedFamily:
    """One truss family by the procedure asked for (`fit`) and by the paper's procedure (`paper`), A_n / A_0 beside."""

    family: str
    area_ratio: float
    fit: DirectionFit
    paper: DirectionFit | None

    @property
    def law(self) -> PowerLaw:
        """Mean law over the specimens."""
        return self.fit.law

    @property
    def modulus_identified(self) -> bool:
        """Tell whether E comes from unloading."""
        return not self.fit.modulus_source

    @property
    def estimates(self) -> dict[str, Estimate]:
        """E, H and n with standard deviation and 95 % interval (E and H: of their logarithms)."""
        deviation = np.sqrt(np.diag(self.fit.covariance))
        values = np.array([self.law.E, self.law.H, self.law.n])
        found = {}
        for j, name in enumerate(PARAMETERS):
            reach = NORMAL_95 * float(deviation[j])
            value = float(values[j])
            low, high = (
                (value - reach, value + reach) if name == "n" else (value * np.exp(-reach), value * np.exp(reach))
            )
            std = float(deviation[j]) * (1.0 if name == "n" else value)
            found[name] = Estimate(value, std, float(low), float(high))
        if not self.modulus_identified:
            found["E"] = Estimate(self.law.E, None, None, None)
        return found

    @property
    def covariance(self) -> Array:
        """Covariance (3, 3) of the mean (E, H, n), in their own units."""
        return self._in_units(self.fit.covariance)

    @property
    def between_specimens(self) -> Array | None:
        """Covariance (3, 3) of (E, H, n) from one specimen to the next, in their own units; None for one specimen."""
        return None if self.fit.between is None else self._in_units(self.fit.between)

    def _in_units(self, covariance: Array) -> Array:
        scale = np.array([self.law.E, self.law.H, 1.0])
        return np.asarray(scale[:, None] * covariance * scale[None, :])


@dataclass(frozen=True)
class IdentifiedFabric:
    """The families that were measured; `weave` is the geometry they were identified for."""

    weave: Weave
    procedure: Procedure
    families: dict[str, IdentifiedFamily]


def area_ratios(weave: Weave) -> dict[str, float]:
    """Return A_n / A_0 per family (paper, equation 5)."""
    return {family: area / weave.truss_area for family, area in zip(DIRECTION_OF, weave.nominal_area, strict=True)}


def identify_fabric(
    curves: Mapping[str, Sequence[TensileCurve]],
    weave: Weave,
    *,
    named: Mapping[str, NamedLaw],
    procedure: Procedure = "consistent",
    sigma_y0: float = SIGMA_Y0,
    keep_outliers: bool = False,
) -> IdentifiedFabric:
    """Identify the families whose directions ('warp', 'weft', 'bias') have curves.

    `named`: law per family from which E is taken when no specimen of a direction unloads. Raises BadInput with the
    problems of all directions.
    """
    if not any(curves.values()):
        raise BadInput.of("no tensile curves: at least one of warp, weft and bias is needed")
    ratios, families, problems = area_ratios(weave), {}, list(_thickness_problems(curves, weave))
    for direction in (name for name in FAMILY_OF if curves.get(name)):
        family = FAMILY_OF[direction]
        try:
            fit, paper = (
                fit_direction(
                    curves[direction], ratios[family], named=named.get(family), procedure=way, sigma_y0=sigma_y0,
                    keep_outliers=keep_outliers,
                )
                for way in (procedure, "paper")
            )  # fmt: skip
        except BadInput as error:
            problems.extend(error.problems)
            continue
        families[family] = IdentifiedFamily(family, ratios[family], fit, None if procedure == "paper" else paper)
    if problems:
        raise BadInput(problems)
    return IdentifiedFabric(weave, procedure, families)


def _thickness_problems(curves: Mapping[str, Sequence[TensileCurve]], weave: Weave) -> list[Problem]:
    """Return the curves whose stress refers to another thickness than the fabric's."""
    problems = []
    for curve in (curve for specimens in curves.values() for curve in specimens):
        if curve.thickness is not None and abs(curve.thickness / weave.thickness - 1.0) > 1e-3:
            message = (
                f"thickness {curve.thickness:g} mm differs from the fabric's {weave.thickness:g} mm: stress would refer"
                " to another cross-section; name the fabric of the coupons (--fabric) or correct the thickness"
            )
            problems.append(Problem(message, curve.file, key="thickness"))
    return problems
