"""Equilibrium of subdomains: a step of the whole lattice leaves its residual at a few nodes, which are settled apart.

Where yarns turn taut or leave the body the fault of a step sits in single trusses and wanders along their yarn by one
node per step. So the nodes with the largest residuals, and some layers around them, are taken out as a small model
whose rim is held, and brought near equilibrium by the same interior-point steps: hundredths of the work of the whole.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from etextile.mechanics.model import Model
from etextile.solve.member import members_of
from etextile.solve.newton import size
from etextile.solve.step import Iterate, improve
from etextile.solve.system import System
from etextile.types import Array, BoolArray, IntArray


T = TypeVar("T")
SHARE = 0.1
"""Nodes are at fault whose residual is more than this share of the largest."""
LAYERS = 5
"""Layers of nodes around those that move with them."""
LARGEST = 0.1
"""Largest subdomain as a share of all nodes: beyond, a step of the whole is the better bargain."""
SMALLEST = (LAYERS + 1) ** 2
"""Nodes of a subdomain at the corner of a lattice: pieces without room for it need not look for any."""
STEPS = 4
"""Most steps of a subdomain."""
ENOUGH = 0.3
"""A subdomain is settled when its residual is less than this share of the residual outside."""


@dataclass(frozen=True)
class Subdomain:
    """A part of a system: its nodes (n,), and the elements (k,) of each contribution, none of those left out."""

    system: System
    nodes: IntArray
    elements: tuple[IntArray, ...]

    def of(self, values: Iterable[T]) -> tuple[tuple[T, IntArray], ...]:
        """Return the `values`, one of each contribution of the whole, that the subdomain has, with its elements."""
        return tuple(pair for pair in zip(values, self.elements, strict=True) if len(pair[1]))


def settle(system: System, now: Iterate, tolerance: float) -> Iterate:
    """Return the iterate with the subdomain around its largest residuals settled, itself where that is not small."""
    moving = around(system, now.trial.residual)
    if moving is None:
        return now
    outside = size(now.trial.residual[~moving])
    goal = max(ENOUGH * outside, tolerance)
    if size(now.trial.residual[moving]) <= goal:
        return now
    start = time.perf_counter()
    subdomain = cut(system, moving)
    if subdomain is None:
        return now
    inner = taken(subdomain, now)
    for _ in range(STEPS):
        following = improve(subdomain.system, inner, tolerance, 1.0)
        if following is None:
            break
        inner = following
        if size(inner.trial.residual) <= goal:
            break
    system.counters.subdomain_steps += subdomain.system.counters.linear_solves
    system.counters.subdomain_s += time.perf_counter() - start
    after = put_back(system, now, subdomain, inner)
    return after if size(after.trial.residual) < size(now.trial.residual) else now


def around(system: System, residual: Array) -> BoolArray | None:
    """Return the nodes (P,) at fault with the layers around them, None when these are no small part of all."""
    if LARGEST * len(residual) < SMALLEST:
        return None
    found = np.linalg.norm(residual, axis=1)
    if not found.max() > 0.0:  # nor where it is not a number
        return None
    found = (found > SHARE * found.max()).astype(float)
    for _ in range(LAYERS):
        if np.count_nonzero(found) > LARGEST * len(found):
            return None
        found = system.pattern.neighbours @ found
    return np.asarray(found > 0.0) if np.count_nonzero(found) <= LARGEST * len(found) else None


def cut(system: System, moving: BoolArray) -> Subdomain | None:
    """Return the subdomain in which the nodes `moving` (P,) are free; None when a contribution cannot be cut."""
    model = system.model
    elements = tuple(np.flatnonzero(moving[part.nodes].any(axis=1)) for part in model.contributions)
    inside = np.zeros(len(moving), dtype=bool)
    for part, chosen in zip(model.contributions, elements, strict=True):
        inside[part.nodes[chosen]] = True
    nodes = np.flatnonzero(inside)
    number = np.full(len(moving), -1)
    number[nodes] = np.arange(len(nodes))
    parts = [
        part.among(chosen, number) for part, chosen in zip(model.contributions, elements, strict=True) if len(chosen)
    ]
    if any(part is None for part in parts):
        return None
    small: Model = replace(
        model,
        points=model.points[nodes],
        fixed=model.fixed[nodes] | ~moving[nodes, None],
        carried=model.carried[nodes],
        guide=None,
        contributions=tuple(part for part in parts if part is not None),
    )
    return Subdomain(System(small, linear=system.solver.name), nodes, elements)


def taken(subdomain: Subdomain, now: Iterate) -> Iterate:
    """Return what of an iterate of the whole belongs to the subdomain."""
    inside = subdomain.of(now.members)
    parts = subdomain.system.model.contributions
    states = tuple(part.state_among(old.state, chosen) for part, (old, chosen) in zip(parts, inside, strict=True))
    trial = subdomain.system.evaluate(now.trial.x[subdomain.nodes], now.trial.travel, states)
    own = zip(members_of(subdomain.system, trial, states), inside, strict=True)
    return Iterate(trial, tuple(old.cut(new, chosen) for new, (old, chosen) in own), now.caution)


def put_back(system: System, now: Iterate, subdomain: Subdomain, inner: Iterate) -> Iterate:
    """Return the iterate of the whole with nodes and pairs of the subdomain replaced."""
    x = now.trial.x.copy()
    x[subdomain.nodes] = inner.trial.x
    trial = system.evaluate(x, now.trial.travel, now.states)
    own = iter(inner.members)
    members = tuple(
        old.put_back(new, next(own) if len(chosen) else None, chosen)
        for old, new, chosen in zip(now.members, members_of(system, trial, now.states), subdomain.elements, strict=True)
    )
    return Iterate(trial, members, now.caution)
