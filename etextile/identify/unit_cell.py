r"""The unit cell in uniaxial tension at any angle to the warp: what a long strip of lattice does away from its clamps.

Between the single truss of the direct identification and the whole coupon stands the homogeneous cell (Beex et al.,
section 4.4, figure 12). With the deformation gradient F = [[1 + e, g], [0, h]] it narrows (h) and shears (g) freely:

    P = sum_f (A_0 / A_n)_f tau_f / lambda_f^2 (F t_f) (x) t_f,    P_xy = P_yy = 0,    stress = P_xx,

the sum running over warp, weft and both diagonals with unit directions t_f, stretches lambda_f = |F t_f| and
tau_f = sigma_f exp(eps_e) of the law.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.errors import NoEquilibrium
from etextile.lattice.weave import DIAGONAL, WARP, WEFT, Weave
from etextile.laws.powerlaw import PowerLaw, respond
from etextile.types import Array


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
    from scipy.optimize import root

    directions = _directions(weave, angle)
    rows = np.array([law.row() for law in laws])[_FAMILY]
    density = (weave.truss_area / np.array(weave.nominal_area))[_FAMILY]
    scale = float(np.max(density * rows[:, 0]))
    plastic, free = np.zeros(4), np.array([0.0, 1.0])
    found = []
    for value in np.asarray(strain, dtype=np.float64):

        def residual(unknown: Array, now: float = float(value), before: Array = plastic) -> tuple[Array, Array]:
            response = _respond(_gradient(now, unknown), directions, rows, density, before)
            return response.across / scale, response.tangent / scale

        answer = root(residual, free, jac=True, method="hybr", options={"xtol": 1e-13})
        if float(np.linalg.norm(answer.fun)) > 1e-9:
            raise NoEquilibrium(f"the unit cell at {angle:g} deg finds no equilibrium at a strain of {value:.4g}")
        free = answer.x
        response = _respond(_gradient(float(value), free), directions, rows, density, plastic)
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
