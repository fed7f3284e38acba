"""`etextile size-loops`: from a case to slack per loop, and the same loops judged again in a second simulation."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from etextile.app.cli import main


SMALL = ("fabric.coarsening=29", "motion.total=28 mm", "motion.steps=7", "failure.criterion=wire_strain")


def command(folder: Path, *more: str) -> list[str]:
    settings = [part for item in SMALL for part in ("--set", item)]
    return ["punch", "-o", str(folder), *settings, *more, "--quiet"]


def test_loops_of_the_size_found_meet_the_target_when_simulated_again(tmp_path: Path) -> None:
    assert main(["size-loops", *command(tmp_path / "sized"), "--target", "0.01", "--verify"]) == 0
    data = json.loads((tmp_path / "sized" / "loop_sizes.json").read_text(encoding="utf-8"))
    assert 0.03 < data["slack_for_all"] < 0.2
    assert data["verified"]["slack"] == data["slack_for_all"]
    assert data["verified"]["limits"] == []
    assert set(data["continuations"]) == {"low", "high"}
    found = [item["slack_for_all"] for item in data["continuations"].values()]
    assert data["slack_for_all"] == max(found) < min(found) + 0.02
    assert 0.0 < data["verified"]["largest_probability"] <= 0.01
    with (tmp_path / "sized" / "loop_sizes.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["slack"]) for row in rows] == pytest.approx([row["slack"] for row in data["loops"]])
    assert min(float(row["slack"]) for row in rows) == 0.0


def test_a_target_that_is_no_probability_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["size-loops", *command(tmp_path / "out"), "--target", "1.5"]) == 2
    assert not (tmp_path / "out").exists()
    assert "target" in capsys.readouterr().err


@pytest.mark.slow
def test_loops_of_a_drawing_are_sized_and_proved_by_a_drawing_with_the_slack_found(tmp_path: Path) -> None:
    quick = ["fabric.coarsening=50", "motion.total=30 mm", "motion.steps=2", "outputs.maps=[]"]
    sets = [part for key in quick for part in ("--set", key)]
    folder = tmp_path / "sized"
    assert main(["size-loops", "knee_pad", "-o", str(folder), *sets, "--target", "0.1", "--verify", "--quiet"]) in (
        0,
        4,
    )
    data = json.loads((folder / "loop_sizes.json").read_text())
    assert {row["name"] for row in data["loops"]} == {"GND", "VCC", "LED", "SDA", "SCL", "SHD"}
    assert data["verified"]["surely_met"]
    assert data["verified"]["high"] <= 0.1
    assert data["verified"]["slack"] == data["slack_for_all"]
    table = (folder / "sized.csv").read_text()
    assert {line.split(",")[5] for line in table.splitlines() if line.startswith("loop,")} == {
        str(data["slack_for_all"])
    }
