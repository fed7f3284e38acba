"""Equilibrium of one increment: Newton on the incremental energy, damped where the fabric is floppy.

The energy of tension-only trusses is convex wherever force does not fall with length, but flat and slack fabric has no
stiffness at all. Each direction therefore solves with the tangent plus `damping` times the unit Laplacian of the truss
graph, damping = grip x largest residual: a proximal step in the fabric's own metric, which lets smooth motion pass at
any coarsening, vanishes with the residual and leaves nothing in the answer. A line search brings the derivative of the
energy along the direction near zero; `grip` falls after full steps and rises after short ones.

It is the fallback of the interior-point method, slower by far while fabric is slack, but sure to go down in energy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from etextile.errors import NotPositiveDefinite
from etextile.solve.system import States, System, Trial
from etextile.types import Array


FORCE_FLOOR = 1e-4
"""Residual that counts as none, N."""


@dataclass(frozen=True)
class Settings:
    """Solver settings: relative tolerance, absolute floor N, iterations of one increment, cut-backs, linear solver."""

    tolerance: float = 1e-6
    force_floor: float = FORCE_FLOOR
    max_iterations: int = 150
    max_cut_backs: int = 8
    linear: str = "auto"
    nonlinear: str = "newton"


@dataclass(frozen=True)
class NewtonOutcome:
    """Where Newton ended: the trial, whether it is converged, why it stopped, and the numbers behind that."""

    trial: Trial
    converged: bool
    reason: str
    iterations: int
    residual: float
    tolerance: float


@dataclass(frozen=True)
class Point:
    """A trial along a direction: its step length and the derivative of the energy there, N mm."""

    length: float
    trial: Trial
    slope: float


SLOPE_GOAL = 0.1
MAX_SEARCH = 12
GRIP_START, GRIP_MIN, GRIP_DOWN, GRIP_UP = 0.1, 1e-2, 0.1, 4.0
LEAST_DAMPING, MOST_DAMPING, IDENTITY = 1e-8, 1e2, 1e-9
REACH = 0.02
"""Longest step of a node as a share of the diagonal of the piece."""


def newton(system: System, x: Array, travel: float, states: States, settings: Settings) -> NewtonOutcome:
    """Find equilibrium at `travel` (mm) from start positions x (P, 3) and the last converged states."""
    scale = system.model.typical_stiffness
    reach = REACH * system.model.diagonal
    trial = system.evaluate(x, travel, states)
    grip = GRIP_START
    for iteration in range(settings.max_iterations + 1):
        residual, tolerance = measure(system, trial, settings)
        if residual <= tolerance:
            return NewtonOutcome(trial, True, "converged", iteration, residual, tolerance)
        if iteration == settings.max_iterations or not np.isfinite(residual):
            break
        damping = grip * float(np.abs(trial.residual).max())
        damping = min(max(damping, LEAST_DAMPING * scale), MOST_DAMPING * scale)
        step = descend(system, trial, damping, scale)
        if step is None:
            return NewtonOutcome(trial, False, "stalled", iteration, residual, tolerance)
        step *= min(1.0, reach / float(np.abs(step).max()))
        point = search(system, trial, step, travel, states)
        if point.length == 1.0:
            grip = max(GRIP_DOWN * grip, GRIP_MIN)
        elif point.length < 0.5:
            grip *= GRIP_UP
        trial = point.trial
    return NewtonOutcome(trial, False, "max_iterations", iteration, residual, tolerance)


def measure(system: System, trial: Trial, settings: Settings) -> tuple[float, float]:
    """Return the residual (2-norm, N) and what is tolerated: relative to the reactions, with an absolute floor."""
    residual = size(trial.residual)
    reactions = size(trial.gradient[system.model.fixed])
    return residual, settings.tolerance * reactions + settings.force_floor


def size(values: Array) -> float:
    """Return the 2-norm, summed in one order on any number of threads."""
    return math.sqrt(float(np.square(values).sum()))


def descend(system: System, trial: Trial, damping: float, scale: float) -> Array | None:
    """Return a descent direction (P, 3): exact tangent if positive definite, else its convex part, else damped more."""
    exact = True
    for _ in range(12):
        try:
            step = system.direction(trial, damping, IDENTITY * scale, exact=exact)
        except NotPositiveDefinite:
            pass
        else:
            if np.all(np.isfinite(step)) and float(np.vdot(trial.residual, step)) < 0.0:
                return step
        if not exact:
            damping *= 10.0
        exact = False
    return None


def search(system: System, trial: Trial, step: Array, travel: float, states: States) -> Point:
    """Return a point along `step` where the energy's derivative has fallen to a tenth, by bracketed regula falsi."""
    start = float(np.vdot(trial.residual, step))

    def at(length: float) -> Point:
        there = system.evaluate(trial.x + length * step, travel, states)
        slope = float(np.vdot(there.residual, step))
        return Point(length, there, slope if np.isfinite(slope) else np.inf)

    point = at(1.0)
    low, low_slope, high = 0.0, start, point
    for turn in range(MAX_SEARCH):
        if point.slope <= SLOPE_GOAL * abs(start) and (point.length == 1.0 or point.slope >= SLOPE_GOAL * start):
            break
        width = high.length - low
        length = low - low_slope * width / (high.slope - low_slope) if turn % 3 != 2 else low + 0.5 * width
        point = at(min(max(length, low + 0.1 * width), high.length - 0.1 * width))
        if point.slope > 0.0:
            high = point
        else:
            low, low_slope = point.length, point.slope
    return point
