"""A net is one connection: its wires meet at its parts or at joints, or the case is refused with one message."""

from __future__ import annotations

from pathlib import Path

import pytest

from etextile.errors import BadInput
from etextile.text.case import summary_lines
from loadcases.build import plan
from loadcases.reader import load_case


CASE = """
schema_version: 1
title: three wires
extends: punch
fabric: {{portion: whole}}
wires:
  paths: [{{name: A, along: warp, at: -10}}, {{name: B, along: warp, at: 10}}, {{name: C, along: weft, at: 20}}]
  components: [{{name: P1, at: [-20, -10], connects: [A]}}, {{name: P2, at: [20, 10], connects: [{at_second}]}}]
  joined: [{joined}]
  nets: [{{name: data, wires: [{wires}], parts: [P1, P2]}}]
"""


def written(folder: Path, *, wires: str, joined: str = "", at_second: str = "B") -> Path:
    path = folder / "case.yaml"
    path.write_text(CASE.format(wires=wires, joined=joined, at_second=at_second), encoding="utf-8")
    return path


@pytest.mark.parametrize(("wires", "joined", "apart"), [("A, B", "", "'B' is"), ("A, B, C", "[A, C]", "'B' is"),
                                                          ("A, B, C", "", "'B' and 'C' are")])  # fmt: skip
def test_wires_that_do_not_meet_are_no_net(tmp_path: Path, wires: str, joined: str, apart: str) -> None:
    loaded = load_case(written(tmp_path, wires=wires, joined=joined))
    with pytest.raises(BadInput) as caught, loaded.locating():
        plan(loaded.case)
    (problem,) = caught.value.problems
    assert f"net 'data': {apart} not connected with 'A'" in problem.message
    assert (problem.key, Path(problem.file).name, problem.line) == ("wires.nets.0.wires", "case.yaml", 10)


def test_joints_and_parts_of_the_net_connect_and_check_lists_both(tmp_path: Path) -> None:
    loaded = load_case(written(tmp_path, wires="A, B, C", joined="[A, C], [C, B]"))
    lines = summary_lines(loaded, plan(loaded.case))
    assert any("parts" in line and "P1 on A, P2 on B" in line for line in lines)
    assert any("nets" in line and "data (wires A B C; P1 to P2)" in line for line in lines)
