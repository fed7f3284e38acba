"""What scatters from sample to sample: inputs with their distributions, and the scatter of fabric laws.

Every ensemble draws the same columns in the same order (`COLUMNS`), whether an input is used or not: two designs with
the same seed see the same random numbers, and an input that is switched off leaves the others as they are. Numbers that
belong to single loops are drawn apart (`etextile.ensemble.sample.local_normal`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.special import ndtr, ndtri

from etextile.types import Array
from etextile.vocabulary import FABRIC_FAMILIES


PARAMETERS = ("E", "H", "n")
COLUMNS = (
    *(f"{family}_{number}" for family in FABRIC_FAMILIES for number in range(1, len(PARAMETERS) + 1)),
    "strength",
    "mounting",
    "wire_offset",
    "loop_offset",
    "punch_x",
    "punch_y",
    "tilt_x",
    "tilt_y",
    "tilt_z",
)
REACH = 3.0
"""Standard deviations at which normal distributions are cut off."""


@dataclass(frozen=True)
class Input:
    """A number that scatters normally about 0 with `std`, cut off at `reach` standard deviations.

    `unit` is that of `std`; `origin` says where the standard deviation comes from.
    """

    name: str
    label: str
    unit: str
    std: float
    origin: str
    reach: float = REACH

    @property
    def distribution(self) -> str:
        """The distribution in words."""
        unit = f" {self.unit}" if self.unit else ""
        return f"normal, standard deviation {self.std:g}{unit}, cut off at {self.reach * self.std:.3g}{unit}"

    def value(self, row: Mapping[str, float]) -> float:
        """Return the deviation of a sample from its unit numbers by column."""
        return self.std * normal(row[self.name], self.reach)


class FamilyScatter(Protocol):
    """Scatter of the law of one truss family."""

    @property
    def distribution(self) -> str:
        """The distribution in words."""

    def factors(self, units: Sequence[float]) -> dict[str, float]:
        """Return factors on E, H and n from three unit numbers."""


@dataclass(frozen=True)
class SpanScatter:
    """Laws between a low and a high estimate: ln E, ln H and ln n move together, piecewise linearly over t.

    low, high (3,): E, H and n of the estimates over those in the middle; t = -1 is low, 0 the middle, 1 high. t is
    normal with standard deviation width / 2, cut off at +-width: the estimates are taken as two standard deviations.
    """

    low: Array
    high: Array
    width: float = 1.0

    @property
    def distribution(self) -> str:
        """The distribution in words."""
        return "from low over middle to high estimate, ln E, ln H and ln n together, normal, ends at 2 deviations"

    def factors(self, units: Sequence[float]) -> dict[str, float]:
        """Return factors on E, H and n; only the first unit number counts."""
        t = 0.5 * self.width * normal(units[0], 2.0)
        ratio = np.exp(abs(t) * np.log(self.high if t > 0.0 else self.low))
        return dict(zip(PARAMETERS, ratio.tolist(), strict=True))


@dataclass(frozen=True)
class CovarianceScatter:
    """Jointly normal ln E, ln H and n: values (3,) of E, H, n and their covariance (3, 3), zero where they are known.

    The covariance is in the parameters' own units; that of the logarithms is it over the products of the values.
    """

    values: Array
    covariance: Array

    @property
    def distribution(self) -> str:
        """The distribution in words."""
        spread = 100.0 * np.sqrt(np.diag(self.covariance)) / self.values
        parts = (f"{name} {value:.3g} %" for name, value in zip(PARAMETERS, spread, strict=True) if value > 0.0)
        return (
            f"jointly normal from the covariance of the fabric file, standard deviations {', '.join(parts) or 'none'}"
        )

    def factors(self, units: Sequence[float]) -> dict[str, float]:
        """Return factors on E, H and n."""
        scale = np.array([1.0 / self.values[0], 1.0 / self.values[1], 1.0])
        shift = root(self.covariance * np.outer(scale, scale)) @ [normal(unit, REACH) for unit in units]
        n = max((self.values[2] + shift[2]) / self.values[2], 0.1)
        return {"E": float(np.exp(shift[0])), "H": float(np.exp(shift[1])), "n": float(n)}


def normal(unit: float, reach: float) -> float:
    """Return the quantile of the standard normal distribution cut off at +-reach at a unit number in [0, 1]."""
    low = ndtr(-reach)
    return float(np.clip(ndtri(low + unit * (1.0 - 2.0 * low)), -reach, reach))


def root(covariance: Array) -> Array:
    """Return the symmetric square root of a covariance; rounding below zero is taken as zero."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T)
