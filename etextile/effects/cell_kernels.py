"""Compiled loops over cells whose energy depends on their six distances: the diagonals of `effects.angle_diagonals`.

A cell has four nodes and six bonds: two along the warp, two along the weft, two diagonals. `ends` (6, 2) says between
which of its nodes each bond reaches; strains and slopes follow the logarithms of the distances.
"""

from __future__ import annotations

import math

import numpy as np

from etextile.compiled import njit
from etextile.mechanics.kernels import add_dense_blocks
from etextile.types import Array, IntArray


@njit
def between_nodes(nodes: IntArray, ends: IntArray, values: Array, bonds: Array) -> None:
    """Fill the differences (Q, 6, 3) of nodal vectors (P, 3) along the bonds of cells with these nodes (Q, 4)."""
    for q in range(nodes.shape[0]):
        for i in range(6):
            a, b = nodes[q, ends[i, 0]], nodes[q, ends[i, 1]]
            for c in range(3):
                bonds[q, i, c] = values[b, c] - values[a, c]


@njit
def cell_strains(bonds: Array, first: Array, alpha: Array, length: Array, share: Array, strain: Array) -> None:
    """Fill lengths (Q, 6) mm, the warp's share (Q,) and strains (Q, 2) of the diagonals of cells with these bonds.

    first (Q, 6) mm: the distances at first; alpha (Q,): share of the warp side in the first diagonal squared.
    """
    logs = np.empty(6)
    for q in range(bonds.shape[0]):
        for i in range(6):
            x, y, z = bonds[q, i, 0], bonds[q, i, 1], bonds[q, i, 2]
            length[q, i] = math.sqrt(x * x + y * y + z * z)
            logs[i] = math.log(length[q, i] / first[q, i])
        warp = alpha[q] * math.exp(logs[0] + logs[1])
        weft = (1.0 - alpha[q]) * math.exp(logs[2] + logs[3])
        share[q] = warp / (warp + weft)
        side = 0.5 * math.log(warp + weft)
        strain[q, 0] = logs[4] - side
        strain[q, 1] = logs[5] - side


@njit
def cell_rates(bonds: Array, length: Array, share: Array, moved: Array, rate: Array) -> None:
    """Fill the change (Q, 2) of the diagonals' strains when the bonds (Q, 6, 3) change by `moved`, to first order."""
    logs = np.empty(6)
    for q in range(bonds.shape[0]):
        for i in range(6):
            along = 0.0
            for c in range(3):
                along += bonds[q, i, c] * moved[q, i, c]
            logs[i] = along / length[q, i] ** 2
        side = 0.5 * (share[q] * (logs[0] + logs[1]) + (1.0 - share[q]) * (logs[2] + logs[3]))
        rate[q, 0] = logs[4] - side
        rate[q, 1] = logs[5] - side


@njit
def add_cell_gradient(
    nodes: IntArray, ends: IntArray, bonds: Array, length: Array, share: Array, pull: Array, gradient: Array
) -> None:
    """Add the nodal gradients to gradient (P, 3) when the diagonals' energies rise by pull (Q, 2) N mm per strain."""
    slope = np.empty(6)
    for q in range(nodes.shape[0]):
        both = pull[q, 0] + pull[q, 1]
        if pull[q, 0] == 0.0 and pull[q, 1] == 0.0:
            continue
        slope[0] = slope[1] = -0.5 * share[q] * both
        slope[2] = slope[3] = -0.5 * (1.0 - share[q]) * both
        slope[4], slope[5] = pull[q, 0], pull[q, 1]
        for i in range(6):
            a, b = nodes[q, ends[i, 0]], nodes[q, ends[i, 1]]
            force = slope[i] / length[q, i] ** 2
            for c in range(3):
                gradient[a, c] -= force * bonds[q, i, c]
                gradient[b, c] += force * bonds[q, i, c]


@njit
def add_cell_tangent(
    nodes: IntArray, ends: IntArray, bonds: Array, length: Array, share: Array, pull: Array, stiff: Array, exact: bool,
    rows: IntArray, pairs: IntArray, values: Array,
) -> None:  # fmt: skip
    """Add the tangent of cells whose diagonals bear pull (Q, 2) and stiff = d pull / d strain (Q, 2), N mm.

    With by_logs = d2U/d(ln d)2 less twice dU/d(ln d) on the diagonal, a bond u of length d gives u u^T by_logs / d^4
    and I dU/d(ln d) / d^2. Unless `exact` both are what is positive by construction: only diagonals that pull, and
    neither what the sides' stretch takes off nor what falls with length.
    """
    by_slope, slope = np.empty((2, 6)), np.empty(6)
    logs, block = np.empty((6, 6)), np.empty((1, 12, 12))
    for q in range(nodes.shape[0]):
        if not (pull[q, 0] or pull[q, 1] or stiff[q, 0] or stiff[q, 1]):
            continue
        for k in range(2):
            by_slope[k, 0] = by_slope[k, 1] = -0.5 * share[q]
            by_slope[k, 2] = by_slope[k, 3] = -0.5 * (1.0 - share[q])
            by_slope[k, 4] = by_slope[k, 5] = 0.0
            by_slope[k, 4 + k] = 1.0
        one, other = stiff[q, 0], stiff[q, 1]
        if not exact:
            one, other = max(one - pull[q, 0], 0.0), max(other - pull[q, 1], 0.0)
        for i in range(6):
            for j in range(6):
                logs[i, j] = one * by_slope[0, i] * by_slope[0, j] + other * by_slope[1, i] * by_slope[1, j]
        if exact:
            mixed = 0.5 * share[q] * (1.0 - share[q]) * (pull[q, 0] + pull[q, 1])
            for i in range(4):
                for j in range(4):
                    logs[i, j] -= mixed if (i < 2) == (j < 2) else -mixed
            for i in range(6):
                slope[i] = pull[q, 0] * by_slope[0, i] + pull[q, 1] * by_slope[1, i]
                logs[i, i] -= 2.0 * slope[i]
        else:
            for i in range(6):
                slope[i] = max(pull[q, i - 4], 0.0) if i > 3 else 0.0
                logs[i, i] -= slope[i]
        _distances_hessian(ends, bonds[q], length[q], logs, slope, block[0])
        add_dense_blocks(nodes[q : q + 1], block, rows, pairs[q : q + 1], values)


@njit
def _distances_hessian(
    ends: IntArray, bonds: Array, length: Array, by_logs: Array, slope: Array, hessian: Array
) -> None:
    """Fill d2U/dx2 (12, 12) of four nodes whose energy depends on the logarithms of their six distances.

    bonds (6, 3) with these lengths (6,); by_logs (6, 6): d2U/d(ln d)2 less twice dU/d(ln d) on the diagonal; slope
    (6,): dU/d(ln d).
    """
    hessian[:] = 0.0
    for i in range(6):
        for j in range(6):
            share = by_logs[i, j] / (length[i] ** 2 * length[j] ** 2)
            own = slope[i] / length[i] ** 2 if i == j else 0.0
            if share == 0.0 and own == 0.0:
                continue
            for a in range(2):
                for b in range(2):
                    sign = 1.0 if a == b else -1.0
                    row, column = 3 * ends[i, a], 3 * ends[j, b]
                    for c in range(3):
                        for d in range(3):
                            hessian[row + c, column + d] += sign * share * bonds[i, c] * bonds[j, d]
                        hessian[row + c, column + c] += sign * own
