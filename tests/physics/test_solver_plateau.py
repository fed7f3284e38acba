"""Fabric that yields at almost no force over a long plateau swings about its equilibrium in whole steps of Newton."""

from __future__ import annotations

from dataclasses import replace

from etextile.effects.registry import build_effect
from etextile.solve.path import advance
from loadcases.build import build, settings
from loadcases.reader import load_case


def test_a_fabric_with_a_long_plateau_settles_without_cut_backs() -> None:
    """Diagonals of the high set bear 0.2 MPa up to 2 % strain; a sphere off the centre pushes a whole piece."""
    chosen = [
        "fabric.set=estimated_high", "fabric.coarsening=14.4", "fabric.portion=whole", "wires=null",
        "body.position=[6.79, 11.04]", "contact.friction=0.097", "motion.total=44.17", "motion.steps=20",
    ]  # fmt: skip
    case = load_case("punch", overrides=chosen).case
    model = build_effect("pretension", {"strain": 0.0008}).apply(build(case).model)
    steps = list(advance(replace(model, travel=model.travel[:3]), settings(case)))
    assert [step.verdict.cut_backs for step in steps] == [0, 0, 0]
    assert sum(step.verdict.linear_solves for step in steps) < 120


def test_a_loose_sleeve_bends_without_cut_backs() -> None:
    """Fabric that slides on the skin passes close by equilibria without resting there: that is no reason to give up."""
    chosen = ["fabric.coarsening=52", "fabric.ease=0.1", "supports.ends=[held, free]", "motion.flexion=40",
              "motion.steps=8"]  # fmt: skip
    case = load_case("elbow_sleeve", overrides=chosen).case
    steps = list(advance(build(case).model, settings(case)))
    assert [step.verdict.cut_backs for step in steps] == [0] * 8
    assert sum(step.verdict.linear_solves for step in steps) < 200
