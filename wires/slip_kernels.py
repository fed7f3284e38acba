"""Compiled loops over wires that slide in the weave: response, gradient and tangent of elements and channel friction.

A sliding element has its lattice nodes in the first columns of `nodes` and the slip points of its two ends, with no
weight, in the last two; a slip point has one unknown, its first component. Forces and stiffness between the nodes are
those of a truss (`etextile.mechanics.kernels`); here stands what fed length adds to them. With current length l,
stress-free length R = R_old + s_b - s_a and W = (A/R_old) V_old R w(ln(l / R)) the derivatives are dW/dl = F and
dW/dR = -G, and because W is homogeneous of degree one in (l, R) its Hessian has rank one: with k = dF/dl it is
k (1, -l/R) (1, -l/R)^T.
"""

from __future__ import annotations

import math

from etextile.compiled import njit
from wires.wire_law import wire_respond


SECANT = 0.15
"""Share of the secant stiffness left to a sliding point in the tangent: measured best between 0.03 and 1. With none,
points switch between stick and slip one by one; with all of it, convergence is slow and linear."""

EMPTIEST = 50.0
"""An element is never emptied below exp(-EMPTIEST) of its floor, which only wild trials reach."""


@njit
def sliding_response(  # type: ignore[no-untyped-def]
    x, nodes, weights, rigid, offset, area, row, floor, fed_old, free_old, virgin,
    unit, chord, length, free, chain, force, along, pull, p_new,
):  # fmt: skip
    """Fill unit (M, 3) and (M,) chord = distance - offset, length = chord - rigid, stress-free length, its slope
    over the fed length, force F, along = dF/dl, pull G, plastic strain; return (stored, dissipated) energy of this
    increment, N mm.

    fed_old (M,): s_b - s_a at the start of the increment; free_old, virgin (M,): stress-free and virgin length then.
    A stress-free length below `floor` (M,) approaches zero exponentially, so that no trial empties an element.
    """
    k = nodes.shape[1] - 2
    stored = 0.0
    dissipated = 0.0
    for e in range(nodes.shape[0]):
        dx = dy = dz = 0.0
        for a in range(k):
            w = weights[e, a]
            dx += w * x[nodes[e, a], 0]
            dy += w * x[nodes[e, a], 1]
            dz += w * x[nodes[e, a], 2]
        size = max(math.sqrt(dx * dx + dy * dy + dz * dz), 1e-12 * virgin[e])
        unit[e, 0], unit[e, 1], unit[e, 2] = dx / size, dy / size, dz / size
        size -= offset[e]
        taut = max(size - rigid[e], 1e-12 * virgin[e])
        rest = free_old[e] + x[nodes[e, k + 1], 0] - x[nodes[e, k], 0] - fed_old[e]
        chain[e] = 1.0
        if rest < floor[e]:
            chain[e] = math.exp(max(rest / floor[e] - 1.0, -EMPTIEST))
            rest = floor[e] * chain[e]
        p_old = math.log(free_old[e] / virgin[e])
        eps = p_old + math.log(taut / rest)
        tau, slope, p, elastic, plastic = wire_respond(row, eps, p_old)
        section = area[e] * virgin[e] / free_old[e]
        chord[e], length[e], free[e], p_new[e] = size, taut, rest, p
        force[e] = section * rest * tau / taut
        along[e] = section * rest * (slope - tau) / (taut * taut)
        pull[e] = section * (tau - elastic - plastic)
        stored += section * rest * elastic
        dissipated += section * rest * plastic
    return stored, dissipated


@njit
def wire_forces(rest, stretch, section, p_old, row, force, along, pull):  # type: ignore[no-untyped-def]
    """Fill force F, dF/dl and pull G (M,) of wires stretched by `stretch` (M,) beyond the lengths `rest` they hold."""
    for e in range(rest.shape[0]):
        taut = rest[e] + stretch[e]
        tau, slope, _, elastic, plastic = wire_respond(row, p_old[e] + math.log1p(stretch[e] / rest[e]), p_old[e])
        force[e] = section[e] * rest[e] * tau / taut
        along[e] = section[e] * rest[e] * (slope - tau) / (taut * taut)
        pull[e] = section[e] * (tau - elastic - plastic)


@njit
def add_feed_gradient(nodes, pull, chain, anchored, gradient):  # type: ignore[no-untyped-def]
    """Add -dG over the slip points that are not anchored to gradient (P, 3)."""
    k = nodes.shape[1] - 2
    for e in range(nodes.shape[0]):
        g = pull[e] * chain[e]
        if not anchored[e, 0]:
            gradient[nodes[e, k], 0] += g
        if not anchored[e, 1]:
            gradient[nodes[e, k + 1], 0] -= g


@njit
def add_feed_tangent(  # type: ignore[no-untyped-def]
    nodes, weights, unit, along, ratio, bend, damping, rows, pairs, values
):
    """Add what fed length adds to the tangents of trusses: its own stiffness and that between it and the nodes.

    ratio (M,): l / R times the slope of R over the fed length; bend (M,): curvature of the energy from that slope.
    `damping` goes on the unit Laplacian of the fed length.
    """
    k = nodes.shape[1] - 2
    for e in range(nodes.shape[0]):
        pair = 0
        for a in range(k):
            # Slip points stand behind all nodes, so their column is in the rows of the node.
            pair += k - 1 - a
            c = weights[e, a] * along[e] * ratio[e]
            if c != 0.0:
                for side in range(2):
                    s = c if side == 0 else -c
                    for axis in range(3):
                        values[pairs[e, pair + side, axis]] += s * unit[e, axis]
            pair += 2
        own = along[e] * ratio[e] * ratio[e] + bend[e] + damping
        values[rows[3 * nodes[e, k]]] += own
        values[rows[3 * nodes[e, k + 1]]] += own
        values[pairs[e, pair, 0]] -= own


@njit
def channel_friction(x, points, anchor, limit, stiffness, traction, tangent):  # type: ignore[no-untyped-def]
    """Fill traction (n,) N and tangent (n,) N/mm at slip points; return (spring energy, dissipation) in N mm.

    Elastic stick about `anchor` up to `limit`, then slip: the derivative of a Huber potential, which is convex. The
    tangent of a sliding point is not the exact zero (see SECANT).
    """
    spring = 0.0
    work = 0.0
    for i in range(points.shape[0]):
        traction[i] = tangent[i] = 0.0
        if limit[i] <= 0.0:
            continue
        offset = x[points[i], 0] - anchor[i]
        reach = limit[i] / stiffness[i]
        if abs(offset) <= reach:
            traction[i] = stiffness[i] * offset
            tangent[i] = stiffness[i]
            spring += 0.5 * stiffness[i] * offset * offset
        else:
            traction[i] = limit[i] if offset > 0.0 else -limit[i]
            tangent[i] = SECANT * limit[i] / abs(offset)
            spring += 0.5 * limit[i] * reach
            work += limit[i] * (abs(offset) - reach)
    return spring, work


@njit
def add_friction(points, traction, anchored, gradient):  # type: ignore[no-untyped-def]
    """Add channel friction to gradient (P, 3)."""
    for i in range(points.shape[0]):
        if not anchored[i]:
            gradient[points[i], 0] += traction[i]


@njit
def add_friction_tangent(points, tangent, rows, values):  # type: ignore[no-untyped-def]
    """Add the stick stiffness of slip points to the diagonal."""
    for i in range(points.shape[0]):
        values[rows[3 * points[i]]] += tangent[i]
