r"""Pure bending: a piece laid around a cylinder, as a bending tester does it, and the moment that this takes.

Nodes stand on the cylinder of curvature k about the y axis with their distances along x kept: a column of cells h apart
turns by 2 asin(k h / 2), so nothing stretches and what the energy U gains is bending. Per width and length it gives

    M = dU/dk / A

with A the area that turns stand for (free ends do not turn). This is the equilibrium of a uniform strip, so nothing is
solved for; with the turn that `bending_stiffness` measures M is its law whatever the cell.
"""

from __future__ import annotations

import numpy as np

from etextile.errors import BadInput
from etextile.mechanics.model import Model
from etextile.types import Array


LARGEST_TURN = 1.0
"""Curvature times cell beyond which a polygon is no picture of a cylinder."""
STEP = 1e-4
"""Share of the curvature by which positions are differenced."""


def moments(model: Model, curvature: Array) -> tuple[Array, Array]:
    """Return moments (K,) N mm/mm of curvatures (K,) 1/mm > 0, and positions (K, P, 3) mm of the bent piece.

    Raises BadInput for a piece whose nodes are not in columns across it, and for cells too coarse for a curvature.
    """
    columns, cell = _columns(model, float(curvature.max()))
    area = _turning_area(model)
    states = [part.initial_state() for part in model.contributions]
    found = []
    for k in curvature:
        x = around(model.points, columns, cell, k)
        way = around(model.points, columns, cell, k * (1.0 + STEP)) - around(
            model.points, columns, cell, k * (1 - STEP)
        )
        gradient = np.zeros_like(x)
        for part, state in zip(model.contributions, states, strict=True):
            part.respond(x, 0.0, state).add_gradient(gradient)
        found.append(float(np.sum(gradient * way)) / (2.0 * STEP * k * area))
    return np.array(found), np.array([around(model.points, columns, cell, k) for k in curvature])


def around(points: Array, columns: Array, cell: float, curvature: float) -> Array:
    """Return points (P, 3) laid around a cylinder; columns (P,): place along x in cells."""
    turn = 2.0 * np.arcsin(0.5 * curvature * cell)
    angle = turn * columns
    return np.stack([np.sin(angle) / curvature, points[:, 1], points[:, 2] + (1.0 - np.cos(angle)) / curvature], axis=1)


def _columns(model: Model, most: float) -> tuple[Array, float]:
    """Return the place (P,) of every point along x in cells, and the cell (mm)."""
    lines = np.unique(np.round(model.lattice.points[:, 0], 9))
    cells = np.diff(lines)
    if len(lines) < 3 or np.ptp(cells) > 1e-6 * cells.max():
        message = "only a rectangular piece with yarns along its sides is bent around a cylinder"
        raise BadInput.of(f"{message}; set fabric.warp_angle to 0 or 90 and leave the outline out", key="fabric")
    cell = float(cells.mean())
    if most * cell > LARGEST_TURN:
        message = f"cells of {cell:.3g} mm are too coarse for a curvature of {1e3 * most:.3g} 1/m"
        remedy = f"make fabric.coarsening smaller by {most * cell / LARGEST_TURN:.3g}"
        raise BadInput.of(f"{message}; {remedy}", key="fabric.coarsening")
    return model.points[:, 0] / cell, cell


def _turning_area(model: Model) -> float:
    """Return the area (mm2) of the nodes at which yarns along x turn: all but those at free ends."""
    lattice = model.lattice
    x = lattice.points[:, 0]
    ends = x == x.max()
    if not lattice.symmetry[0]:
        ends |= x == x.min()
    return float(lattice.share[~ends].sum() * lattice.cell_area)
