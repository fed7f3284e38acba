r"""The unit cell in uniaxial tension at any angle to the warp: what a long strip of lattice does away from its clamps.

Between the single truss of the direct identification and the whole coupon stands the homogeneous cell (Beex et al.,
section 4.4, figure 12). With the deformation gradient F = [[1 + e, g], [0, h]] it narrows (h) and shears (g) freely:

    P = sum_f (A_0 / A_n)_f tau_f / lambda_f^2 (F t_f) (x) t_f,    P_xy = P_yy = 0,    stress = P_xx,

the sum running over warp, weft and both diagonals with unit directions t_f, stretches lambda_f = |F t_f| and
tau_f = sigma_f exp(eps_e) of the law.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from etextile.errors import NoEquilibrium
from etextile.lattice.weave import DIAGONAL, WARP, WEFT, Weave
from etextile.laws.powerlaw import PowerLaw, respond
from etextile.types import Array


TOLERANCE, LEAST_STIFFNESS, MAX_STEP, MAX_ITERATIONS = 1e-11, 1e-10, 0.05, 200
"""Residual and least stiffness over the largest E; largest change of g and h in an iteration; iterations."""
_FAMILY = np.array([WARP, WEFT, DIAGONAL, DIAGONAL])


@dataclass(frozen=True)
class CellCurve:
    """Response (n,) of the unit cell: fabric stress (MPa), width over its first value, shear g, and the share (n, 4) of
    the stress that warp, weft and the two diagonals carry along the load, MPa.
    """

    stress: Array
    width: Array
    shear: Array
    carried: Array


def unit_cell_curve(weave: Weave, laws: Sequence[PowerLaw], *, angle: float, strain: Array) -> CellCurve:
    """Return the response of the cell at rising engineering strains (n,), with the warp at `angle` degrees to the load.

    Plastic strain is carried from strain to strain. Raises NoEquilibrium when a step finds none.
    """
    directions = _directions(weave, angle)
    rows = np.array([law.row() for law in laws])[_FAMILY]
    density = (weave.truss_area / np.array(weave.nominal_area))[_FAMILY]
    scale = float(np.max(density * rows[:, 0]))
    plastic, free = np.zeros(4), np.array([0.0, 1.0])
    found = []
    for value in np.asarray(strain, dtype=np.float64):

        def at(unknown: Array, now: float = float(value), before: Array = plastic) -> _Response:
            return _respond(_gradient(now, unknown), directions, rows, density, before)

        solution = _equilibrium(at, free, scale)
        if solution is None:
            raise NoEquilibrium(f"the unit cell at {angle:g} deg finds no equilibrium at a strain of {value:.4g}")
        free = solution
        response = at(free)
        plastic = response.plastic
        found.append((response.carried, free))
    carried, free_parts = (np.array([item[k] for item in found]) for k in (0, 1))
    return CellCurve(carried.sum(axis=1), free_parts[:, 1], free_parts[:, 0], carried)


@dataclass(frozen=True)
class _Response:
    """Stress along the load by family (4,), residual (P_xy, P_yy), its derivative (2, 2) by (g, h), plastic strains."""

    carried: Array
    across: Array
    tangent: Array
    plastic: Array


def _equilibrium(at: Callable[[Array], _Response], start: Array, scale: float) -> Array | None:
    """Return (g, h) at which the cell pulls along the load only, by Newton with halved steps; None if not found."""
    free, response = start, at(start)
    for _ in range(MAX_ITERATIONS):
        size = float(np.linalg.norm(response.across))
        if size <= TOLERANCE * scale:
            return free
        step = -np.linalg.solve(response.tangent + LEAST_STIFFNESS * scale * np.eye(2), response.across)
        length = min(1.0, MAX_STEP / float(np.abs(step).max()))
        trial = at(free + length * step)
        while float(np.linalg.norm(trial.across)) > size and length > 1e-6:
            length *= 0.5
            trial = at(free + length * step)
        free, response = free + length * step, trial
    return None


def _directions(weave: Weave, angle: float) -> Array:
    """Return the unit directions (4, 2) of warp, weft and the two diagonals; the load is along x."""
    tilt = np.arctan2(weave.cell_weft, weave.cell_warp)
    turned = np.radians(angle) + np.array([0.0, 0.5 * np.pi, tilt, -tilt])
    return np.stack([np.cos(turned), np.sin(turned)], axis=1)


def _gradient(strain: float, free: Array) -> Array:
    return np.array([[1.0 + strain, free[0]], [0.0, free[1]]])


def _respond(gradient: Array, directions: Array, rows: Array, density: Array, before: Array) -> _Response:
    """Evaluate the four families at a deformation gradient (2, 2) from plastic strains `before` (4,)."""
    now = directions @ gradient.T
    stretch = np.linalg.norm(now, axis=1)
    law = np.array([respond(rows[k], np.log(stretch[k]), before[k]) for k in range(4)])
    tau, slope, plastic = law.T
    pull = density * tau / stretch**2
    along_y = directions[:, 1]
    stiffness = density * (slope - 2.0 * tau) / stretch**4 * along_y**2
    tangent = np.einsum("f,fi,fj->ij", stiffness, now, now) + np.sum(pull * along_y**2) * np.eye(2)
    return _Response(pull * now[:, 0] * directions[:, 0], (pull * along_y) @ now, tangent, plastic)
