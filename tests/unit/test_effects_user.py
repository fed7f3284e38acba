"""A user's own effect: one Python file named in the case, or a class in an installed package."""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest

from etextile import foreign_code, plugins
from etextile.app.cli import main
from etextile.effects import user
from etextile.effects.change import lattice_block
from etextile.effects.registry import EFFECTS, build_effect, check_effect, with_effects
from etextile.effects.user import from_entry_points
from etextile.errors import BadInput
from loadcases.build import build
from loadcases.reader import load_case


OWN = '''
"""Yarns of uneven thickness: every other warp truss is thinner, every one between thicker."""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.change import lattice_block, with_lattice_block
from etextile.lattice.weave import WARP


@dataclass(frozen=True)
class UnevenYarns(Effect):
    """Relative difference of neighbouring warp trusses."""

    scatter: float = 0.0

    stage: ClassVar[Stage] = Stage.REST
    card: ClassVar[Card] = Card(
        id="uneven_yarns",
        mechanism="Yarns are of uneven thickness.",
        parameters=(Parameter("scatter", "", 0.0, 0.9, "the relative difference in area"),),
        example=Example({"scatter": 0.1}),
        signature=(Signature("punch_force", 0, 0.0, "little"),),
    )

    def transform(self, model):
        block = lattice_block(model)
        sign = np.where(np.arange(len(block.area)) % 2 == 0, 1.0, -1.0)
        area = block.area * np.where(block.family == WARP, 1.0 + self.scatter * sign, 1.0)
        return with_lattice_block(model, replace(block, area=area))
'''

CASE = """schema_version: 1
extends: punch
title: With an effect of my own
wires: null
fabric: {coarsening: 60}
motion: {total: 10 mm, steps: 2}
effects:
  - {id: uneven_yarns, file: mine.py, scatter: 20 %}
"""


@pytest.fixture(autouse=True, scope="module")
def code_may_run() -> Iterator[None]:
    with foreign_code.trusting():
        yield


@pytest.fixture
def case(tmp_path: Path) -> Path:
    (tmp_path / "mine.py").write_text(OWN)
    (tmp_path / "case.yaml").write_text(CASE)
    return tmp_path / "case.yaml"


def test_an_effect_from_a_file_beside_the_case_changes_the_model(case: Path) -> None:
    loaded = load_case(case)
    assert loaded.case.effects[0].parameters["scatter"] == pytest.approx(0.2)
    changed = build(loaded.case).model
    plain = build(loaded.case.model_copy(update={"effects": ()})).model
    ratio = lattice_block(changed).area / lattice_block(plain).area
    np.testing.assert_allclose(sorted(set(np.round(ratio, 9))), [0.8, 1.0, 1.2])


def test_the_hash_of_the_case_follows_the_content_of_the_file_and_not_its_place(case: Path, tmp_path: Path) -> None:
    before = load_case(case).sha256
    moved = tmp_path / "elsewhere"
    moved.mkdir()
    for name in ("mine.py", "case.yaml"):
        (moved / name).write_bytes((tmp_path / name).read_bytes())
    assert load_case(moved / "case.yaml").sha256 == before
    (moved / "mine.py").write_text(OWN.replace("1.0 + self.scatter", "1.0 + 2.0 * self.scatter"))
    assert load_case(moved / "case.yaml").sha256 != before


def test_its_numbers_are_checked_like_any_other(case: Path) -> None:
    case.write_text(CASE.replace("20 %", "95 %"))
    with pytest.raises(BadInput, match=r"effects.0.scatter: out of range \(got '95 %'\), must be 0 to 0.9"):
        load_case(case)


@pytest.mark.parametrize(
    ("text", "key", "words"),
    [
        ("x = 1", "id", "mine.py has no effect 'uneven_yarns', it holds no class derived from"),
        (OWN.replace('id="uneven_yarns"', 'id="uneven_yarn"'), "id", "did you mean 'uneven_yarn'?"),
        (OWN.replace('Parameter("scatter"', 'Parameter("spread"'), "file", "make them equal"),
        (OWN.replace("card: ClassVar[Card] =", "sheet: ClassVar[Card] ="), "file", "has no card"),
    ],
)
def test_a_file_that_cannot_serve_says_why(case: Path, text: str, key: str, words: str) -> None:
    (case.parent / "mine.py").write_text(text)
    with pytest.raises(BadInput) as caught:
        load_case(case)
    problem = caught.value.problems[0]
    assert problem.key == f"effects.0.{key}"
    assert words in problem.message
    assert problem.line == 8


