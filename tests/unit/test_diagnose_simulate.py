"""Runs of the diagnosis: what takes too much is given up, but never the base."""

from __future__ import annotations

from dataclasses import replace

import pytest

from etextile.diagnose.predict.simulate import (
    EFFORT,
    LEAST,
    LONGER,
    TABLE,
    VERDICT,
    EffectSpec,
    Patience,
    Request,
    affordable,
    run_model,
)
from loadcases.build import build, settings
from loadcases.reader import load_case


def test_a_run_that_takes_too_much_is_a_record_that_ends_early() -> None:
    case = load_case("punch", overrides=["wires=null", "fabric.coarsening=60", "motion.steps=12"]).case
    model = build(case).model
    whole = run_model(model, settings(case))
    assert run_model(model, settings(case), patience=VERDICT).reach == whole.reach
    short = run_model(model, settings(case), patience=Patience(40, 4))
    assert not short.completed
    assert 0.0 < short.reach < whole.reach
    assert short.force[-1] == pytest.approx(whole.force[len(short.force) - 1])
    assert short.solves < whole.solves
    assert affordable(whole) == max(LEAST, EFFORT * whole.solves)


def test_a_patient_run_is_another_run_and_more_patient() -> None:
    law = (100.0, 1.0, 300.0, 1.2)
    request = Request((law, law, law), (EffectSpec.of("clamp_slip", {"limit": 9.0}),), 19.5, 40.0, 24)
    assert request.key("case") != replace(request, patient=True).key("case")
    assert VERDICT.solves > TABLE.solves
    assert VERDICT.cut_backs > TABLE.cut_backs
    bounded = replace(request, solves=900)
    assert bounded.key("case") != request.key("case")
    assert replace(bounded, patient=True).key("case") != replace(request, patient=True).key("case")
    assert TABLE.within(900).solves < VERDICT.within(900, times=LONGER).solves < VERDICT.within(None).solves


def test_a_run_is_given_up_within_an_increment_too() -> None:
    """The increment without an answer is the one that takes longest."""
    case = load_case("punch", overrides=["wires=null", "fabric.coarsening=60", "motion.steps=1"]).case
    lost = run_model(build(case).model, settings(case), patience=Patience(4, 4))
    assert not lost.completed
    assert lost.solves == 8
    assert lost.reach == 0.0
