"""Compiled loops over trusses: response, gradient and tangent on a sparsity pattern laid out once.

A truss is a difference vector d = sum_a w_a x_a over its k nodes with sum_a w_a = 0: a plain truss has weights
(-1, 1), a wire element embedded in the cells it crosses has interpolation weights. With the unit vector u = d / l

    gradient_a = w_a F u,   tangent_ab = w_a w_b (across I + (along - across) u u^T),   along = dF/dl, across = F / l.
"""

from __future__ import annotations

import math

import numpy as np

from etextile.compiled import njit
from etextile.laws.powerlaw import dissipated_energy, respond, stored_energy


@njit
def truss_response(  # type: ignore[no-untyped-def]
    x, nodes, weights, rest, offset, area, law, table, p_old, unit, length, force, along, p_new
):
    """Fill unit (M, 3), force (M,), along = dF/dl (M,), p_new (M,) and length (M,), the distance of the ends less the
    offset (M,), at node positions x (N, 3).
    """
    for e in range(nodes.shape[0]):
        dx = dy = dz = 0.0
        for a in range(nodes.shape[1]):
            w = weights[e, a]
            dx += w * x[nodes[e, a], 0]
            dy += w * x[nodes[e, a], 1]
            dz += w * x[nodes[e, a], 2]
        size = math.sqrt(dx * dx + dy * dy + dz * dz)
        if size < 1e-12 * rest[e]:
            size = 1e-12 * rest[e]
        unit[e, 0], unit[e, 1], unit[e, 2] = dx / size, dy / size, dz / size
        free = max(size - offset[e], 1e-12 * rest[e])
        tau, slope, p = respond(table[law[e]], math.log(free / rest[e]), p_old[e])
        volume = area[e] * rest[e]
        length[e] = free
        force[e] = volume * tau / free
        along[e] = volume * (slope - tau) / (free * free)
        p_new[e] = p


@njit
def truss_law(slack, stretch, rest, area, law, table, p_old, force, along):  # type: ignore[no-untyped-def]
    """Fill force (M,) and along = dF/dl (M,) of the law at stretches (M,) > 0 beyond slack lengths (M,).

    Stretches too small to be seen in the length bear in proportion.
    """
    for e in range(rest.shape[0]):
        seen = max(stretch[e], 1e-9 * slack[e])
        length = slack[e] + seen
        tau, slope, _ = respond(table[law[e]], math.log(length / rest[e]), p_old[e])
        volume = area[e] * rest[e]
        force[e] = volume * tau / length
        along[e] = volume * (slope - tau) / (length * length)
        if stretch[e] < seen:
            along[e] = force[e] / seen
            force[e] = along[e] * stretch[e]


@njit
def truss_rate(step, nodes, weights, unit, rate):  # type: ignore[no-untyped-def]
    """Fill the change of length (M,) along the nodal step (N, 3) to first order."""
    for e in range(nodes.shape[0]):
        total = 0.0
        for a in range(nodes.shape[1]):
            n = nodes[e, a]
            total += weights[e, a] * (unit[e, 0] * step[n, 0] + unit[e, 1] * step[n, 1] + unit[e, 2] * step[n, 2])
        rate[e] = total


@njit
def truss_bulge(step, nodes, weights, length, rate, bulge):  # type: ignore[no-untyped-def]
    """Fill the length (M,) gained by turning along the nodal step (N, 3), whose first-order change is `rate`."""
    for e in range(nodes.shape[0]):
        dx = dy = dz = 0.0
        for a in range(nodes.shape[1]):
            w = weights[e, a]
            dx += w * step[nodes[e, a], 0]
            dy += w * step[nodes[e, a], 1]
            dz += w * step[nodes[e, a], 2]
        aside = max(dx * dx + dy * dy + dz * dz - rate[e] * rate[e], 0.0)
        ahead = abs(length[e] + rate[e])
        whole = math.sqrt(ahead * ahead + aside)
        bulge[e] = aside / (whole + ahead) if whole > 0.0 else 0.0


@njit
def truss_energy(length, rest, area, law, table, p):  # type: ignore[no-untyped-def]
    """Return (stored, dissipated) energy in N mm of all trusses."""
    stored = 0.0
    dissipated = 0.0
    for e in range(rest.shape[0]):
        volume = area[e] * rest[e]
        stored += volume * stored_energy(table[law[e]], math.log(length[e] / rest[e]), p[e])
        dissipated += volume * dissipated_energy(table[law[e]], p[e])
    return stored, dissipated


