"""Failure criteria of a user's own, from a Python file that the case names."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from etextile import foreign_code
from etextile.errors import BadInput
from etextile.vocabulary import OPEN, PLASTIC
from loadcases.judging import judge_for
from loadcases.reader import load_case
from wires.coupon import stretched
from wires.failure import CRITERIA


OWN = '''
"""Wires that break all at once at a strain of the fabric."""

from dataclasses import dataclass

from wires.damage import CriterionParameter, bundle_damage


@dataclass(frozen=True)
class AllAtOnce:
    name: str = "NAME"
    summary: str = "all filaments break at one strain"
    parameters: tuple = (CriterionParameter("at", 0.05, "", "estimated", "tests of mine", open_minimum=True),)

    def evaluate(self, history, parameters):
        numbers = {"onset": parameters["at"], "scale": 1e-6, "shape": 1.0, "scatter": 0.0, "filaments": 7.0}
        strain = history.span_strain
        low = 0.0 * strain[0] + 0.01
        return bundle_damage(history, strain, yield_strain=low, criterion=self.name, parameters=numbers)
'''


@pytest.fixture(autouse=True, scope="module")
def code_may_run() -> Iterator[None]:
    with foreign_code.trusting():
        yield


@pytest.fixture(autouse=True)
def registry_as_before(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(CRITERIA, "_items", dict(CRITERIA._items))
    monkeypatch.setattr(CRITERIA, "_files", {})


def own(folder: Path, name: str, *, text: str = OWN) -> Path:
    path = folder / "mine.py"
    path.write_text(text.replace("NAME", name), encoding="utf-8")
    return path


def test_a_criterion_from_a_file_judges_with_the_case_s_numbers(tmp_path: Path) -> None:
    path = own(tmp_path, "all_at_once")
    case = load_case(
        "punch", overrides=["failure.criterion=all_at_once", f"failure.file={path}", "failure.at=9 %"]
    ).case
    parameters = judge_for(case).parameters
    assert parameters["at"] == pytest.approx(0.09)
    found = stretched(np.array([0.05, 0.08, 0.10]), "all_at_once", parameters={"at": parameters["at"]})
    assert found.loop_state.tolist() == [PLASTIC, PLASTIC, OPEN]


@pytest.mark.parametrize(("given", "onset"), [("", 0.05), (", onset: 7 %", 0.07)])
def test_without_an_onset_in_the_case_that_of_the_criterion_holds(tmp_path: Path, given: str, onset: float) -> None:
    path = own(
        tmp_path,
        "with_onset",
        text=OWN.replace('CriterionParameter("at"', 'CriterionParameter("onset"').replace('["at"]', '["onset"]'),
    )
    (tmp_path / "case.yaml").write_text(
        f"schema_version: 1\nextends: punch\nfailure: {{criterion: with_onset, file: {path.name}{given}}}\n"
    )
    case = load_case(tmp_path / "case.yaml").case
    assert judge_for(case).parameters["onset"] == pytest.approx(onset)
    assert case.failure.onset == pytest.approx(onset)


def test_a_changed_file_counts_at_once(tmp_path: Path) -> None:
    first = CRITERIA.load("mine_changes", own(tmp_path, "mine_changes"))
    assert first.parameters[0].default == 0.05
    second = CRITERIA.load("mine_changes", own(tmp_path, "mine_changes", text=OWN.replace("0.05", "0.04")))
    assert second.parameters[0].default == 0.04


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("other", OWN, "defines no criterion 'other'"),
        ("broken", "x = 1\nclass:\n", "mine.py:2"),
        ("broken", "x = 1\ny = x / 0\n", "mine.py:2: cannot be run: ZeroDivisionError"),
        ("lacking", 'class A:\n    name = "lacking"\n', "lacks summary, parameters, evaluate"),
        ("span_strain", OWN.replace("NAME", "span_strain"), "known already"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(tmp_path: Path, name: str, text: str, message: str) -> None:
    path = own(tmp_path, "something", text=text)
    with pytest.raises(BadInput, match=message):
        CRITERIA.load(name, path)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="no such Python file"):
        CRITERIA.load("nowhere", tmp_path / "none.py")
