"""Which effects take part in a diagnosis: the library, those of files and of installed packages."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from etextile import foreign_code, plugins
from etextile.effects import user
from etextile.effects.registry import EFFECTS
from etextile.studies.diagnose.setting import DiagnosisTask, assemble
from loadcases.measurements import load_measurements
from loadcases.reader import load_case
from loadcases.shipped import measured_folder


PAGE = Path(__file__).parents[2] / "etextile" / "manual" / "howto" / "own_effect.md"
MEASURED = load_measurements(measured_folder("hidden_clamp"))
CASE = """schema_version: 1
extends: punch
title: With an effect of my own
effects:
  - {id: cracked_coating, file: coating.py, share: 0}
"""


@pytest.fixture(autouse=True, scope="module")
def code_may_run() -> Iterator[None]:
    with foreign_code.trusting():
        yield


@pytest.fixture
def coating(tmp_path: Path) -> Path:
    """The effect that the manual shows."""
    blocks = re.findall(r"````{file} \w+.py\n(.*?)````", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    path = tmp_path / "coating.py"
    path.write_text(next(block for block in blocks if "class CrackedCoating" in block))
    return path


@pytest.fixture
def fresh_entry_points() -> Iterator[None]:
    user.from_entry_points.cache_clear()
    yield
    user.from_entry_points.cache_clear()


def names(task: DiagnosisTask) -> dict[str, str]:
    """Return the files of the candidates by name."""
    return {item.card.id: item.file for item in task.setting.candidates}


def test_the_whole_library_takes_part_where_it_makes_sense() -> None:
    task = assemble(load_case("punch"), MEASURED, own_fabric=True)
    assert set(names(task)) == set(EFFECTS)
    assert [text for text in task.restrictions if "coupons" not in text] == []


def test_every_limit_of_the_choice_is_said() -> None:
    task = assemble(load_case("punch"), MEASURED, among=("clamp_slip",), own_fabric=True)
    first, second = task.restrictions
    assert first.startswith("only clamp_slip could be named (--among); ")
    assert all(name in first for name in EFFECTS)
    assert "coupons" in second
    assert len(assemble(load_case("punch"), MEASURED, own_fabric=True).restrictions) == 1


def test_a_file_given_to_the_verb_takes_part(coating: Path) -> None:
    task = assemble(load_case("punch"), MEASURED, effects=(coating,), own_fabric=True)
    assert names(task)["cracked_coating"] == str(coating)
    assert len(names(task)) == len(EFFECTS) + 1


def test_a_file_that_the_case_names_takes_part(coating: Path) -> None:
    path = coating.with_name("case.yaml")
    path.write_text(CASE)
    assert Path(names(assemble(load_case(path), MEASURED, own_fabric=True))["cracked_coating"]) == coating


def test_an_installed_effect_takes_part(
    coating: Path, fresh_entry_points: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(coating.parent)
    point = EntryPoint("cracked_coating", "coating:CrackedCoating", user.GROUP)
    monkeypatch.setattr(plugins, "entry_points", lambda group: [point])
    assert names(assemble(load_case("punch"), MEASURED, own_fabric=True))["cracked_coating"] == ""


def test_runs_of_a_changed_file_are_not_taken_for_those_before(coating: Path) -> None:
    first = assemble(load_case("punch"), MEASURED, effects=(coating,), own_fabric=True)
    coating.write_text(coating.read_text().replace("1.0 - self.share", "1.0 - 0.5 * self.share"))
    second = assemble(load_case("punch"), MEASURED, effects=(coating,), own_fabric=True)
    assert first.simulator.fingerprint != second.simulator.fingerprint


def test_wires_and_travel_share_their_runs_friction_does_not() -> None:
    def fingerprint(*overrides: str) -> str:
        return assemble(load_case("punch", overrides=overrides), MEASURED, own_fabric=True).simulator.fingerprint

    plain = fingerprint()
    assert plain == fingerprint("wires=null") == fingerprint("motion.total=45") == fingerprint("title=other")
    assert plain != fingerprint("contact.friction=0.2")
    assert plain != fingerprint("fabric.size=[100, 90]")
