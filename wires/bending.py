"""Bending where a wire leaves and re-enters the weave: why filaments break at the clearances and nowhere else.

A loop with excess length stands as a shallow arc, so the wire turns by an angle phi at its exit and entry, over about
one cell of the weave. A filament of diameter d bent to the radius rho is strained by d / (2 rho) at its outer fibre
(Euler-Bernoulli; Gere and Timoshenko, Mechanics of Materials, section 5.4; the measure of bending tests of copper,
IPC-TM-650 2.4.3.2). Filaments of a twisted wire can slide on each other, so d is the filament's, not the wire's. The
woven-in wire, equally stretched, has no such turn. Ductility spent in bending is not available for stretching: the two
strains are added, which raises the strain at the exit by the factor 1 + d / (2 rho e) over the wire's strain e.
"""

from __future__ import annotations

import numpy as np

from etextile.types import Array


CELL_MM = 0.2849
"""Cell of the paper's weave along the warp, mm: the shortest length over which the wire can turn out of it."""


def exit_angle(slack: Array) -> Array:
    """Return the angle phi (rad) between fabric and wire at the ends of circular arcs with excess `slack` (n,).

    phi / sin(phi) = 1 + slack, so phi is about sqrt(6 slack); Newton from there. At most a half circle.
    """
    excess = np.clip(np.asarray(slack, dtype=float), 0.0, 0.5 * np.pi - 1.0)
    angle = np.sqrt(6.0 * excess / (1.0 + 0.3 * excess))
    for _ in range(8):
        safe = np.where(angle > 1e-6, angle, 1.0)
        gap = safe / np.sin(safe) - 1.0 - excess
        slope = (np.sin(safe) - safe * np.cos(safe)) / np.sin(safe) ** 2
        angle = np.where(angle > 1e-6, np.minimum(safe - gap / slope, 0.5 * np.pi), angle)
    return np.asarray(angle)


def exit_strain(slack: Array, *, filament_diameter_mm: float, turn_mm: float = CELL_MM) -> Array:
    """Return the bending strain d / (2 rho) (n,) at the exits of loops, rho = turn_mm / phi."""
    return np.asarray(0.5 * filament_diameter_mm * exit_angle(slack) / turn_mm)


def stress_raiser(strain: Array, bending: Array) -> Array:
    """Return the factor (strain + bending) / strain by which bending raises the strain; 1 for an unstrained wire."""
    safe = np.where(strain > 0.0, strain, 1.0)
    return np.where(strain > 0.0, 1.0 + bending / safe, 1.0)
