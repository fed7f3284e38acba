"""Fabric that tears does so at the same force in few increments and in many: what yarns bore before a snap is kept."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from etextile.effects.yarn_damage import YarnDamage
from etextile.mechanics.model import Model
from etextile.mechanics.truss import MOST_DAMAGE
from etextile.solve.path import advance
from etextile.types import Array
from loadcases.build import build, settings
from loadcases.reader import load_case


RATE = 10.0
EQUAL_INCREMENTS = 137.9
"""Force (N) at 42.5 mm with 336 equal increments to 52.5 mm and no bound on what they change; 168: 138.2."""


def tearing(coarsening: float) -> Model:
    chosen = ["wires=null", f"fabric.coarsening={coarsening}", "motion.total=42.5", "motion.steps=17"]
    return YarnDamage(RATE, 0.1).apply(build(load_case("punch", overrides=chosen).case).model)


def test_haste_is_the_damage_of_yarns_past_their_peak() -> None:
    """All yarns drawn out evenly to a true strain past their peak, from half of what they then have of damage."""
    model = tearing(60.0)
    block = model.lattice_block
    drawn = block.respond(model.points * math.exp(0.5), 0.0, block.initial_state())
    yarn = int(np.flatnonzero(block.family == 0)[0])
    assert drawn.force[yarn] > 0.0 > drawn.along[yarn]
    law = block.laws[block.law[yarn]]
    before = np.full(len(block.nodes), 0.5 * (law.damage_onset + drawn.plastic[yarn]))
    taken = RATE * (drawn.plastic[yarn] - before[yarn])
    families = [int(np.flatnonzero(block.family == name)[0]) for name in (0, 1)]
    most = max(RATE * (drawn.plastic[one] - before[yarn]) for one in families)
    assert block.haste(drawn, before) == pytest.approx(most / MOST_DAMAGE, rel=1e-12)
    assert block.haste(drawn, before) >= taken / MOST_DAMAGE
    held = block.respond(model.points * math.exp(0.01), 0.0, block.initial_state())
    assert block.haste(held, block.initial_state()) == 0.0


def force(model: Model, steps: int) -> Array:
    """Return the force at 30, 32.5, ... 42.5 mm when outputs are asked for that often."""
    case = load_case("punch").case
    travel = np.arange(1, steps + 1) * 42.5 / steps
    found = {
        round(item.displacement_mm, 9): item.punch_force_N
        for item in advance(replace(model, travel=travel), settings(case))
    }
    return np.array([found[at] for at in np.arange(30.0, 43.0, 2.5)])


@pytest.mark.slow
def test_tearing_fabric_bears_the_same_whatever_the_number_of_increments() -> None:
    """By 42.5 mm a row of yarns has gone; with increments of 2.5 mm throughout the force there is a fifth too low."""
    model = tearing(39.0)
    fine, coarse = force(model, 34), force(model, 17)
    assert fine[-1] < 0.3 * fine.max()
    np.testing.assert_allclose(coarse, fine, rtol=0.0, atol=0.01 * fine.max())
    np.testing.assert_allclose(coarse[-1], EQUAL_INCREMENTS, rtol=0.0, atol=0.01 * fine.max())
