"""Parts and nets on a half and a quarter are those of the whole specimen, when the drawing is symmetric."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from etextile.errors import BadInput
from etextile.studies.run.run import run
from loadcases.build_paths import drawn_wires
from loadcases.reader import load_case


CASE = """\
schema_version: 1
extends: punch
title: Symmetric parts
fabric: {coarsening: 44}
motion: {total: 24 mm, steps: 2}
outputs: {maps: []}
failure: {criterion: calibrated}
wires:
  loops: null
  paths:
    - {name: A, along: warp, at: -11, loops: [-15, 15]}
    - {name: B, along: warp, at: 11, loops: [-15, 15]}
    - {name: M, along: warp, at: 0, loops: [{at: -9, length: 3}, {at: 9, length: 3}]}
    - {name: F, along: warp, at: -40, loops: [0]}
    - {name: G, along: warp, at: 40, loops: [0]}
    - {name: L, along: weft, at: -33}
    - {name: R, along: weft, at: 33}
  joined: [[A, L], [B, L], [A, R], [B, R], [M, L], [M, R]]
  components:
    - {name: P, at: [-22, -11], size: [6, 6], connects: [A]}
    - {name: Q, at: [22, -11], size: [6, 6], connects: [A]}
    - {name: S, at: [-22, 11], size: [6, 6], connects: [B]}
    - {name: T, at: [22, 11], size: [6, 6], connects: [B]}
    - {name: X, at: [0, 11], size: [8, 4], connects: [B]}
    - {name: Y, at: [0, -11], size: [8, 4], connects: [A]}
    - {name: C, at: [-20, 0], size: [4, 4], connects: [M]}
    - {name: D, at: [20, 0], size: [4, 4], connects: [M]}
    - {name: U, at: [-20, -40], size: [4, 4]}
    - {name: V, at: [20, -40], size: [4, 4]}
    - {name: W, at: [-20, 40], size: [4, 4]}
    - {name: Z, at: [20, 40], size: [4, 4]}
  nets:
    - {name: row, wires: [A], parts: [P, Y, Q]}
    - {name: centre, wires: [M], parts: [C, D]}
    - {name: round, wires: [A, B, L], parts: [Q, X]}
    - {name: ring, wires: [A, B, L, R], parts: [P, T]}
    - {name: far, wires: [F], parts: [U, V]}
"""


def report_of(portion: str, where: Path) -> dict[str, Any]:
    case = where / f"{portion}.yaml"
    case.write_text(CASE.replace("coarsening: 44", f"coarsening: 44, portion: {portion}"))
    return run(load_case(case), where / portion).report


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return report_of("whole", tmp_path_factory.mktemp("whole"))


@pytest.mark.slow
@pytest.mark.parametrize("portion", ["half", "quarter"])
def test_a_portion_reports_parts_nets_and_losses_of_the_whole(
    portion: str, whole: dict[str, Any], tmp_path: Path
) -> None:
    """On the same cells; what a plane changes is the chord of a loop that lies across it, here far from the body."""
    part = report_of(portion, tmp_path)
    for key in ("wires", "expected_wires_broken", "expected_wires_open", "p_any_wire_broken", "p_any_wire_open"):
        assert part["reliability"][key] == pytest.approx(whole["reliability"][key], rel=1e-3, abs=1e-9), key
    assert whole["reliability"]["expected_wires_broken"] > 0.1
    assert [net["name"] for net in part["nets"]] == ["row", "centre", "round", "ring", "far"]
    for own, other in zip(part["nets"], whole["nets"], strict=True):
        for key in ("loss_probability", "resistance_before_ohm", "resistance_after_ohm", "low", "high"):
            open_circuit = other[key] is None
            assert (own[key] is None) == open_circuit
            assert open_circuit or own[key] == pytest.approx(other[key], rel=1e-3, abs=1e-6), (own["name"], key)
    assert [row["name"] for row in part["parts"]] == list("PQSTXYCDUVWZ")
    for own, other in zip(part["parts"], whole["parts"], strict=True):
        assert own["max_strain"] == pytest.approx(other["max_strain"], rel=1e-3)
        assert (own["wires"], own["nets"]) == (other["wires"], other["nets"])


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("{name: T, at: [22, 11]", "{name: T, at: [23, 11]", r"part 'T' has none at \(-23, 11\) mm; draw its mirror"),
        ("{name: T, at: [22, 11], size: [6, 6]", "{name: T, at: [22, 11], size: [6, 5]", "another size than 'S'"),
        ("{name: X, at: [0, 11]", "{name: X, at: [0.5, 11]", r"part 'X' has none at \(-0.5, 11\)"),
        ("joined: [[A, L], ", "joined: [", "'A' and 'L' are not joined; join them too, or set fabric.portion"),
        ("{name: B, along: warp", "{name: B, filaments: 19, along: warp", "made otherwise than its image"),
    ],
)
def test_what_is_not_symmetric_is_refused_with_the_remedy(before: str, after: str, said: str, tmp_path: Path) -> None:
    assert before in CASE
    (tmp_path / "case.yaml").write_text(CASE.replace(before, after))
    case = load_case(tmp_path / "case.yaml", overrides=["fabric.portion=quarter"]).case
    with pytest.raises(BadInput, match=said):
        drawn_wires(case)
