"""Limits of a path that need no simulation: pushing without force, and what withholds a verdict wherever one stands."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from etextile.studies.ensemble.report import conclude_verdict
from etextile.studies.run.limits import Course, without_force
from viz.legend import titled
from wires.sizing_words import sentences
from wires.trust import PROVISIONAL, TrustCheck, exceeded, withheld
from wires.verdict import verdict


@pytest.mark.parametrize(
    ("force", "found"),
    [
        ((1.0, 3.0, 9.0, 20.0), 0),
        ((0.0, 0.0, 2.0, 9.0), 0),  # mounted slack: pushed straight first
        ((1.0, 3.0, 0.0, 0.0), 2),  # the body slipped between the nodes
        ((0.0, 2.0, 0.0, 5.0), 1),
        ((0.0, 0.0, 0.0, 0.0), 4),  # it was between them from the start
    ],
)
def test_pushing_without_force_counts_from_the_first_resistance_on(force: tuple[float, ...], found: int) -> None:
    nothing = np.zeros(4)
    path = Course(np.arange(1.0, 5.0), np.array(force), nothing, nothing, nothing, 0.0, 0, 0.0)
    assert without_force(path) == found


def test_going_back_and_out_again_is_no_push() -> None:
    """Unloaded to no force and pushed again up to where it was before."""
    travel, force = np.array([1.0, 2.0, 0.5, 1.5]), np.array([1.0, 4.0, 0.0, 0.0])
    nothing = np.zeros(4)
    assert without_force(Course(travel, force, nothing, nothing, nothing, 0.0, 0, 0.0)) == 0


LIMIT = TrustCheck("lattice cut over the radius of the body", 0.21, 0.1, "", "lower fabric.coarsening")
WORDS = f"Verdict withheld: {LIMIT.sentence}."


def ensemble_data(over: int = 0) -> dict[str, Any]:
    """What a verdict on 40 samples needs, `over` of them beyond a limit."""
    return {
        "samples": 40, "unit": "mm", "specimen": {"any_failure": {"value": 0.3, "low": 0.2, "high": 0.4}},
        "fragility": {"displacement_mm": [0.0, 20.0]},
        "wires": [{"name": "VCC", "failure_probability": 0.25, "low": 0.1, "high": 0.3}],
        "trust": {"samples_over_limits": over, "limits": {"energy error": over} if over else {}},
    }  # fmt: skip


def test_run_ensemble_and_sizes_withhold_in_the_same_words() -> None:
    said = exceeded([LIMIT])
    assert "0.21 exceeds its limit of 0.1: lower fabric.coarsening" in WORDS
    assert withheld(said) == verdict([], exceeded=said)["sentence"] == WORDS
    data = ensemble_data()
    conclude_verdict(data, said)
    assert data["verdict"] == {"withheld": True, "survive": None, "sentence": WORDS}
    sized = {"per": "loop", "slack_for_all": None, "probability_now": 1.0, "crimp": 0.02, "crimp_now": 0.02}
    assert next(sentences(sized | {"verdict": {"withheld": True, "sentence": withheld(said)}})) == WORDS


@pytest.mark.parametrize(("over", "held"), [(0, False), (2, False), (3, True)])
def test_more_than_a_few_samples_beyond_a_limit_withhold_the_verdict(over: int, *, held: bool) -> None:
    data = ensemble_data(over)
    conclude_verdict(data, [])
    assert data["verdict"]["withheld"] is held
    assert data["verdict"]["survive"] is (None if held else False)
    words = "3 of 40 samples passed a trust limit (energy error)" if held else "30.0 % (95 %: 20.0 % to 40.0 %)"
    assert words in data["verdict"]["sentence"]


def test_a_picture_says_that_it_is_provisional_before_the_title_of_the_case() -> None:
    """Long titles are cut at their end."""
    assert titled("Failure map", "Elbow") == "Failure map: Elbow"
    assert titled("Failure map", "Elbow", provisional=True) == f"Failure map ({PROVISIONAL}): Elbow"
