"""How a wire breaks along its length: weakest link, Weibull scatter, and the filaments that follow the first one.

A piece of wire is strained by e over the length l. Its weakest place loses the first filament at the strain x e0, with

    P(x <= r) = 1 - exp(-ln 2 r^m),

so e0 is the median of a piece of the reference length l0. A piece of n = (l / l0)^a links has the median e0 n^(-1/m):
everything depends on the one ratio

    rho = (e / e0) n^(1 / m).

With the exponent a = 1 this is the plain weakest link (Peirce, J. Text. Inst. 17 (1926) T355; Weibull, J. Appl. Mech.
18 (1951) 293). Published lives of yarns contradict it: they fall with the length to the power 1.14, where a Weibull
shape of about 2 of the lives would give 1 / 2, that is an exponent a of 2.28. It is a parameter for that reason.

From the first break on the filaments at that place break one after the other, each with the probability

    share = 1 - exp(-((e / (x e0) - 1) / c)^b),

and the wire is open when all N are broken. Both are integrated over the scatter of x once and tabulated over ln rho.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from etextile.types import Array


LN2 = float(np.log(2.0))
_LOW, _HIGH, _POINTS = -2.0, 4.0, 4001
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(160)


@dataclass(frozen=True)
class BreakLaw:
    """Weibull shape m of a place's first break, width c and exponent b of what follows, number of filaments N."""

    shape: float
    width: float
    growth: float
    filaments: int

    def broken(self, ratio: Array) -> Array:
        """Return the probability (...) that a filament is broken, at ratios rho (...)."""
        with np.errstate(over="ignore"):
            return np.asarray(-np.expm1(-LN2 * np.maximum(ratio, 0.0) ** self.shape))

    def opened(self, ratio: Array) -> Array:
        """Return the probability (...) that all filaments of the weakest place are broken."""
        return self._interpolated(ratio, 1)

    def share(self, ratio: Array) -> Array:
        """Return the expected share (...) of the filaments of the weakest place that is broken."""
        return self._interpolated(ratio, 2)

    def _interpolated(self, ratio: Array, column: int) -> Array:
        table = _table(self.shape, self.width, self.growth, self.filaments)
        with np.errstate(divide="ignore"):
            place = np.log(np.maximum(ratio, 0.0))
        return np.interp(place, table[0], table[column], left=0.0)


@lru_cache(maxsize=32)
def _table(shape: float, width: float, growth: float, filaments: int) -> tuple[Array, Array, Array]:
    """Return ln rho (n,), probability of an open place and expected share (n,), by quadrature over the first break."""
    places = np.linspace(_LOW, _HIGH, _POINTS)
    ratio = np.exp(places)
    with np.errstate(over="ignore"):
        broken = -np.expm1(-LN2 * ratio**shape)
    t = 0.5 * (1.0 + _NODES)
    weight = 0.5 * _WEIGHTS * 2.0 * t  # u = broken t^2 resolves the early breaks, from which most filaments follow
    u = np.minimum(broken[:, None] * t**2, 1.0 - 1e-16)
    first = (-np.log1p(-u) / LN2) ** (1.0 / shape)
    share = -np.expm1(-((np.maximum(ratio[:, None] / first - 1.0, 0.0) / width) ** growth))
    return places, broken * ((share**filaments) @ weight), broken * (share @ weight)


def links(length_mm: Array, reference_mm: float, exponent: float) -> Array:
    """Return the number of links n = (l / l0)^a (n,) of pieces of wire."""
    return np.asarray((np.asarray(length_mm, dtype=float) / reference_mm) ** exponent)


def on_gauge(elongation: float, *, measured_mm: float, gauge_mm: float, shape: float, exponent: float = 1.0) -> float:
    """Return the elongation at break over `gauge_mm` of wire whose elongation was measured over `measured_mm`.

    e (measured / gauge)^(a / m): a longer piece breaks earlier.
    """
    return float(elongation * (measured_mm / gauge_mm) ** (exponent / shape))
