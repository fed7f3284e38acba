"""Steps with the convex part of the tangent end where the energy falls or rises gently, however long they were."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from etextile.solve.path import advance, predict
from etextile.solve.step import begin, linearise, move, not_beyond, solve_for
from etextile.solve.system import System
from loadcases.build import build, settings
from loadcases.reader import load_case


def test_a_step_far_beyond_the_least_energy_is_shortened_and_a_good_one_is_left() -> None:
    case = load_case("tension_warp", overrides=["fabric.coarsening=39", "wires=null"])
    model = build(case.case).model
    snapshot = next(advance(model, settings(case.case))).state
    system = System(model)
    x = predict(system, snapshot, model.travel[1])
    now = begin(system, system.evaluate(x, model.travel[1], snapshot.states), snapshot.states)
    found = linearise(system, replace(now, caution=3))
    assert found is not None
    step = solve_for(system, found)
    begun = float(np.vdot(found.trial.residual, step.nodes))
    assert begun < 0.0  # downhill

    longer = replace(step, length=64.0 * step.length)
    too_far = move(system, found, longer)
    assert float(np.vdot(too_far.trial.residual, step.nodes)) > abs(begun)
    shortened = not_beyond(system, found, longer, too_far)
    assert float(np.vdot(shortened.trial.residual, step.nodes)) <= abs(begun)

    usual = move(system, found, replace(step, length=0.01 * step.length))
    assert not_beyond(system, found, step, usual) is usual
