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

from etextile.errors import NotPositiveDefinite
from etextile.solve.barrier import Pair
from etextile.solve.member import Member, Step, members_of
from etextile.solve.newton import REACH
from etextile.solve.system import States, System, Trial
from etextile.types import Array


WIDTH = 1e-3
"""Strain of a typical truss that gives the first mu."""
LAPLACIAN, IDENTITY = 1e-8, 1e-9
"""Regularisation, as shares of the typical stiffness."""
CAUTION = 3
"""Steps taken with the convex part of the tangent at once after the exact one was not positive definite."""
SKEW_TOLERANCE, SKEW_TURNS = 1e-4, 40
"""Relative tolerance and most substitutions of GMRES where friction makes the tangent unsymmetric: a step that is a
hundredth off puts pressed nodes of loose fabric into the body, each time anew."""


@dataclass(frozen=True)
class Iterate:
    """A trial and its members.

    `caution`: for how many steps the exact tangent is not tried, since a step before it was not positive definite.
    """

    trial: Trial
    members: tuple[Member, ...]
    caution: int = 0

    @property
    def states(self) -> States:
        """The states that the trial starts from."""
        return tuple(member.state for member in self.members)

    @property
    def pairs(self) -> tuple[Pair | None, ...]:
        """The pairs of one-sided members, None for the others."""
        return tuple(member.pair for member in self.members)


def begin(system: System, trial: Trial, states: States) -> Iterate:
    """Return the first iterate, all pairs centred at the mu of a typical truss strained by WIDTH."""
    length = WIDTH * float(np.median(system.model.lattice_block.rest_length))
    mu = system.model.typical_stiffness * length**2
    return Iterate(trial, tuple(member.centred(mu) for member in members_of(system, trial, states)))


def tighten(system: System, now: Iterate) -> Iterate:
    """Return the iterate with stricter states where contributions ask for them, pairs centred again where they are."""
    states = tuple(member.tightened() for member in now.members)
    if all(state is member.state for state, member in zip(states, now.members, strict=True)):
        return now
    trial = system.evaluate(now.trial.x, now.trial.travel, states)
    after = zip(now.members, members_of(system, trial, states), strict=True)
    return Iterate(trial, tuple(member.again(new) for member, new in after), now.caution)


def improve(system: System, now: Iterate, tolerance: float, share: float) -> Iterate | None:
    """Return the next iterate by one factorisation, a predictor and `share` of a corrector; None without direction."""
    found = linearise(system, now)
    if found is None:
        return None
    guess = solve_for(system, found)
    aimed = replace(found, members=tuple(member.aimed(guess, tolerance) for member in found.members))
    step = solve_for(system, aimed)
    if not np.all(np.isfinite(step.nodes)):
        return None
    return move(system, aimed, replace(step, length=share * step.length))


def linearise(system: System, now: Iterate) -> Iterate | None:
    """Factorise the tangent: exact if it is positive definite, else its convex part, else with more on the diagonal.

    Returns the iterate with its members linearised and the caution of the next step: a fabric that folds goes on
    folding, and a factorisation that fails costs as much as one that does not.
    """
    scale = system.model.typical_stiffness
    for exact, more in ((True, 1.0), (False, 1.0), (False, 1e3), (False, 1e6)):
        if exact and now.caution:
            continue
        members = tuple(member.linearised(exact=exact) for member in now.members)
        try:
            system.factorise(_filler(system, members, exact=exact, more=more), identity=more * IDENTITY * scale)
        except NotPositiveDefinite:
            continue
        return Iterate(now.trial, members, 0 if exact else now.caution - 1 if now.caution else CAUTION)
    return None


def _filler(system: System, members: tuple[Member, ...], *, exact: bool, more: float) -> Callable[[Array], None]:
    """Return what adds all tangents to the values of the pattern."""
    damping = more * LAPLACIAN * system.model.typical_stiffness

    def fill(values: Array) -> None:
        for member in members:
            member.add_tangent(system.pattern.rows, values, exact=exact, damping=damping)

    return fill


def solve_for(system: System, now: Iterate) -> Step:
    """Return the step towards what the members aim at, with the present factorisation."""
    gradient = np.zeros_like(now.trial.x)
    for member in now.members:
        member.add_gradient(gradient)
    nodes = solve_skew(system, now.members, -gradient)
    reach = REACH * system.model.diagonal
    longest = float(np.abs(nodes).max())
    return Step(nodes, min(1.0, reach / longest) if longest > 0.0 else 1.0)


def solve_skew(system: System, members: tuple[Member, ...], load: Array) -> Array:
    """Return the step (P, 3) under `load` (P, 3), GMRES taking care of what is not symmetric in the tangent."""
    shape, free = load.shape, ~system.model.fixed

    def left_out(step: Array) -> Array | None:
        total = np.zeros(shape)
        found = [member.add_skew(step, total) for member in members]
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
    after = zip(now.members, members_of(system, trial, now.states), strict=True)
    return Iterate(trial, tuple(member.moved(new, step) for member, new in after), now.caution)
