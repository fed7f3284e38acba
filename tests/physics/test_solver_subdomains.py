"""Settling a subdomain changes no answer: it is a part of the same lattice, and the whole has a residual of its own."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from etextile.mechanics.model import Model
from etextile.solve import interior
from etextile.solve.newton import Settings
from etextile.solve.path import Increment, advance, start
from etextile.solve.step import Iterate, begin, improve
from etextile.solve.subdomain import around, cut, put_back, settle, taken
from etextile.solve.system import System
from loadcases.build import build
from loadcases.reader import load_case


TRAVEL = 2.5


def punch(coarsening: float, *more: str) -> Model:
    """Return a quarter of the punch in increments of 2.5 mm to 10 mm."""
    chosen = [f"fabric.coarsening={coarsening}", "motion.total=10", "motion.steps=4", *more]
    return build(load_case("punch", overrides=chosen).case).model


def after_a_step(model: Model) -> tuple[System, Iterate]:
    """Return a system and its iterate after one step of the first increment."""
    system, first = System(model), start(model)
    x = np.where(model.fixed, model.prescribed(TRAVEL), model.points)
    for part in model.contributions:
        x = part.carried_along(x, TRAVEL, first.x, 0.0)
    begun = begin(system, system.evaluate(x, TRAVEL, first.states), first.states)
    now = improve(system, begun, 1e-4, 1.0)
    assert now is not None
    return system, now


def forces_and_solves(steps: Iterable[Increment]) -> list[tuple[float, int]]:
    """Return punch force and linear solves of each increment."""
    return [(found.punch_force_N, found.verdict.linear_solves) for found in steps]


@pytest.mark.parametrize("friction", ["0", "stick"])
def test_a_subdomain_has_the_residual_of_the_whole(friction: str) -> None:
    """Nodes that move in a subdomain feel all their elements; wires that cross it are cut with it."""
    system, now = after_a_step(punch(6.0, f"contact.friction={friction}"))
    moving = np.zeros(len(system.model.points), dtype=bool)
    moving[100:140] = True
    subdomain = cut(system, moving)
    assert subdomain is not None
    found = taken(subdomain, now).trial.residual
    assert np.abs(now.trial.residual[moving]).max() > 0.0
    assert found[moving[subdomain.nodes]] == pytest.approx(now.trial.residual[moving], rel=1e-12, abs=1e-12)
    assert not found[~moving[subdomain.nodes]].any()


def test_a_subdomain_put_back_untouched_is_the_whole() -> None:
    """Cutting out and putting back moves nothing."""
    system, now = after_a_step(punch(6.0))
    moving = around(system, np.eye(len(system.model.points), 3))
    assert moving is not None
    subdomain = cut(system, moving)
    assert subdomain is not None
    again = put_back(system, now, subdomain, taken(subdomain, now))
    assert np.array_equal(again.trial.x, now.trial.x)
    for pair, new in zip(now.pairs, again.pairs, strict=True):
        assert np.array_equal(pair.stretch, new.stretch)
        assert pair.force == pytest.approx(new.force, rel=1e-12)


def test_faults_all_over_the_lattice_are_no_subdomain() -> None:
    """When every node is at fault the whole has to be solved."""
    system = System(punch(6.0))
    assert around(system, np.ones_like(system.model.points)) is None
    assert around(system, np.zeros_like(system.model.points)) is None


def test_coulomb_friction_is_not_cut() -> None:
    """What slides remembers its way within a solve: such a contact stays whole, and so does the step."""
    system, now = after_a_step(punch(6.0, "contact.friction=0.3"))
    assert settle(system, now, 1e-4) is now


@pytest.mark.slow
def test_patches_save_solves_and_change_no_force(monkeypatch: pytest.MonkeyPatch) -> None:
    """Slack fabric to 10 mm with and without subdomains."""
    model = punch(4.0, "wires=null", "motion.total=5", "motion.steps=2")
    system = System(model)
    with_subdomains = [
        (step.punch_force_N, step.verdict.linear_solves) for step in advance(model, Settings(), system=system)
    ]
    assert system.counters.subdomain_steps > 0
    monkeypatch.setattr(interior, "settle", lambda system, now, tolerance: now)
    without = forces_and_solves(advance(model, Settings()))
    assert [force for force, _ in with_subdomains] == pytest.approx([force for force, _ in without], rel=1e-4)
    assert sum(solves for _, solves in with_subdomains) < sum(solves for _, solves in without)
