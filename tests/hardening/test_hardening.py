"""A small part of `figures.py`: hostile and broken inputs end with a message, in time and in memory."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest


sys.path.insert(0, str(Path(__file__).parent))

import isolated


pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="a verb is forked from a process that has loaded all")


FILES = {
    "cases": "mutated cases", "folders": "measured folders", "meshes": "meshes", "results": "result files",
    "reports": "report files",
}  # fmt: skip


def figures(*arguments: str) -> list[list[str]]:
    """Return the rows of the table; none of what should never happen may be in it."""
    command = [sys.executable, str(Path(isolated.__file__).with_name("figures.py")), *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return [line.removeprefix("| ").split(" | ") for line in done.stdout.splitlines()[2:]]


@pytest.mark.slow
def test_no_hostile_input_is_a_fault_of_the_program() -> None:
    rows = figures(*FILES, "--share", "0.012", "--seed", "7")
    assert [row[0] for row in rows] == list(FILES.values())
    assert any("2:" in row[2] for row in rows), "nothing was refused"


@pytest.mark.slow
def test_a_killed_run_leaves_whole_files_and_goes_on_to_the_same_numbers() -> None:
    rows = figures("killed-runs", "--share", "0.03", "--seed", "2")
    assert [row[0].split(" (")[0] for row in rows] == ["kills of run"]
    assert "ended before" not in rows[0][0]
    assert int(rows[0][1]) >= 2


def test_a_fault_a_hang_and_too_much_memory_are_seen() -> None:
    def ended(**changes: object) -> isolated.Ended:
        sound = {"code": 0, "seconds": 1.0, "peak": 1, "said": "ready"}
        return isolated.Ended(**(sound | changes))

    assert ended().trouble == ""
    assert ended(said="etextile: fault of the program: KeyError: 'x'", code=1).trouble == "traceback"
    assert ended(seconds=21.0).trouble == "hang"
    assert ended(peak=3 * 2**30).trouble == "memory"
    assert ended(code=1).trouble == "exit"
    assert ended(code=-9).trouble == "exit"


@pytest.mark.slow
def test_a_report_made_again_from_the_results_is_no_lie_and_a_changed_one_is(tmp_path: Path) -> None:
    import kills

    whole = kills.sound_run(tmp_path / "whole", kills.SMALL)
    shutil.copytree(whole.folder, tmp_path / "killed")
    (tmp_path / "killed" / "report.json").unlink()
    again = isolated.verb(["report", str(tmp_path / "killed"), "--format", "json"])
    assert again.code == 0
    assert "made again" in again.said.removesuffix(again.printed), "the remark is not apart from what a program reads"
    assert kills.report_lies(tmp_path / "killed", again.printed, [whole]) == ""
    wrong = json.loads(again.printed)
    wrong["strain"]["warp_max"][-1] *= 1.001
    assert "strain.warp_max" in kills.report_lies(tmp_path / "killed", json.dumps(wrong), [whole])
