"""Compiled loops of effects: the yarn law over virtual trusses, gradients and tangents of angle elements."""

from __future__ import annotations

import math

import numpy as np

from etextile.compiled import njit
from etextile.laws.powerlaw import dissipated_energy, respond, stored_energy
from etextile.mechanics.kernels import add_dense_blocks
from etextile.types import Array, IntArray


TINY = float(np.finfo(float).tiny ** 0.5)
"""Length of a vector of no length, mm."""


@njit
def law_response(
    table: Array, law: IntArray, strain: Array, old: Array, tau: Array, slope: Array, plastic: Array
) -> None:
    """Fill tau, d tau / d eps and plastic strain (n,) at Hencky strains (n,) from plastic strains `old` (n,)."""
    for e in range(strain.shape[0]):
        tau[e], slope[e], plastic[e] = respond(table[law[e]], strain[e], old[e])


@njit
def law_energy(table: Array, law: IntArray, volume: Array, strain: Array, plastic: Array) -> tuple[float, float]:
    """Return (stored, dissipated) energy in N mm of trusses with these volumes (n,) mm3."""
    stored = 0.0
    dissipated = 0.0
    for e in range(strain.shape[0]):
        stored += volume[e] * stored_energy(table[law[e]], strain[e], plastic[e])
        dissipated += volume[e] * dissipated_energy(table[law[e]], plastic[e])
    return stored, dissipated


@njit
def law_beyond(
    table: Array, volume: Array, slack: Array, stretch: Array, old: Array, force: Array, along: Array
) -> None:
    """Fill dU/dl and d2U/dl2 (n,), N mm, at stretches (n,) > 0 beyond slack lengths (n,) in units of the first length.

    Stretches too small to be seen in the length bear in proportion; one law, the first row of the table.
    """
    for e in range(stretch.shape[0]):
        seen = max(stretch[e], 1e-9 * slack[e])
        length = slack[e] + seen
        tau, slope, _ = respond(table[0], math.log(length), old[e])
        force[e] = volume[e] * tau / length
        along[e] = volume[e] * (slope - tau) / (length * length)
        if stretch[e] < seen:
            along[e] = force[e] / seen
            force[e] = along[e] * stretch[e]


@njit
def angle_vectors(
    nodes: IntArray, first: Array, second: Array, x: Array, w: Array, v: Array, w_size: Array, v_size: Array,
    cosine: Array,
) -> None:  # fmt: skip
    """Fill unit vectors w, v (n, 3), their lengths (n,) and the cosine (n,) of angle elements at positions x (P, 3).

    A vector of no length gets a tiny one.
    """
    for e in range(nodes.shape[0]):
        ww = vv = 0.0
        for c in range(3):
            one = other = 0.0
            for a in range(nodes.shape[1]):
                one += first[a, c] * x[nodes[e, a], c]
                other += second[a, c] * x[nodes[e, a], c]
            w[e, c], v[e, c] = one, other
            ww += one * one
            vv += other * other
        w_size[e] = max(math.sqrt(ww), TINY)
        v_size[e] = max(math.sqrt(vv), TINY)
        total = 0.0
        for c in range(3):
            w[e, c] /= w_size[e]
            v[e, c] /= v_size[e]
            total += w[e, c] * v[e, c]
        cosine[e] = total


@njit
def add_angle_gradient(
    nodes: IntArray, first: Array, second: Array, w: Array, v: Array, w_size: Array, v_size: Array, cosine: Array,
    slope: Array, gradient: Array,
) -> None:  # fmt: skip
    """Add the nodal gradients of all angle elements (`effects.angles`) to gradient (P, 3)."""
    for e in range(nodes.shape[0]):
        if slope[e] == 0.0:
            continue
        for c in range(3):
            to_w = slope[e] * (v[e, c] - cosine[e] * w[e, c]) / w_size[e]
            to_v = slope[e] * (w[e, c] - cosine[e] * v[e, c]) / v_size[e]
            for a in range(nodes.shape[1]):
                gradient[nodes[e, a], c] += first[a, c] * to_w + second[a, c] * to_v


