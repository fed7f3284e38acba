"""A small part of `figures.py`: hostile and broken inputs end with a message, in time and in memory."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest


sys.path.insert(0, str(Path(__file__).parent))

import figures
import isolated


PART = {"cases": 12, "folders": 6, "meshes": 6, "results": 3, "reports": 6}
pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="a verb is forked from a process that has loaded all")


@pytest.mark.slow
def test_no_hostile_input_is_a_fault_of_the_program(tmp_path: Path) -> None:
    for kind, count in PART.items():
        study, _ = figures.KINDS[kind]
        folder = tmp_path / kind
        folder.mkdir()
        found = study(folder, count, 7)
        assert found.examples == [], kind
        assert found.count >= count
        assert set(found.codes) <= set(isolated.DOCUMENTED)
        assert any(found.codes[code] for code in (2, 3, 4)), f"{kind}: nothing was refused"


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
