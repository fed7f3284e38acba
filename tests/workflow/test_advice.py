"""What a run says to change is what ordinary runs with the change give."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import etextile as et
from etextile.app.text.run import report_text
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


def test_sentences_are_those_of_the_changes_or_that_nothing_has_to_change() -> None:
    assert advice_sentences({}) == []
    rows = [{"sentence": "Slack: more."}, {"sentence": "Depth: less."}]
    block = {"sentence": "", "changes": rows, "note": "judged by calibrated"}
    assert advice_sentences({"advice": block}) == ["Slack: more.", "Depth: less.", "Judged by calibrated."]
    assert advice_sentences({"advice": {"sentence": "Nothing has to change.", "changes": []}}) == [
        "Nothing has to change."
    ]
