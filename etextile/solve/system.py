"""A model bound to its pattern and linear solver: evaluates trials, assembles and solves for Newton directions."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from etextile.errors import NoEquilibrium
from etextile.mechanics import kernels
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Energy, Response
from etextile.solve.linear import make_linear_solver
from etextile.solve.pattern import lay_out
from etextile.types import Array, BoolArray


States = tuple[Any, ...]


@dataclass(frozen=True)
class Trial:
    """All contributions at one trial position: x (P, 3) mm, gradient (P, 3) N with reactions, free part masked."""

    x: Array
    travel: float
    responses: tuple[Response, ...]
    gradient: Array
    residual: Array

    @property
    def states(self) -> States:
        """States to carry over when this trial converges."""
        return tuple(response.state for response in self.responses)

    def energy(self) -> Energy:
        """Return the sum of the contributions' energies, N mm."""
        return sum((response.energy() for response in self.responses), Energy())


@dataclass
class WorkCounters:
    """Work done so far: systems factorised, steps of subdomains, right-hand sides solved for, seconds in each part."""

    linear_solves: int = 0
    subdomain_steps: int = 0
    substitutions: int = 0
    factorise_s: float = 0.0
    assemble_s: float = 0.0
    evaluate_s: float = 0.0
    subdomain_s: float = 0.0


class System:
    """Evaluates and linearises a model; holds the pattern, the factorisation and the counters, no trial state."""

    def __init__(self, model: Model, *, linear: str = "auto", most_solves: int | None = None) -> None:
        """Lay out the pattern and analyse it with the named linear solver; `most_solves`: what a path may take."""
        self.model = model
        self.most_solves = most_solves
        self.pattern = lay_out(len(model.points), [part.nodes for part in model.contributions])
        self.solver = make_linear_solver(linear, self.pattern, model.points)
        self.fixed: BoolArray = model.fixed.ravel()
        self.counters = WorkCounters()
        self._values = np.empty(len(self.pattern.indices))

    def evaluate(self, x: Array, travel: float, states: States) -> Trial:
        """Evaluate all contributions at x (P, 3) from the last converged states; no side effect."""
        start = time.perf_counter()
        model = self.model
        responses = tuple(
            part.respond(x, travel, state) for part, state in zip(model.contributions, states, strict=True)
        )
        gradient = np.zeros_like(x)
        for response in responses:
            response.add_gradient(gradient)
        residual = np.where(model.fixed, 0.0, gradient)
        self.counters.evaluate_s += time.perf_counter() - start
        return Trial(x, travel, responses, gradient, residual)

    def direction(self, trial: Trial, damping: float, identity: float, *, exact: bool) -> Array:
        """Return the Newton direction (P, 3) mm; raises NotPositiveDefinite.

        `damping` (N/mm) goes on the unit Laplacian of the trusses, `identity` (N/mm) on the diagonal.
        """

        def fill(values: Array) -> None:
            for response, pairs in zip(trial.responses, self.pattern.pairs, strict=True):
                response.add_tangent(self.pattern.rows, pairs, values, exact=exact, damping=damping)

        self.factorise(fill, identity=identity)
        return self.solve(-trial.residual)

    def factorise(self, fill: Callable[[Array], None], *, identity: float) -> None:
        """Factorise the tangent that `fill` adds to `identity` (N/mm) on the diagonal; raises NotPositiveDefinite.

        Raises NoEquilibrium once the path has taken the most that it may.
        """
        if self.most_solves is not None and self.counters.linear_solves >= self.most_solves:
            raise NoEquilibrium(f"given up after {self.counters.linear_solves} linear solves")
        start = time.perf_counter()
        values, pattern = self._values, self.pattern
        values[:] = 0.0
        values[pattern.rows] = identity
        fill(values)
        kernels.eliminate(self.fixed, pattern.indptr, pattern.indices, values)
        assembled = time.perf_counter()
        self.counters.assemble_s += assembled - start
        self.counters.linear_solves += 1
        try:
            self.solver.factorise(values)
        finally:
            self.counters.factorise_s += time.perf_counter() - assembled

    def solve(self, load: Array) -> Array:
        """Return the step (P, 3) mm under `load` (P, 3) N with the last factorisation; supports do not move."""
        start = time.perf_counter()
        step = self.solver.solve(np.where(self.model.fixed, 0.0, load).ravel())
        self.counters.substitutions += 1
        self.counters.factorise_s += time.perf_counter() - start
        return step.reshape(-1, 3)
