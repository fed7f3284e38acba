"""Limits of a path that need no simulation: pushing without force, and what withholds a verdict wherever one stands."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from etextile.studies.ensemble.report import conclude_verdict
from etextile.studies.run.limits import Course, check_path, least_work, without_force
from loadcases.build import Built, build
from loadcases.reader import load_case
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
    path = Course(np.arange(1.0, 5.0), np.array(force), nothing, nothing, nothing, nothing, nothing, 0, 0.0)
    assert without_force(path) == found


def test_going_back_and_out_again_is_no_push() -> None:
    """Unloaded to no force and pushed again up to where it was before."""
    travel, force = np.array([1.0, 2.0, 0.5, 1.5]), np.array([1.0, 4.0, 0.0, 0.0])
    nothing = np.zeros(4)
    assert without_force(Course(travel, force, nothing, nothing, nothing, nothing, nothing, 0, 0.0)) == 0


@pytest.fixture(scope="module")
def piece() -> Built:
    return build(load_case("punch", overrides=["fabric.coarsening=58.5"]).case)


def energy_checks(piece: Built, *, work: float, gap: float) -> list[bool]:
    """Whether the energy of a path with that work and gap (N mm) at its end is found in order."""
    nothing, end = np.zeros(2), np.array([0.0, 1.0])
    path = Course(10.0 * end, end, end, nothing, nothing, work * end, gap * end, 0, 0.0)
    return [check.ok for check in check_path(path, piece, piece.case) if check.name == "energy error"]


def fabric_energy(piece: Built, strain: float) -> float:
    """Energy (N mm) of all yarns strained alike: areas under their loading curves, by trapezes dense at the start."""
    block = piece.model.lattice_block
    course = strain * np.linspace(0.0, 1.0, 4001) ** 3
    density = np.array([np.trapezoid(law.loading_curve(course), course) for law in block.laws])
    return float((density[block.law] * block.area * block.rest_length).sum())


def test_the_least_work_is_what_strains_the_whole_fabric_by_a_thousandth(piece: Built) -> None:
    assert least_work(piece.model) == pytest.approx(fabric_energy(piece, 1e-3), rel=1e-4)


@pytest.mark.parametrize("work", [0.0, 1e-6, 0.5, 1.0, 40.0])
def test_energy_that_is_not_found_again_withholds_whatever_the_work_unless_it_could_break_nothing(
    piece: Built, work: float
) -> None:
    least = least_work(piece.model)
    allowed = 0.05 * max(1.0, work) * least
    for sign in (1.0, -1.0):
        assert energy_checks(piece, work=work * least, gap=0.98 * sign * allowed) == [True]
        assert energy_checks(piece, work=work * least, gap=1.02 * sign * allowed) == [False]


def test_energy_that_is_let_pass_could_strain_a_50_000th_of_the_fabric_to_where_filaments_break(piece: Built) -> None:
    assert 0.05 * least_work(piece.model) < fabric_energy(piece, 0.049) / 50_000


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
