"""One step of the interior-point Newton over slackness and contact: factorise, predict, correct, move.

Hundreds of yarns of a slack fabric flicker between slack and taut at forces a millionth of their stiffness; a Newton
method that looks at positions alone has to cut nearly every step. Here each one-sided element carries force and slack
as a pair (`barrier`), steps are whole as long as they help, and mu falls as fast as Mehrotra's predictor allows (SIAM
J. Optim. 2 (1992) 575), with two substitutions per factorisation.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from etextile.solve.barrier import Linear, Pair, Target
from etextile.solve.linear import NotPositiveDefinite
from etextile.solve.newton import REACH
from etextile.solve.system import States, System, Trial
from etextile.types import Array


WIDTH = 1e-3
"""Strain of a typical truss that gives the first mu."""
LAPLACIAN, IDENTITY = 1e-8, 1e-9
"""Regularisation, as shares of the typical stiffness."""
CAUTION = 3
"""Steps taken with the convex part of the tangent at once after the exact one was not positive definite."""
SKEW_TOLERANCE, SKEW_TURNS = 1e-2, 20
"""Relative tolerance and most substitutions of GMRES where friction makes the tangent unsymmetric."""

Pairs = tuple[Pair | None, ...]
Lines = tuple[Linear | None, ...]


@dataclass(frozen=True)
class Iterate:
    """A trial, the states it starts from, and the pairs of its one-sided contributions (None for the others).

    `caution`: for how many steps the exact tangent is not tried, since a step before it was not positive definite.
    """

    trial: Trial
    states: States
    pairs: Pairs
    caution: int = 0


@dataclass(frozen=True)
class Step:
    """A step (P, 3) mm with the changes (stretch, slack) of each set of pairs; `length` keeps it within reach."""

    nodes: Array
    rates: tuple[Array | None, ...]
    changes: tuple[tuple[Array, Array] | None, ...]
    length: float


def begin(system: System, trial: Trial, states: States) -> Iterate:
    """Return the first iterate, all pairs centred at the mu of a typical truss strained by WIDTH."""
    model = system.model
    length = WIDTH * float(np.median(model.truss_blocks[0].rest_length))
    mu = model.typical_stiffness * length**2
    sides = (
        part.one_sided(response, state)
        for part, response, state in zip(model.contributions, trial.responses, states, strict=True)
    )
    return Iterate(trial, states, tuple(None if side is None else Pair.centred(side, mu) for side in sides))


def tighten(system: System, now: Iterate) -> Iterate:
    """Return the iterate with stricter states where contributions ask for them, pairs centred again where they are."""
    parts = system.model.contributions
    states = tuple(
        part.tightened(response, state)
        for part, response, state in zip(parts, now.trial.responses, now.states, strict=True)
    )
    if all(new is old for new, old in zip(states, now.states, strict=True)):
        return now
    trial = system.evaluate(now.trial.x, now.trial.travel, states)
    pairs: list[Pair | None] = []
    for part, response, state, old, pair in zip(parts, trial.responses, states, now.states, now.pairs, strict=True):
        side = None if pair is None or state is old else part.one_sided(response, state)
        pairs.append(pair if side is None or pair is None else Pair.centred(side, pair.product))
    return Iterate(trial, states, tuple(pairs), now.caution)


def improve(system: System, now: Iterate, tolerance: float, share: float) -> Iterate | None:
    """Return the next iterate by one factorisation, a predictor and `share` of a corrector; None without direction."""
    found = linearise(system, now)
    if found is None:
        return None
    lines, caution = found
    start = tuple(None if line is None else Target.zero(len(line.force)) for line in lines)
    guess = solve_for(system, now, lines, start)
    targets: list[Target | None] = []
    for pair, line, rate, change in zip(now.pairs, lines, guess.rates, guess.changes, strict=True):
        if pair is None or line is None or rate is None or change is None:
            targets.append(None)
            continue
        floor = (0.1 * tolerance) ** 2 / float(pair.side.stiffness.sum())
        bulge = pair.side.bulge(guess.length * guess.nodes, guess.length * rate)
        targets.append(Target(line.aim(change, guess.length, floor), bulge))
    step = solve_for(system, now, lines, tuple(targets))
    step = replace(step, length=share * step.length)
    return replace(move(system, now, step), caution=caution) if np.all(np.isfinite(step.nodes)) else None


def linearise(system: System, now: Iterate) -> tuple[Lines, int] | None:
    """Factorise the tangent: exact if it is positive definite, else its convex part, else with more on the diagonal.

    Returns the linearised pairs and the caution of the next step: a fabric that folds goes on folding, and a
    factorisation that fails costs as much as one that does not.
    """
    scale = system.model.typical_stiffness
    for exact, more in ((True, 1.0), (False, 1.0), (False, 1e3), (False, 1e6)):
        if exact and now.caution:
            continue
        lines = tuple(None if pair is None else Linear.of(pair, exact=exact) for pair in now.pairs)
        try:
            system.factorise(_filler(system, now, lines, exact=exact, more=more), identity=more * IDENTITY * scale)
        except NotPositiveDefinite:
            continue
        return lines, 0 if exact else now.caution - 1 if now.caution else CAUTION
    return None


def _filler(system: System, now: Iterate, lines: Lines, *, exact: bool, more: float) -> Callable[[Array], None]:
    """Return what adds all tangents to the values of the pattern."""
    damping = more * LAPLACIAN * system.model.typical_stiffness
    rows = system.pattern.rows

    def fill(values: Array) -> None:
        for response, line, pair, places in zip(
            now.trial.responses, lines, now.pairs, system.pattern.pairs, strict=True
        ):
            if line is None or pair is None:
                response.add_tangent(rows, places, values, exact=exact, damping=damping)
            else:
                pair.side.add_tangent(line.force, line.along, rows, places, values, exact=exact, damping=damping)

    return fill


def solve_for(system: System, now: Iterate, lines: Lines, targets: tuple[Target | None, ...]) -> Step:
    """Return the step towards `targets` with the present factorisation."""
    gradient = np.zeros_like(now.trial.x)
    for response, line, pair, target in zip(now.trial.responses, lines, now.pairs, targets, strict=True):
        if line is None or pair is None or target is None:
            response.add_gradient(gradient)
        else:
            pair.side.add_gradient(line.borne(target), gradient)
    nodes = solve_skew(system, now, lines, -gradient)
    reach = REACH * system.model.diagonal
    longest = float(np.abs(nodes).max())
    rates = tuple(None if pair is None else pair.side.rate(nodes) for pair in now.pairs)
    changes = tuple(
        None if line is None or rate is None or target is None else line.change(rate, target)
        for line, rate, target in zip(lines, rates, targets, strict=True)
    )
    return Step(nodes, rates, changes, min(1.0, reach / longest) if longest > 0.0 else 1.0)


def solve_skew(system: System, now: Iterate, lines: Lines, load: Array) -> Array:
    """Return the step (P, 3) under `load` (P, 3), GMRES taking care of what is not symmetric in the tangent."""
    shape, free = load.shape, ~system.model.fixed

    def left_out(step: Array) -> Array | None:
        total = np.zeros(shape)
        found = [
            pair.side.add_skew(line.along, step, total)
            for pair, line in zip(now.pairs, lines, strict=True)
            if pair is not None and line is not None
        ]
        return total if any(found) else None

    first = system.solve(load)
    if left_out(first) is None:
        return first
    from scipy.sparse.linalg import LinearOperator, gmres

    def apply(vector: Array) -> Array:
        step = vector.reshape(shape)
        skew = left_out(step)
        return vector if skew is None else (step + system.solve(skew)).ravel()

    operator = LinearOperator((load.size, load.size), matvec=apply)
    found, _ = gmres(operator, first.ravel(), x0=first.ravel(), rtol=SKEW_TOLERANCE, restart=SKEW_TURNS, maxiter=1)
    return np.where(free, found.reshape(shape), 0.0)


def move(system: System, now: Iterate, step: Step) -> Iterate:
    """Return the iterate after `step`: every element on its own stays within its bounds."""
    trial = system.evaluate(now.trial.x + step.length * step.nodes, now.trial.travel, now.states)
    responses = (new.reached_from(old) for new, old in zip(trial.responses, now.trial.responses, strict=True))
    trial = replace(trial, responses=tuple(responses))
    pairs: list[Pair | None] = []
    for part, response, state, pair, change in zip(
        system.model.contributions, trial.responses, now.states, now.pairs, step.changes, strict=True
    ):
        side = None if pair is None else part.one_sided(response, state)
        if pair is None or side is None or change is None:
            pairs.append(None)
        else:
            side.follow(pair.side, step.length * step.nodes)
            pairs.append(pair.moved(side, change, step.length))
    return Iterate(trial, now.states, tuple(pairs))