@njit
def add_truss_gradient(nodes, weights, unit, force, gradient):  # type: ignore[no-untyped-def]
    """Add the nodal gradients of all trusses to gradient (N, 3)."""
    for e in range(nodes.shape[0]):
        for a in range(nodes.shape[1]):
            f = weights[e, a] * force[e]
            n = nodes[e, a]
            gradient[n, 0] += f * unit[e, 0]
            gradient[n, 1] += f * unit[e, 1]
            gradient[n, 2] += f * unit[e, 2]


@njit
def add_truss_tangent(  # type: ignore[no-untyped-def]
    nodes, weights, unit, along, across, damping, rows, pairs, values
):
    """Add truss tangents to the upper-triangular values.

    rows (3 N,): position of each diagonal entry; pairs (M, k (k - 1) / 2, 3): positions of the first entry of the three
    rows of each off-diagonal node block.
    """
    k = nodes.shape[1]
    for e in range(nodes.shape[0]):
        t = across[e] + damping
        d = along[e] - across[e]
        if t == 0.0 and d == 0.0:
            continue
        ux, uy, uz = unit[e, 0], unit[e, 1], unit[e, 2]
        xx, yy, zz = t + d * ux * ux, t + d * uy * uy, t + d * uz * uz
        xy, xz, yz = d * ux * uy, d * ux * uz, d * uy * uz
        pair = 0
        for a in range(k):
            wa = weights[e, a]
            r = 3 * nodes[e, a]
            w = wa * wa
            values[rows[r]] += w * xx
            values[rows[r] + 1] += w * xy
            values[rows[r] + 2] += w * xz
            values[rows[r + 1]] += w * yy
            values[rows[r + 1] + 1] += w * yz
            values[rows[r + 2]] += w * zz
            for b in range(a + 1, k):
                w = wa * weights[e, b]
                if w != 0.0:
                    i, j, m = pairs[e, pair, 0], pairs[e, pair, 1], pairs[e, pair, 2]
                    values[i] += w * xx
                    values[i + 1] += w * xy
                    values[i + 2] += w * xz
                    values[j] += w * xy
                    values[j + 1] += w * yy
                    values[j + 2] += w * yz
                    values[m] += w * xz
                    values[m + 1] += w * yz
                    values[m + 2] += w * zz
                pair += 1


@njit
def add_node_blocks(nodes, blocks, rows, values):  # type: ignore[no-untyped-def]
    """Add symmetric 3 x 3 blocks (n, 3, 3) of single nodes (contact) to the upper-triangular values."""
    for i in range(nodes.shape[0]):
        r = 3 * nodes[i]
        values[rows[r]] += blocks[i, 0, 0]
        values[rows[r] + 1] += blocks[i, 0, 1]
        values[rows[r] + 2] += blocks[i, 0, 2]
        values[rows[r + 1]] += blocks[i, 1, 1]
        values[rows[r + 1] + 1] += blocks[i, 1, 2]
        values[rows[r + 2]] += blocks[i, 2, 2]


@njit
def add_dense_blocks(nodes, hessian, rows, pairs, values):  # type: ignore[no-untyped-def]
    """Add full element tangents (n, 3 k, 3 k) of k-node elements; `pairs` as in `add_truss_tangent`."""
    k = nodes.shape[1]
    for e in range(nodes.shape[0]):
        pair = 0
        for a in range(k):
            r = 3 * nodes[e, a]
            for i in range(3):
                for j in range(i, 3):
                    values[rows[r + i] + j - i] += hessian[e, 3 * a + i, 3 * a + j]
            for b in range(a + 1, k):
                upright = nodes[e, a] < nodes[e, b]
                for i in range(3):
                    for j in range(3):
                        if upright:
                            values[pairs[e, pair, i] + j] += hessian[e, 3 * a + i, 3 * b + j]
                        else:
                            values[pairs[e, pair, i] + j] += hessian[e, 3 * b + i, 3 * a + j]
                pair += 1


@njit
def unsolved(indptr, indices, values, x, rhs):  # type: ignore[no-untyped-def]
    """Return |b - A x|^2 for the symmetric matrix whose upper triangle has these values."""
    left = rhs.copy()
    for r in range(x.shape[0]):
        total = values[indptr[r]] * x[r]
        for k in range(indptr[r] + 1, indptr[r + 1]):
            c = indices[k]
            total += values[k] * x[c]
            left[c] -= values[k] * x[r]
        left[r] -= total
    return np.square(left).sum()


@njit
def eliminate(fixed, indptr, indices, values):  # type: ignore[no-untyped-def]
    """Turn rows and columns of fixed unknowns into identity rows, so that the pattern never changes."""
    for r in range(fixed.shape[0]):
        if fixed[r]:
            values[indptr[r]] = 1.0
            for k in range(indptr[r] + 1, indptr[r + 1]):
                values[k] = 0.0
        else:
            for k in range(indptr[r] + 1, indptr[r + 1]):
                if fixed[indices[k]]:
                    values[k] = 0.0
