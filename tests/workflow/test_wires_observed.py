"""`etextile report --measured`: from observed states in a folder to hits, misses and scores beside the report."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from etextile.app.cli import main


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("observed") / "run"
    settings = ["fabric.coarsening=60", "motion.total=28 mm", "motion.steps=7", "outputs.maps=[]"]
    assert main(["run", "punch", "-o", str(folder), "--quiet", *(p for s in settings for p in ("--set", s))]) in (0, 4)
    return folder


def observed(folder: Path, rows: str) -> Path:
    folder.mkdir()
    text = "title: X-ray\nchannels:\n  wires: {file: wires.csv}\n"
    (folder / "measured.yaml").write_text(text, encoding="utf-8")
    (folder / "wires.csv").write_text(f"displacement_mm,wire,warp0_mm,state\n{rows}", encoding="utf-8")
    return folder


def test_hits_misses_and_scores_come_with_the_report(
    run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = "10,8,0,intact\n28,8,0,partial\n28,8,-20,open\n28,0,0,partial\n28,8,10,intact\n"
    folder = observed(tmp_path / "xray", rows)
    capsys.readouterr()
    assert main(["report", str(run), "--measured", str(folder), "--format", "json"]) == 0
    found = json.loads(capsys.readouterr().out)["observed"]
    assert [place["outcome"] for place in found["places"]] == ["hit", "hit", "hit", "missed break"]
    assert (found["hits"], found["false_alarms"], found["missed_breaks"]) == (3, 0, 1)
    assert 0.2 < found["broken"]["brier"] < 0.3
    assert "no loop of the wire is there" in found["left_out"][0]
    assert main(["report", str(run), "--measured", str(folder)]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "3 of 4 places agree on whether a filament is broken, 0 false alarms, 1 missed breaks" in text
    assert "Brier score" in text


def test_measurements_without_wires_are_refused(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(run), "--measured", "hidden_clamp"]) == 2
    assert "no channel `wires`" in capsys.readouterr().err
    assert main(["report", str(run), "--measured", "nowhere", "--format", "html"]) == 2
