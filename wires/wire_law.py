"""The power law of `etextile.laws.powerlaw` for wires that slide, without its force peak.

A wire that can slide and whose force falls with length would neck: one element gives its content away until it is
empty. Up to the plastic strain p1 where the force begins to fall, s' = s (0.4 for soft copper, which breaks long
before), the law is the lattice's own; from there on the yield stress grows as exp((1 + m) (p - p1)), so that the
force keeps rising a little and the energy of a sliding wire stays convex.
"""

from __future__ import annotations

import math

import numpy as np

from etextile.compiled import njit
from etextile.laws.powerlaw import E0, GAUSS_POINTS, GAUSS_WEIGHTS, SY0, E, H, N, PowerLaw
from etextile.types import Array


MARGIN = 0.05
COLUMNS = 7
_P1, _S1 = 5, 6
# Columns of the row: E, sigma_y0, H, n, e0 as below, then the plastic strain and the stress where the tail begins.
_E, _SY0, _H, _N, _E0 = range(5)


def law_row(law: PowerLaw) -> Array:
    """Return the parameters (COLUMNS,) of a law for the compiled functions below."""
    table = law.row()
    row = np.zeros(COLUMNS)
    row[:5] = table[[E, SY0, H, N, E0]]
    row[_P1] = np.inf
    grid = np.geomspace(1e-4, 20.0, 4001)
    stress, slope = np.array([wire_yield(row, p) for p in grid]).T
    falls = np.flatnonzero(slope < (1.0 + MARGIN) * stress)
    p1 = float(grid[falls[0]]) if falls.size else np.inf
    row[_S1] = wire_yield(row, p1)[0] if falls.size else 0.0
    row[_P1] = p1
    return row


@njit
def wire_yield(c, p):  # type: ignore[no-untyped-def]
    """Return yield stress and its slope at plastic strain p."""
    if p > c[_P1]:
        s = c[_S1] * math.exp((1.0 + MARGIN) * (p - c[_P1]))
        return s, (1.0 + MARGIN) * s
    power = c[_H] * p ** c[_N]
    s = c[_SY0] * p / (p + c[_E0]) + power
    slope = c[_SY0] * c[_E0] / (p + c[_E0]) ** 2
    if p > 0.0:
        slope += c[_N] * power / p
    elif c[_N] < 1.0:
        slope = np.inf
    elif c[_N] == 1.0:
        slope += c[_H]
    return s, slope


@njit
def wire_plastic_strain(c, eps, p_old):  # type: ignore[no-untyped-def]
    """Return p with E (eps - p) = s(p) for eps beyond yield: Newton kept inside a shrinking bracket."""
    low, high = p_old, eps
    p = p_old if p_old > 0.0 else 0.5 * eps
    for _ in range(100):
        s, slope = wire_yield(c, p)
        f = p + s / c[_E] - eps
        if f > 0.0:
            high = p
        else:
            low = p
        new = p - f / (1.0 + slope / c[_E])
        if not (low <= new <= high):
            new = 0.5 * (low + high)
        if abs(new - p) <= 1e-15 + 1e-14 * eps:
            return new
        p = new
    return p


@njit
def wire_respond(c, eps, p_old):  # type: ignore[no-untyped-def]
    """Return (tau, d tau / d eps, eps_p, stored, dissipated) at Hencky strain eps, per virgin volume.

    tau = dw/d eps; dissipated counts from p_old on. A slack wire has none of them.
    """
    e = eps - p_old
    if e <= 0.0:
        return 0.0, 0.0, p_old, 0.0, 0.0
    s, slope = wire_yield(c, p_old)
    if c[_E] * e <= s:
        grow = math.exp(e)
        return c[_E] * e * grow, c[_E] * (1.0 + e) * grow, p_old, c[_E] * ((e - 1.0) * grow + 1.0), 0.0
    p = wire_plastic_strain(c, eps, p_old)
    e = eps - p
    s, slope = wire_yield(c, p)
    flow = 1.0 / (1.0 + slope / c[_E])
    grow = math.exp(e)
    tangent = grow * (c[_E] * (1.0 - flow) + s * (1.0 - flow))
    return s * grow, tangent, p, c[_E] * ((e - 1.0) * grow + 1.0), wire_dissipation(c, p_old, p)


@njit
def wire_dissipation(c, start, stop):  # type: ignore[no-untyped-def]
    """Return the energy dissipated from plastic strain start to stop, the integral of s exp(s / E).

    Gauss quadrature in sqrt(p), which smooths the power law at zero, split where the law bends.
    """
    total = 0.0
    while start < stop:
        end = stop
        for kink in (4.0 * c[_E0], c[_P1]):
            if start < kink < end:
                end = kink
        a, b = math.sqrt(start), math.sqrt(end)
        for k in range(GAUSS_POINTS.shape[0]):
            t = a + (b - a) * GAUSS_POINTS[k]
            s = wire_yield(c, t * t)[0]
            total += (b - a) * GAUSS_WEIGHTS[k] * 2.0 * t * s * math.exp(s / c[_E])
        start = end
    return total