@njit
def angle_hessian(
    active: IntArray, w: Array, v: Array, w_size: Array, v_size: Array, cosine: Array, slope: Array, curvature: Array,
    hessian: Array,
) -> None:  # fmt: skip
    """Fill d2U/d(w, v)2 (m, 6, 6) of the angle elements numbered `active` (m,)."""
    to = np.empty(6)
    for m in range(active.shape[0]):
        e = active[m]
        s, a, b = cosine[e], 1.0 / w_size[e], 1.0 / v_size[e]
        for c in range(3):
            to[c] = (v[e, c] - s * w[e, c]) * a
            to[3 + c] = (w[e, c] - s * v[e, c]) * b
        for i in range(6):
            for j in range(6):
                hessian[m, i, j] = curvature[e] * to[i] * to[j]
        turn_w, turn_v, turn_both = slope[e] * a, slope[e] * b, slope[e] * a * b
        for i in range(3):
            for j in range(3):
                same = 1.0 if i == j else 0.0
                ww, vv = w[e, i] * w[e, j], v[e, i] * v[e, j]
                hessian[m, i, j] -= turn_w * (w[e, i] * to[j] + to[i] * w[e, j] + s * a * (same - ww))
                hessian[m, 3 + i, 3 + j] -= turn_v * (v[e, i] * to[3 + j] + to[3 + i] * v[e, j] + s * b * (same - vv))
                mixed = turn_both * (same - ww - vv + s * w[e, i] * v[e, j])
                hessian[m, i, 3 + j] += mixed
                hessian[m, 3 + j, i] += mixed


@njit
def add_angle_tangent(
    active: IntArray, nodes: IntArray, first: Array, second: Array, hessian: Array, rows: IntArray, pairs: IntArray,
    values: Array,
) -> None:  # fmt: skip
    """Add the tangents of the angle elements `active` (m,), hessian (m, 6, 6) in w and v, to the values."""
    k = nodes.shape[1]
    block = np.empty((1, 3 * k, 3 * k))
    for m in range(active.shape[0]):
        for a in range(k):
            for i in range(3):
                f, g = first[a, i], second[a, i]
                for b in range(k):
                    for j in range(3):
                        to_w = f * hessian[m, i, j] + g * hessian[m, 3 + i, j]
                        to_v = f * hessian[m, i, 3 + j] + g * hessian[m, 3 + i, 3 + j]
                        block[0, 3 * a + i, 3 * b + j] = first[b, j] * to_w + second[b, j] * to_v
        e = active[m]
        add_dense_blocks(nodes[e : e + 1], block, rows, pairs[e : e + 1], values)


@njit
def add_pair_forces(nodes: IntArray, force: Array, gradient: Array) -> None:
    """Add forces (n, 3) to the second of the nodes (n, 2) in gradient (P, 3) and take them from the first."""
    for e in range(nodes.shape[0]):
        for c in range(3):
            gradient[nodes[e, 0], c] -= force[e, c]
            gradient[nodes[e, 1], c] += force[e, c]


@njit
def add_cell_normals(quads: IntArray, x: Array, total: Array) -> None:
    """Add the normal of each cell (Q, 4) at positions x (P, 3), twice its area long, to its corners in total (P, 3)."""
    for q in range(quads.shape[0]):
        for c in range(3):
            d, e = (c + 1) % 3, (c + 2) % 3
            one = (x[quads[q, 2], d] - x[quads[q, 0], d]) * (x[quads[q, 3], e] - x[quads[q, 1], e])
            other = (x[quads[q, 2], e] - x[quads[q, 0], e]) * (x[quads[q, 3], d] - x[quads[q, 1], d])
            for a in range(4):
                total[quads[q, a], c] += one - other
