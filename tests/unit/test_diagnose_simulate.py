"""Runs of the diagnosis: what takes too much is given up, but never the base."""

from __future__ import annotations

import pytest

from etextile.diagnose import simulate
from etextile.diagnose.simulate import run_model
from loadcases.build import build, settings
from loadcases.reader import load_case


def test_a_limited_run_that_takes_too_much_is_a_record_that_ends_early(monkeypatch: pytest.MonkeyPatch) -> None:
    case = load_case("punch", overrides=["wires=null", "fabric.coarsening=60", "motion.steps=12"]).case
    model = build(case).model
    whole = run_model(model, settings(case))
    monkeypatch.setattr(simulate, "MOST_SOLVES", 40)
    assert run_model(model, settings(case)).reach == whole.reach
    short = run_model(model, settings(case), limited=True)
    assert not short.completed
    assert 0.0 < short.reach < whole.reach
    assert short.force[-1] == pytest.approx(whole.force[len(short.force) - 1])
