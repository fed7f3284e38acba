"""Energy balance, derivatives of the energy, symmetry of the specimen: what holds at every increment of a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from etextile.contact.body import Distance
from etextile.contact.contact import Contact
from etextile.contact.pose import place
from etextile.contact.sphere import Sphere
from etextile.contact.trial import ContactState
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Contribution
from etextile.motion.straight import Straight
from etextile.solve.path import advance
from etextile.solve.system import System
from etextile.types import Array


def energy_error(model: Model, increments: int) -> float:
    *_, last = advance(replace(model, travel=np.linspace(0.0, 25.0, increments + 1)[1:]))
    return last.energy.error


def test_the_error_of_the_energy_balance_falls_with_the_square_of_the_step_or_faster(
    punch: Callable[..., Model],
) -> None:
    coarse, fine = (energy_error(punch(), increments) for increments in (5, 20))
    assert coarse < 0.05
    assert fine < coarse / 16.0


def test_quarter_half_and_whole_are_the_same_specimen(punch: Callable[..., Model]) -> None:
    """Within what the penetration, whose stiffness is raised on the way, leaves open: 0.02 mm of 12."""
    runs = []
    for portion in ("quarter", "half", "whole"):
        model = punch(travel=(6.0, 12.0), portion=portion)
        *_, last = advance(model)
        runs.append((last.punch_force_N, last.truss_strain.max(), last.energy.plastic * model.force_factor))
    assert runs[0] == pytest.approx(runs[1], rel=1e-3)
    assert runs[0] == pytest.approx(runs[2], rel=1e-3)


@dataclass(frozen=True)
class Table:
    """The half space z < 0: on a flat body the normal does not turn, so friction has an energy while it sticks."""

    def distance(self, points: Array) -> Distance:
        count = len(points)
        return Distance(points[:, 2].copy(), np.tile([0.0, 0.0, 1.0], (count, 1)), np.zeros((count, 3, 3)))

    def surface(self) -> tuple[Array, Array]:
        raise NotImplementedError

    def bounds(self) -> Array:
        return np.array([[-100.0, -100.0, -100.0], [100.0, 100.0, 0.0]])

    def support(self, direction: Array) -> float:
        raise NotImplementedError


def trusses(punch: Callable[..., Model]) -> tuple[Model, Contribution, Any]:
    """Trusses of a coarse lattice, some of them stretched plastically before."""
    model = replace(punch(coarsening=45.0), contributions=punch(coarsening=45.0).contributions[:1])
    count = len(model.contributions[0].nodes)
    return model, model.contributions[0], np.random.default_rng(1).uniform(0.0, 0.05, count)


def pressed(punch: Callable[..., Model]) -> tuple[Model, Contribution, Any]:
    """Nodes around the top of the sphere, without friction."""
    model = punch(coarsening=45.0)
    nodes = np.arange(len(model.points))[:, None]
    contact = Contact(nodes, np.ones(len(nodes)), place(Sphere(60.0)), Straight(model.direction), 0.0, 0.02, 30.0)
    return replace(model, contributions=(contact,)), contact, contact.initial_state()


def stuck(punch: Callable[..., Model]) -> tuple[Model, Contribution, Any]:
    """Nodes pressed on a table that stick, pulled sideways from their anchors."""
    model = punch(coarsening=45.0)
    count = len(model.points)
    contact = Contact(np.arange(count)[:, None], np.ones(count), Table(), Straight(np.zeros(3)), 50.0, 0.02, 30.0)
    state = ContactState(30.0, model.points + np.array([0.05, -0.03, 0.0]), np.ones(count, dtype=bool))
    return replace(model, contributions=(contact,)), contact, state


@pytest.mark.parametrize("part", [trusses, pressed, stuck], ids=lambda part: part.__name__)
def test_gradient_and_tangent_are_derivatives_of_the_energy(punch: Callable[..., Model], part: Any) -> None:
    """Taylor test: what the first (second) derivative leaves of the energy (gradient) falls with the square."""
    model, contribution, state = part(punch)
    model = replace(model, contributions=(contribution,), fixed=np.zeros_like(model.fixed))
    random = np.random.default_rng(0)
    sink = {"trusses": 0.0, "pressed": -1.0, "stuck": -1.0}[part.__name__]
    x = model.points * 1.03 + random.uniform(-0.2, 0.2, model.points.shape) + np.array([0.0, 0.0, sink])
    step = random.uniform(-1.0, 1.0, x.shape)
    system = System(model, linear="superlu")

    def at(size: float) -> tuple[float, Array]:
        trial = system.evaluate(x + size * step, 0.0, (state,))
        energy = trial.energy()
        return energy.stored + energy.plastic + energy.contact, trial.gradient

    values = np.zeros(len(system.pattern.indices))
    response = contribution.respond(x, 0.0, state)
    response.add_tangent(system.pattern.rows, system.pattern.pairs[0], values, exact=True, damping=0.0)
    upper = system.pattern.matrix(values).toarray()
    tangent = upper + np.triu(upper, 1).T
    energy, gradient = at(0.0)
    sizes = 2e-3, 1e-3
    first = [abs(at(h)[0] - energy - h * float(np.vdot(gradient, step))) for h in sizes]
    second = [np.linalg.norm((at(h)[1] - gradient).ravel() - h * tangent @ step.ravel()) for h in sizes]
    assert abs(float(np.vdot(gradient, step))) > 0.0
    assert first[1] < first[0] / 3.5
    assert second[1] < max(second[0] / 3.5, 1e-9 * float(np.linalg.norm(tangent @ step.ravel())))


def test_a_dragged_node_bears_the_elastic_stick_and_then_coulombs_limit(punch: Callable[..., Model]) -> None:
    """Pressed by P on a table and dragged by u: min(k u, mu P) against the drag; the anchor follows the slip."""
    stiffness, depth, friction = 30.0, 0.01, 0.4
    contact = Contact(
        np.zeros((1, 1), dtype=np.int64), np.ones(1), Table(), Straight(np.zeros(3)), friction, 0.02, stiffness
    )
    state = ContactState(stiffness, np.array([[0.0, 0.0, -depth]]), np.ones(1, dtype=bool))
    limit = friction * stiffness * depth
    for drag in (0.5 * limit / stiffness, 3.0 * limit / stiffness):
        response = contact.respond(np.array([[drag, 0.0, -depth]]), 0.0, state)
        wanted = min(stiffness * drag, limit)
        assert response.forces[0] == pytest.approx([-wanted, 0.0, stiffness * depth])
        assert response.state.anchor[0, 0] == pytest.approx(drag - wanted / stiffness)
        assert response.energy().friction == pytest.approx(limit * max(drag - limit / stiffness, 0.0))
