r"""Elastoplastic tension-only truss law with power-law hardening, as an incremental energy.

Hencky strain eps = ln(l / l0) = eps_e + eps_p, true stress sigma = (1 - d) E eps_e, yield stress

    s(eps_p) = sigma_y0 eps_p / (eps_p + e0) + H eps_p^n                       (paper, section 3)

plastic flow keeps volume, so the force is F = sigma A0 exp(-eps_p); a compressed truss has buckled and carries nothing
(or, where `compression_ratio` is given, that share of what it carries in tension at the same size of Hencky strain, on
the curve with E (eps - p) = s(p), mirrored and without loss).
With psi(eps_e) = E ((eps_e - 1) exp(eps_e) + 1) the energy per initial volume

    W(eps, eps_p) = (1 - d(eps_p)) psi(eps - eps_p) + D(eps_p),   D' = (1 - d) s exp(s / E) + d' psi(s / E)

gives F = dW/dl exactly, and minimising W over eps_p >= its last value gives the yield condition sigma = (1 - d) s
exactly; so energy, force and tangent are consistent and D is the plastic (and damage) dissipation.

Beyond the plain law, columns of the parameter table hold what effects may change; zero leaves the law untouched.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from etextile.compiled import njit
from etextile.types import Array


# Columns of the parameter table.
E, SY0, H, N, E0, COMPRESSION, TAIL_ONSET, TAIL_FACTOR, DAMAGE_ONSET, DAMAGE_RATE, TAIL_STRAIGHT = range(11)
COLUMNS = 11

_nodes, _weights = np.polynomial.legendre.leggauss(10)
GAUSS_POINTS = 0.5 * (_nodes + 1.0)
GAUSS_WEIGHTS = 0.5 * _weights


@dataclass(frozen=True)
class PowerLaw:
    """Parameters of one truss family.

    Stresses in MPa, strains are Hencky strains. `compression_ratio`: share of the force at the same strain in tension
    that a compressed truss carries (0: none). `tail_*` and `damage_*` describe effects and are neutral by default:
    yield stress beyond `tail_onset` rises (1 + tail_factor) times as fast, or, with `tail_straight`, (1 + tail_factor)
    times as fast as at the onset, straight on; damage d = 1 - exp(-rate (eps_p - onset)).
    """

    E: float
    sigma_y0: float
    H: float
    n: float
    e0: float = 1e-3
    compression_ratio: float = 0.0
    tail_onset: float = 0.0
    tail_factor: float = 0.0
    damage_onset: float = 0.0
    damage_rate: float = 0.0
    tail_straight: bool = False

    def __post_init__(self) -> None:
        """Refuse parameters without meaning (ValueError)."""
        for name in ("E", "H", "n", "e0"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} must be positive (got {getattr(self, name)})")
        for name in ("sigma_y0", "compression_ratio", "tail_onset", "damage_onset", "damage_rate"):
            if not getattr(self, name) >= 0.0:
                raise ValueError(f"{name} must not be negative (got {getattr(self, name)})")
        if not self.tail_factor >= -1.0:
            raise ValueError(f"tail_factor must be at least -1 (got {self.tail_factor})")

    def scaled(self, factor: float) -> PowerLaw:
        """Return the law with the whole loading curve scaled by `factor` (yield stress and modulus)."""
        return replace(self, E=self.E * factor, sigma_y0=self.sigma_y0 * factor, H=self.H * factor)

    def row(self) -> Array:
        """Return the row of the parameter table, shape (COLUMNS,)."""
        row = np.zeros(COLUMNS)
        row[[E, SY0, H, N, E0, COMPRESSION]] = self.E, self.sigma_y0, self.H, self.n, self.e0, self.compression_ratio
        row[[TAIL_ONSET, TAIL_FACTOR]] = self.tail_onset, self.tail_factor
        row[[DAMAGE_ONSET, DAMAGE_RATE]] = self.damage_onset, self.damage_rate
        row[TAIL_STRAIGHT] = float(self.tail_straight)
        return row

    def loading_curve(self, engineering_strain: Array) -> Array:
        """Return engineering truss stress (MPa, on A0) at rising engineering strains (n,) from the virgin state."""
        stress = np.empty(len(engineering_strain))
        _load(self.row(), np.ascontiguousarray(engineering_strain, dtype=float), stress)
        return stress

    def energy(self, engineering_strain: float) -> float:
        """Return what it takes to strain a virgin truss that far, stored and lost, N mm per mm3 of initial volume."""
        row, eps = self.row(), math.log1p(engineering_strain)
        p = respond(row, eps, 0.0)[2]
        return float(stored_energy(row, eps, p) + dissipated_energy(row, p))


@njit
def yield_stress(c, p):  # type: ignore[no-untyped-def]
    """Return yield stress and its slope at plastic strain p for the parameter row c."""
    power = c[H] * p ** c[N] if p > 0.0 else 0.0
    s = c[SY0] * p / (p + c[E0]) + power
    slope = c[SY0] * c[E0] / (p + c[E0]) ** 2
    if p > 0.0:
        slope += c[N] * power / p
    elif c[N] < 1.0:
        slope = np.inf
    elif c[N] == 1.0:
        slope += c[H]
    if (c[TAIL_FACTOR] != 0.0 or c[TAIL_STRAIGHT] != 0.0) and p > c[TAIL_ONSET]:
        q = c[TAIL_ONSET]
        base = c[SY0] * q / (q + c[E0]) + c[H] * q ** c[N]
        if c[TAIL_STRAIGHT] != 0.0:
            slope = c[SY0] * c[E0] / (q + c[E0]) ** 2 + c[N] * c[H] * q ** (c[N] - 1.0)
            s = base + slope * (p - q)
        s = base + (1.0 + c[TAIL_FACTOR]) * (s - base)
        slope *= 1.0 + c[TAIL_FACTOR]
    return s, slope


@njit
def damage(c, p):  # type: ignore[no-untyped-def]
    """Return damage and its slope at plastic strain p."""
    if c[DAMAGE_RATE] == 0.0 or p <= c[DAMAGE_ONSET]:
        return 0.0, 0.0
    left = math.exp(-c[DAMAGE_RATE] * (p - c[DAMAGE_ONSET]))
    return 1.0 - left, c[DAMAGE_RATE] * left


@njit
def plastic_strain(c, eps, p_old):  # type: ignore[no-untyped-def]
    """Return p with E (eps - p) = s(p) for eps beyond yield."""
    s, slope = yield_stress(c, p_old)
    return flow(c, eps, p_old, s, slope)[0]


@njit
def flow(c, eps, p_old, s, slope):  # type: ignore[no-untyped-def]
    """Return (p, s(p), s'(p)) with E (eps - p) = s(p), given s and s' at p_old: Newton kept in a shrinking bracket.

    It stops when the next step would be below the last digit: steps square from one to the next unless they cross the
    kink of a tail.
    """
    low, high = p_old, eps
    p = p_old
    if p_old <= 0.0:
        p = eps
        s, slope = yield_stress(c, p)
    for _ in range(100):
        f = p + s / c[E] - eps
        if f > 0.0:
            high = p
        else:
            low = p
        new = p - f / (1.0 + slope / c[E])
        inside = low <= new <= high
        if not inside:
            new = 0.5 * (low + high)
        smooth = inside and (c[TAIL_FACTOR] == c[TAIL_STRAIGHT] == 0.0 or (p > c[TAIL_ONSET]) == (new > c[TAIL_ONSET]))
        if abs(new - p) <= (1e-8 if smooth else 1e-15) * new:
            return new, s + slope * (new - p), slope
        p = new
        s, slope = yield_stress(c, p)
    return p, s, slope


@njit
def respond(c, eps, p_old):  # type: ignore[no-untyped-def]
    """Return (tau, d tau / d eps, eps_p) at Hencky strain eps, where tau = F l / (A0 l0) = sigma exp(eps_e).

    With tau the kernel is free of lengths: F = A0 l0 tau / l and dF/dl = A0 l0 (tau' - tau) / l^2.
    """
    e = eps - p_old
    if e <= 0.0:
        return _compressed(c, e, p_old)
    s, slope = yield_stress(c, p_old)
    if c[E] * e > s:
        p, s, slope = flow(c, eps, p_old, s, slope)
        e = eps - p
        d, d_slope = damage(c, p)
        yielding = 1.0 / (1.0 + slope / c[E])
        grow = math.exp(e)
        tau = (1.0 - d) * s * grow
        # d tau / d eps with dp / d eps = yielding and de / d eps = 1 - yielding; (1 - yielding) E = slope yielding
        slope_flow = c[E] * (1.0 - yielding)
        return tau, grow * ((1.0 - d) * (slope_flow + s * (1.0 - yielding)) - d_slope * yielding * s), p
    d, _ = damage(c, p_old)
    grow = math.exp(e)
    return (1.0 - d) * c[E] * e * grow, (1.0 - d) * c[E] * (1.0 + e) * grow, p_old


@njit
def _load(c, engineering_strain, stress):  # type: ignore[no-untyped-def]
    """Fill engineering stresses at rising engineering strains, each from the virgin state."""
    for i in range(engineering_strain.shape[0]):
        eps = math.log1p(engineering_strain[i])
        stress[i] = respond(c, eps, 0.0)[0] * math.exp(-eps)


@njit
def _compressed(c, e, p_old):  # type: ignore[no-untyped-def]
    """Return the slack branch, or the share of the mirrored loading curve where compression is carried (elastically).

    The force is -ratio (1 - d) s exp(-p) on the area A0 exp(-p_old), with E (-e - p) = s(p).
    """
    if c[COMPRESSION] == 0.0:
        return 0.0, 0.0, p_old
    p, s, slope = _loaded(c, -e)
    share = c[COMPRESSION] * (1.0 - damage(c, p_old)[0]) * math.exp(e - p)
    slope_flow = c[E] * slope / (c[E] + slope) if slope < np.inf else c[E]
    yielding = c[E] / (c[E] + slope) if slope < np.inf else 0.0
    return -share * s, share * (slope_flow - s * yielding - s), p_old


@njit
def _loaded(c, eps):  # type: ignore[no-untyped-def]
    """Return (p, s(p), s'(p)) of a virgin truss at a Hencky strain eps >= 0, where E (eps - p) = s(p)."""
    if eps <= 0.0:
        s, slope = yield_stress(c, 0.0)
        return 0.0, s, slope
    s, slope = yield_stress(c, 0.0)
    return flow(c, eps, 0.0, s, slope)


@njit
def stored_energy(c, eps, p):  # type: ignore[no-untyped-def]
    """Return the recoverable energy per initial volume, N mm / mm^3."""
    e = eps - p
    left = 1.0 - damage(c, p)[0]
    if e < 0.0:
        return 0.0 if c[COMPRESSION] == 0.0 else left * c[COMPRESSION] * _compression_energy(c, -e)
    return left * c[E] * ((e - 1.0) * math.exp(e) + 1.0)


@njit
def _compression_energy(c, depth):  # type: ignore[no-untyped-def]
    """Return the integral of s exp(-p - q) over q = p + s(p) / E from 0 to depth, N mm / mm^3 at a ratio of 1.

    Gauss quadrature in sqrt(p), as in `dissipated_energy`, split at the kinks of the yield stress.
    """
    total = 0.0
    start = 0.0
    last = _loaded(c, depth)[0]
    while start < last:
        stop = last
        for kink in (4.0 * c[E0], c[TAIL_ONSET]):
            if start < kink < stop:
                stop = kink
        a, b = math.sqrt(start), math.sqrt(stop)
        for k in range(GAUSS_POINTS.shape[0]):
            t = a + (b - a) * GAUSS_POINTS[k]
            s, slope = yield_stress(c, t * t)
            rate = s * math.exp(-2.0 * t * t - s / c[E]) * (1.0 + slope / c[E])
            total += (b - a) * GAUSS_WEIGHTS[k] * 2.0 * t * rate
        start = stop
    return total


@njit
def _dissipation_rate(c, p):  # type: ignore[no-untyped-def]
    s = yield_stress(c, p)[0]
    d, d_slope = damage(c, p)
    e = s / c[E]
    grow = math.exp(e)
    return (1.0 - d) * s * grow + d_slope * c[E] * ((e - 1.0) * grow + 1.0)


@njit
def dissipated_energy(c, p):  # type: ignore[no-untyped-def]
    """Return the energy per initial volume dissipated on the way from zero plastic strain to p.

    Gauss quadrature in sqrt(p), which smooths the power law at zero, split where effects put kinks.
    """
    total = 0.0
    start = 0.0
    while start < p:
        stop = p
        for kink in (4.0 * c[E0], c[TAIL_ONSET], c[DAMAGE_ONSET]):
            if start < kink < stop:
                stop = kink
        a, b = math.sqrt(start), math.sqrt(stop)
        for k in range(GAUSS_POINTS.shape[0]):
            t = a + (b - a) * GAUSS_POINTS[k]
            total += (b - a) * GAUSS_WEIGHTS[k] * 2.0 * t * _dissipation_rate(c, t * t)
        start = stop
    return total
