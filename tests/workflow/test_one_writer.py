"""One run writes into a folder, and what an earlier one said of it is gone before the first new step."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import etextile as et
from etextile.errors import BadInput
from etextile.files import owned


SMALL = {"fabric.coarsening": 50, "motion.total": 10, "motion.steps": 3, "outputs.maps": []}
HOLD = """
import sys
from pathlib import Path
from etextile.files import owned

with owned(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""


def test_a_second_run_into_a_folder_is_told_who_writes_there(tmp_path: Path) -> None:
    command = [sys.executable, "-c", HOLD, str(tmp_path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "held\n"
        with pytest.raises(BadInput, match=f"another run writes into this folder .process {other.pid} on "):
            et.run(et.load("punch", SMALL), tmp_path)
        assert not (tmp_path / "results.vtkhdf").exists()
        other.communicate()
    assert et.run(et.load("punch", SMALL), tmp_path).exit_code in (0, 4)


def test_no_old_verdict_stands_over_results_that_a_stopped_run_left(tmp_path: Path) -> None:
    et.run(et.load("punch", SMALL), tmp_path)
    (tmp_path / "notes.csv").write_text("mine")

    class Stop(Exception):
        pass

    def stop(_: object) -> None:
        raise Stop

    with pytest.raises(Stop):
        et.run(et.load("punch", SMALL), tmp_path, force=True, watch=stop)
    assert not (tmp_path / "report.json").exists()
    assert not (tmp_path / "wires.csv").exists()
    assert (tmp_path / "notes.csv").read_text() == "mine"


def test_a_folder_is_free_again_after_its_writer(tmp_path: Path) -> None:
    with owned(tmp_path / "new"), owned(tmp_path / "new"):
        assert json.loads((tmp_path / "new" / ".etextile.owner").read_text())["process"]
    assert not (tmp_path / "new").exists()
