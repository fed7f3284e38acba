"""The nonlinear solvers by name: `newton` is the interior-point method backed by the damped one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from etextile.registry import Registry
from etextile.solve.interior import applies, interior
from etextile.solve.newton import NewtonOutcome, Settings, newton
from etextile.solve.system import States, System
from etextile.types import Array


NonlinearSolver = Callable[[System, Array, float, States, Settings], NewtonOutcome]


def backed(system: System, x: Array, travel: float, states: States, settings: Settings) -> NewtonOutcome:
    """Return the outcome of the interior-point method, of the damped Newton method where that finds nothing."""
    if not applies(system):
        return newton(system, x, travel, states, settings)
    first = interior(system, x, travel, states, settings)
    if first.converged:
        return first
    second = newton(system, x, travel, states, settings)
    return replace(second, iterations=first.iterations + second.iterations)


NONLINEAR_SOLVERS: Registry[NonlinearSolver] = Registry("nonlinear solver")
NONLINEAR_SOLVERS.register("newton", backed)
NONLINEAR_SOLVERS.register("interior", interior)
NONLINEAR_SOLVERS.register("damped", newton)
