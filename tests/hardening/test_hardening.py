"""A small part of `figures.py`: hostile and broken inputs end with a message, in time and in memory."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest


sys.path.insert(0, str(Path(__file__).parent))

import isolated


pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="a verb is forked from a process that has loaded all")


@pytest.mark.slow
def test_no_hostile_input_is_a_fault_of_the_program() -> None:
    command = [sys.executable, str(Path(isolated.__file__).with_name("figures.py")), "--share", "0.012", "--seed", "7"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    rows = [line.split(" | ") for line in done.stdout.splitlines()[2:]]
    assert [row[0] for row in rows] == [
        "| mutated cases", "| measured folders", "| meshes", "| result files", "| report files",
    ]  # fmt: skip
    assert any("2:" in row[2] for row in rows), "nothing was refused"


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
