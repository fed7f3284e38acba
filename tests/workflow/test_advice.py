"""What a run says to change is what ordinary runs with the change give."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import etextile as et
from etextile.text.run import report_text
from wires.construction import advice_sentences


CASE = {"fabric.coarsening": 60, "motion.steps": 8, "outputs.maps": [], "failure.criterion": "calibrated"}
TARGET = 0.01


def worst(report: dict[str, Any]) -> float:
    parts = [part for wire in report["wires"] for part in (*wire["loops"], *wire["woven"])]
    return max(float(part["failure_probability"]) for part in parts)


@pytest.mark.slow
def test_every_change_is_confirmed_by_an_ordinary_run_with_it(tmp_path: Path) -> None:
    found = et.run(et.load("elbow", CASE), tmp_path / "now")
    block = et.advise(found, target=TARGET)
    assert worst(found.report) > 0.99
    assert block["now"]["worst"] == pytest.approx(worst(found.report))
    rows = {row["what"]: row for row in block["changes"]}
    assert [row["enough"] for row in rows.values()] == [True, True, True]
    changes = {what: dict(row["change"]) for what, row in rows.items()}
    changes["Position"]["wires.layout"] = str(tmp_path / "now" / changes["Position"]["wires.layout"])
    changes["Position"] |= {"wires.loops": None}
    for what, change in changes.items():
        again = et.run(et.load("elbow", {**CASE, **change}), tmp_path / what)
        assert worst(again.report) == pytest.approx(rows[what]["after"]["worst"], rel=1e-6, abs=1e-12), what
        assert worst(again.report) <= TARGET
    opened = et.open(tmp_path / "now").report
    assert len(advice_sentences(opened)) == 3
    assert "confirmed by a run with it" in " ".join(report_text(opened).split())


@pytest.mark.slow
def test_a_drawing_is_moved_as_one_and_an_ordinary_run_says_what_that_gives(tmp_path: Path) -> None:
    def wire(name: str, at: float, loop: float) -> dict[str, Any]:
        return {"name": name, "along": "warp", "at": at, "from": -20, "to": 20, "loops": [{"at": loop, "slack": 0.0}]}

    case = {**CASE, "motion.steps": 6, "fabric.portion": "whole", "wires.loops": None}
    drawn = {**case, "wires.paths": [wire("A", 5.0, 0.0), wire("B", -8.0, 3.0)]}
    found = et.run(et.load("punch", drawn), tmp_path / "now")
    row = next(row for row in et.advise(found, target=TARGET)["changes"] if row["what"] == "Position")
    assert "moved by 44 mm along the weft" in row["sentence"]
    change = {**row["change"], "wires.layout": str(tmp_path / "now" / row["change"]["wires.layout"])}
    again = et.run(et.load("punch", {**case, **change}), tmp_path / "again")
    assert [wire["weft_mm"] for wire in again.report["wires"]] == [49.0, 36.0]
    assert worst(again.report) == pytest.approx(row["after"]["worst"], rel=1e-6)
    assert worst(again.report) < 0.5 < worst(found.report)


def test_sentences_are_those_of_the_changes_or_that_nothing_has_to_change() -> None:
    assert advice_sentences({}) == []
    rows = [{"sentence": "Slack: more."}, {"sentence": "Depth: less."}]
    block = {"sentence": "", "changes": rows, "note": "judged by calibrated"}
    assert advice_sentences({"advice": block}) == ["Slack: more.", "Depth: less.", "Judged by calibrated."]
    assert advice_sentences({"advice": {"sentence": "Nothing has to change.", "changes": []}}) == [
        "Nothing has to change."
    ]
