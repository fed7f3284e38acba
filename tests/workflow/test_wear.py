"""A cyclic case from file to verdict, text, page, table and JSON: the same numbers everywhere."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from etextile.app.cli import main


CYCLIC = "{exponent: -0.6, coefficient: 0.3, source: own flex tests, required_cycles: 20, scatter: 0.4}"


def test_life_and_nets_stand_in_verdict_text_page_table_and_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = {
        "fabric.coarsening": "29",
        "motion.total": "18",
        "motion.steps": "9",
        "motion.path": "[18, 12, 18]",
        "failure.cyclic": CYCLIC,
        "wires.nets": "[{name: lamp, wire: 2, from_loop: 0, to_loop: 2}]",
        "outputs.maps": "[]",
    }
    settings = [part for key, value in options.items() for part in ("--set", f"{key}={value}")]
    assert main(["run", "punch", "-o", str(tmp_path), *settings]) == 0
    text = " ".join(capsys.readouterr().out.replace("│", " ").split())
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    life = report["life"]
    loops = [loop for wire in report["wires"] for loop in wire["loops"]]
    known = [loop["cycles_to_failure"] for loop in loops if loop["cycles_to_failure"] is not None]
    assert life["shortest_cycles"] == min(known)
    assert life["required_cycles"] == 20.0
    for loop in loops:
        if loop["strain_range"]:
            # the two halves of the cycle differ a little, and the range told is that of the larger one
            law = 0.5 * (loop["strain_range"] / 2.0 / 0.3) ** (-1.0 / 0.6)
            assert loop["cycles_to_failure"] == pytest.approx(law, rel=1e-3)
    assert 0.0 < life["p_below_required"] <= 1.0
    assert life["sentence"] in report["verdict"]["sentence"]
    assert "lamp with" in report["verdict"]["sentence"]
    assert life["sentence"] in text
    assert "Loops by life" in text
    assert "Nets (1 of 1)" in text
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Life under repeated loading" in page
    assert "<td>lamp</td>" in page
    with (tmp_path / "wires.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert min(float(row["cycles_to_failure"]) for row in rows if row["cycles_to_failure"]) == pytest.approx(
        life["shortest_cycles"], rel=1e-6
    )