def test_a_file_that_fails_is_named_with_its_line(case: Path) -> None:
    (case.parent / "mine.py").write_text("x = 1\ny = x / 0\n")
    with pytest.raises(BadInput, match=r"mine\.py:2: cannot be run: ZeroDivisionError"):
        load_case(case)


def test_a_transform_that_fails_is_no_fault_of_the_program(
    case: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (case.parent / "mine.py").write_text(OWN.replace("block.area * np.where", "block.aera * np.where"))
    assert main(["run", str(case), "-o", str(tmp_path / "out"), "--allow-code", "--quiet"]) == 2
    said = capsys.readouterr().err
    assert re.search(
        r"mine\.py:\d+: transform fails: AttributeError: 'TrussBlock' object has no attribute 'aera'", said
    )
    assert "fault of the program" not in said


def test_check_shows_parameters_file_and_hash(case: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(case), "--allow-code"]) == 0
    said = capsys.readouterr().out
    assert "uneven_yarns, scatter 0.2" in said
    assert re.search(r"effects\.0\.file runs .*mine\.py, sha256 [0-9a-f]{64}", said)


def test_what_an_effect_leaves_undetermined_has_to_be_something_measured(case: Path) -> None:
    text = OWN.replace("Signature, Stage\n", "Signature, Stage, Undetermined\n")
    said = '        undetermined=(Undetermined("free_edge", "hight", 1.0),),\n        mechanism='
    (case.parent / "mine.py").write_text(text.replace("        mechanism=", said), encoding="utf-8")
    with pytest.raises(BadInput, match=r"'hight' of 'free_edge'.*warp, weft, height"):
        load_case(case)


def test_a_changed_file_is_read_again(case: Path) -> None:
    file = case.parent / "mine.py"
    assert check_effect("uneven_yarns", {"file": str(file), "scatter": 0.5}) == {"scatter": 0.5}
    file.write_text(OWN.replace("0.9", "0.4"))
    with pytest.raises(BadInput, match="out of range"):
        check_effect("uneven_yarns", {"file": str(file), "scatter": 0.5})
    assert not list(file.parent.glob("__pycache__/mine*"))


def test_an_installed_effect_is_found_by_its_entry_point(case: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(case.parent)
    point = EntryPoint("uneven_yarns", "mine:UnevenYarns", user.GROUP)
    monkeypatch.setattr(plugins, "entry_points", lambda group: [point] if group == user.GROUP else [])
    from_entry_points.cache_clear()
    try:
        assert build_effect("uneven_yarns", {"scatter": 0.1}).values == {"scatter": 0.1}
        with pytest.raises(BadInput, match="did you mean 'uneven_yarns'"):
            build_effect("uneven_yarn", {"scatter": 0.1})
        assert "uneven_yarns" not in EFFECTS
    finally:
        from_entry_points.cache_clear()


def test_a_broken_installed_effect_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    point = EntryPoint("ghost", "no_such_package:Ghost", user.GROUP)
    monkeypatch.setattr(plugins, "entry_points", lambda group: [point])
    from_entry_points.cache_clear()
    try:
        with pytest.raises(BadInput, match=r"'ghost' of no_such_package:Ghost .* cannot be loaded"):
            build_effect("ghost", {})
    finally:
        from_entry_points.cache_clear()


def test_what_an_effect_cannot_do_is_said_at_its_place_in_the_list() -> None:
    model = build(load_case("punch", overrides=["wires=null", "fabric.coarsening=60"]).case).model
    with pytest.raises(BadInput, match=r"effects.1.x: x off a symmetry plane"):
        with_effects(model, [("rate_dependence", {"per_decade": 0.05}), ("geometry", {"x": 1.0})])
    with pytest.raises(BadInput, match=r"effects.0.id: unknown name") as caught:
        with_effects(model, [("nothing", {}), ("geometry", {"x": 100.0})])
    assert [problem.key for problem in caught.value.problems] == ["effects.0.id", "effects.1.x"]
