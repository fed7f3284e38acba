"""Equilibrium of one increment by a primal-dual interior-point Newton over slackness and contact.

About 10 steps (`step`) while slack, 4 to 6 once taut; after each one the few nodes that it left worst are settled
apart (`subdomain`).

Nothing of the barrier is left in the answer: it is accepted when the residual of the exact law meets the tolerance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.solve.newton import NewtonOutcome, Settings, measure
from etextile.solve.step import begin, improve, tighten
from etextile.solve.subdomain import settle
from etextile.solve.system import States, System
from etextile.types import Array


PATIENCE = 25
"""Iterations without a smaller residual after which the increment is given up."""
LATELY = 8
"""So many residuals a smaller one has to be smaller than."""
HESITATION = 4
"""Iterations without a smaller residual after which steps are shortened."""
SHORTER, SHORTEST = 0.4, 0.3
"""Factor by which steps are shortened, and their shortest share."""
NEAR = 30.0
"""Limits of contributions (penetration) are tightened once the residual is this many tolerances."""


@dataclass(frozen=True)
class Pace:
    """The last `LATELY` residuals (N), iterations since one was smaller than all of them, and the share of steps taken.

    Fabric that yields at almost no force may swing about its equilibrium in whole steps; shorter ones let it settle.
    What counts is what was lately: loose fabric passes close by an equilibrium long before it comes to rest in one.
    """

    lately: tuple[float, ...] = ()
    since: int = 0
    share: float = 1.0

    def after(self, residual: float) -> Pace:
        """Return the pace after an iteration that left `residual`."""
        lately = (*self.lately, residual)[-LATELY:]
        if residual < min(self.lately, default=np.inf):
            return Pace(lately, 0, min(2.0 * self.share, 1.0))
        since = self.since + 1
        return Pace(lately, since, self.share if since % HESITATION else max(SHORTER * self.share, SHORTEST))


def interior(system: System, x: Array, travel: float, states: States, settings: Settings) -> NewtonOutcome:
    """Find equilibrium at `travel` (mm) from start positions x (P, 3) and the last converged states."""
    now = begin(system, system.evaluate(x, travel, states), states)
    pace, reason = Pace(), "max_iterations"
    for iteration in range(settings.max_iterations + 1):
        residual, tolerance = measure(system, now.trial, settings)
        if residual <= NEAR * tolerance:
            now = tighten(system, now)
            residual, tolerance = measure(system, now.trial, settings)
        if residual <= tolerance:
            return NewtonOutcome(now.trial, True, "converged", iteration, residual, tolerance)
        pace = pace.after(residual)
        if iteration == settings.max_iterations:
            break
        following = improve(system, now, tolerance, pace.share) if pace.since <= PATIENCE else None
        if following is None:
            reason = "stalled"
            break
        now = settle(system, following, tolerance)
    return NewtonOutcome(now.trial, False, reason, iteration, residual, tolerance)


def applies(system: System) -> bool:
    """Whether the lattice itself offers its slackness; else the method has nothing to work with."""
    block = system.model.lattice_block
    state = block.initial_state()
    return block.one_sided(block.respond(system.model.points, 0.0, state), state) is not None
