"""The shipped example from files to a proven patch with the simulator itself, on a coarse lattice and few effects."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from etextile.app.cli import main


HIDDEN_LIMIT = 9.0
"""Line force of the clamps in the shipped data, N/mm (loadcases/data/hidden_clamp/README.md)."""
SETTINGS = ("fabric.coarsening=30", "outputs.maps=[]")


def options(*settings: str) -> list[str]:
    return [part for setting in settings for part in ("--set", setting)]


def forces(folder: Path) -> list[dict[str, str]]:
    with (folder / "force_displacement.csv").open(encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def in_shell(arguments: list[str]) -> None:
    """Run the command in a process of its own, which may choose its threads (see `verbs_diagnose.one_thread_each`)."""
    alone = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")}
    run = subprocess.run([sys.executable, "-m", "etextile", *arguments], env=alone, check=False)
    assert run.returncode in (0, 4)


@pytest.mark.slow
def test_the_shipped_example_ends_in_a_patch_that_the_ordinary_command_takes(tmp_path: Path) -> None:
    out = tmp_path / "out"
    among = [part for name in ("clamp_slip", "yarn_tail", "machine_compliance") for part in ("--among", name)]
    command = ["diagnose", "punch", "--measured", "hidden_clamp", "-o", str(out), "--jobs", "2", "--quiet"]
    in_shell([*command, *options(*SETTINGS), *among])
    found = json.loads((out / "diagnosis.json").read_text(encoding="utf-8"))
    assert (found["verdict"], [item["id"] for item in found["effects"]]) == ("named", ["clamp_slip"])
    limit = found["effects"][0]["parameters"]["limit"]
    assert limit["low"] < HIDDEN_LIMIT < limit["high"]
    gaps = {(row["channel"], row["part"]): row for row in found["gap"]}
    force, edge = gaps["punch_force", "held_out"], gaps["free_edge", "held_out"]
    assert force["after_percent"] < 0.15 * force["before_percent"]
    assert edge["after_percent"] < 0.6 * edge["before_percent"]
    assert all(part["shrinks"] for part in found["held_out"])
    as_run = {row["channel"]: row for row in found["as_run"]}
    assert as_run["punch_force"]["after_percent"] < 0.15 * as_run["punch_force"]["before_percent"]
    again = tmp_path / "again"
    fabric = f"fabric.set={out / 'fabric.yaml'}"
    patch = ["--patch", str(out / "patch.yaml"), "-o", str(again), "--quiet"]
    assert main(["run", "punch", *options(*SETTINGS, fabric), *patch]) in (0, 4)
    report = json.loads((again / "report.json").read_text(encoding="utf-8"))
    assert report["case"]["effects"] == ["clamp_slip"]
    assert not [note for note in report["notes"] if "made for" in note or "another fabric" in note]
    assert forces(again) == forces(out / "patched")
    assert forces(again) != forces(out / "base")
