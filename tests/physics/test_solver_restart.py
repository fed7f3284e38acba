"""A run that was stopped goes on from arrays with the digits of a run that was not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from etextile.errors import EtextileError
from etextile.mechanics.model import Model
from etextile.results.restart import flatten, rebuild
from etextile.solve import path
from etextile.solve.newton import NewtonOutcome, Settings
from etextile.solve.path import Increment, Snapshot, advance, start
from etextile.solve.system import System


TRAVEL = (5.0, 10.0, 15.0, 20.0)


def same(a: Increment, b: Increment) -> None:
    assert a.punch_force_N == b.punch_force_N
    np.testing.assert_array_equal(a.positions, b.positions)
    np.testing.assert_array_equal(a.truss_plastic_strain, b.truss_plastic_strain)
    assert a.energy == b.energy
    assert a.verdict == b.verdict


@pytest.mark.parametrize("friction", [0.0, 0.4, np.inf])
def test_a_resumed_run_ends_with_the_same_digits(punch: Callable[..., Model], tmp_path: Path, friction: float) -> None:
    whole = list(advance(punch(travel=TRAVEL, friction=friction)))
    np.savez(tmp_path / "state.npz", **flatten(whole[1].state))
    model = punch(travel=TRAVEL, friction=friction)
    with np.load(tmp_path / "state.npz") as stored:
        snapshot = rebuild(start(model), dict(stored))
    rest = list(advance(model, snapshot=snapshot, first_index=2))
    assert [i.index for i in rest] == [2, 3]
    for a, b in zip(whole[2:], rest, strict=True):
        same(a, b)


def test_the_state_in_the_middle_of_an_increment_resumes_too(
    punch: Callable[..., Model], monkeypatch: pytest.MonkeyPatch
) -> None:
    """After a cut-back the step size is part of the state; here nothing above 3 mm converges."""
    attempt = path._attempt

    def timid(system: System, now: Snapshot, travel: float, settings: Settings) -> NewtonOutcome:
        outcome = attempt(system, now, travel, settings)
        return replace(outcome, converged=outcome.converged and travel - now.travel < 3.0)

    monkeypatch.setattr(path, "_attempt", timid)
    model = punch(travel=(10.0, 20.0))
    whole = list(advance(model))
    assert [i.output for i in whole].count(False) >= 2
    for cut in (0, 1):
        snapshot = rebuild(start(model), flatten(whole[cut].state))
        rest = list(advance(model, snapshot=snapshot, first_index=whole[cut].index))
        assert [i.displacement_mm for i in rest] == [i.displacement_mm for i in whole[cut + 1 :]]
        np.testing.assert_array_equal(whole[-1].positions, rest[-1].positions)


def test_arrays_of_another_model_are_refused(punch: Callable[..., Model]) -> None:
    arrays = flatten(start(punch(coarsening=30.0)))
    with pytest.raises(EtextileError, match="does not belong to this model: x "):
        rebuild(start(punch()), arrays)
    del arrays["states.1.stiffness"]
    with pytest.raises(EtextileError, match=r"states\.1\.stiffness on one side only"):
        rebuild(start(punch(coarsening=30.0)), arrays)
