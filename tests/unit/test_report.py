"""The report says what the damage is, in exactly the agreed keys, in plain JSON, for the whole specimen."""

from __future__ import annotations

import csv
import io
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from etextile.errors import BadInput
from etextile.results.wire_history import WireHistory
from etextile.text.run import grouped, render, report_text, spread
from etextile.types import Array
from viz.style import STATES
from wires.facts import CaseFacts, RunCurves, SolverFacts, WireFacts
from wires.failure import judge_of
from wires.layout import Portion, lay_out
from wires.report import build_report
from wires.report_files import (
    CURVE_COLUMNS,
    LOOP_COLUMNS,
    write_force_displacement_csv,
    write_report_json,
    write_wires_csv,
)
from wires.trust import TrustCheck, check_run
from wires.wording import percent, probability


DISPLACEMENT = np.array([0.0, 10.0, 20.0])
CURVES = RunCurves(
    displacement_mm=DISPLACEMENT,
    force_N=np.array([0.0, 20.0, 171.0]),
    warp_max=np.array([0.0, 0.03, 0.088]),
    weft_max=np.array([0.0, 0.01, 0.02]),
    diagonal_max=np.array([0.0, 0.01, 0.03]),
    draw_in_mm=np.array([0.0, 0.1, 0.4]),
)
SOLVER = SolverFacts(170, 601, 2, 30, 0, True, 0.4, 0.3, 0.004, 0.002, "superlu")
GOOD = check_run(
    max_penetration_mm=0.004,
    allowed_penetration_mm=0.02,
    energy_error=0.002,
    force_imbalance=1e-6,
    unconverged_increments=0,
)


def history(final: Array, portion: Portion) -> WireHistory:
    """History of 5 wires (whole) with 3 loops each whose span strain grows linearly to `final`."""
    layout = lay_out(
        length_mm=60,
        width_mm=30,
        portion=portion,
        wire_spacing_mm=6.0,
        loop_spacing_mm=20.0,
        loop_length_mm=4.0,
        loop_slack=0.02,
    )
    span = (DISPLACEMENT / 20.0)[:, None] * final
    return WireHistory(
        displacement_mm=DISPLACEMENT,
        span_strain=span,
        wire_strain=np.maximum((1 + span) / 1.02 - 1, 0),
        element_wire=np.zeros(0, dtype=np.int64),
        element_warp_mm=np.zeros(0),
        element_strain=np.zeros((3, 0)),
        layout=layout,
    )


def report(
    final: Array, *, portion: Portion = "whole", checks: tuple[TrustCheck, ...] = GOOD, onset: float = 0.07
) -> dict[str, Any]:
    return build_report(
        case=CaseFacts("test", "ab12"),
        curves=CURVES,
        solver=SOLVER,
        checks=checks,
        damage=judge_of("span_strain", {"onset": onset}).judge(history(final, portion)),
        wires=WireFacts("copper_soft", 7, 0.03, 0.011),
    )


def strains(**loops: float) -> Array:
    """Strain 0.01 at all 15 loops but those named, as wire1_loop2=0.1."""
    final = np.full((5, 3), 0.01)
    for name, value in loops.items():
        wire, loop = name.removeprefix("wire").split("_loop")
        final[int(wire), int(loop)] = value
    return final.ravel()


def test_the_agreed_keys_are_there() -> None:
    """Every key of the published form, and nothing but JSON types behind it."""
    published = {
        "case": {"title", "sha256"},
        "punch": {"displacement_mm", "force_N"},
        "strain": {"warp_max", "weft_max", "diagonal_max"},
        "edge": {"displacement_mm", "draw_in_mm"},
        "solver": {
            "nodes", "trusses", "steps", "linear_solves", "cut_backs", "all_converged", "wall_s", "solve_s",
            "max_penetration_mm", "energy_error",
        },
        "trust": {"ok", "limits"},
    }  # fmt: skip
    made = report(strains())
    for key, inner in published.items():
        assert inner <= made[key].keys(), key
    wire = {"wire", "weft_mm", "state", "first_failure_mm", "max_strain", "failure_probability", "loops"}
    loop = {"loop", "warp_mm", "state", "first_failure_mm", "max_strain", "filaments_broken"}
    assert wire <= made["wires"][0].keys()
    assert loop <= made["wires"][0]["loops"][0].keys()
    assert json.loads(json.dumps(made, allow_nan=False)) == made


def test_a_whole_loop_has_no_failure_and_says_null() -> None:
    made = report(strains(wire2_loop1=0.10))
    assert made["wires"][0]["first_failure_mm"] is None
    assert made["wires"][2]["first_failure_mm"] == pytest.approx(14.0)
    assert made["wires"][2]["worst_loop"] == 1
    assert [loop["state"] for loop in made["wires"][2]["loops"]] == ["intact", "partial", "intact"]


def test_the_verdict_counts_wires_and_names_the_first_to_fail() -> None:
    verdict = report(strains(wire1_loop0=0.2, wire2_loop1=0.09, wire4_loop2=0.05))["verdict"]
    assert verdict["survive"] is False
    assert verdict["wires"] == {"intact": 2, "plastic": 1, "partial": 1, "open": 1}
    assert verdict["sentence"].startswith(
        "Of 5 wires on average 1.0 are interrupted (1 to 1 in 95 % of garments) and 2.0 have lost filaments"
    )
    assert "at 7.0 mm: wire 1, loop 0 (-20.0 mm along the warp, -6.0 mm along the weft)" in verdict["sentence"]


def test_a_safe_case_says_how_safe() -> None:
    verdict = report(strains(wire1_loop0=0.06))["verdict"]
    assert verdict["survive"] is True
    assert "All 5 wires keep every filament" in verdict["sentence"]
    assert "one is lost anywhere: 0.023" in verdict["sentence"]  # two standard deviations below the onset


def test_a_quarter_reports_the_whole_specimen() -> None:
    final = np.tile([0.09, 0.01], 3)  # halved loop at the centre, one loop beyond, wires 0, 6, 12 mm
    whole = report(np.tile([0.01, 0.09, 0.01], 5))
    quarter = report(final, portion="quarter")
    assert [wire["copies"] for wire in quarter["wires"]] == [1, 2, 2]
    assert (
        quarter["verdict"]["wires"] == whole["verdict"]["wires"] == {"intact": 0, "plastic": 0, "partial": 5, "open": 0}
    )
    assert quarter["damage"] == whole["damage"]


def test_wires_by_state_add_up_at_every_step() -> None:
    damage = report(strains(wire1_loop0=0.2, wire2_loop1=0.09))["damage"]
    counts = np.array([damage["wires"][state] for state in ("intact", "plastic", "partial", "open")])
    assert (counts.sum(axis=0) == 5).all()
    assert counts[:, 0].tolist() == [5, 0, 0, 0]
    assert counts[:, -1].tolist() == [3, 0, 1, 1]


def test_an_exceeded_limit_withholds_the_verdict_but_keeps_the_numbers() -> None:
    bad = (*GOOD[1:], replace(GOOD[0], value=0.035))
    made = report(strains(wire1_loop0=0.2), checks=bad)
    assert made["trust"]["ok"] is False
    assert [limit["name"] for limit in made["trust"]["limits"]] == ["penetration"]
    assert made["verdict"]["withheld"]
    assert made["verdict"]["survive"] is None
    assert "penetration 0.035 mm exceeds its limit of 0.02 mm" in made["verdict"]["sentence"]
    assert made["wires"][1]["state"] == "open"


def test_a_number_that_is_missing_is_not_trusted() -> None:
    assert not replace(GOOD[1], value=float("nan")).ok
    unconverged = check_run(
        max_penetration_mm=0.0,
        allowed_penetration_mm=0.02,
        energy_error=0.0,
        force_imbalance=0.0,
        unconverged_increments=1,
        lattice_error=0.2,
    )
    assert [check.name for check in unconverged if not check.ok] == ["unconverged increments", "lattice error"]


def test_parameters_carry_their_source_and_changes_are_told() -> None:
    parameters = report(strains(), onset=0.08)["failure"]["parameters"]
    assert parameters["onset"] == {
        "value": 0.08, "unit": "", "origin": "case", "source": "set in the case (default 0.07)"
    }  # fmt: skip
    assert parameters["scale"]["origin"] == "estimated"
    assert report(strains())["failure"]["parameters"]["onset"]["origin"] == "stated"


def test_a_case_without_wires_has_a_report() -> None:
    made = build_report(case=CaseFacts("dry", "00"), curves=CURVES, solver=SOLVER, checks=GOOD)
    assert made["wires"] == []
    assert made["verdict"]["survive"] is None
    assert made["verdict"]["sentence"] == "The case has no wires."


def test_text_reads_the_same_without_colours_and_fits_80_columns() -> None:
    text = report_text(report(strains(wire1_loop0=0.2, wire2_loop1=0.09)), folder=Path("out/test"))
    assert "\x1b" not in text
    assert max(len(line) for line in text.splitlines()) <= 80
    assert "…" not in text, "a column was cut"
    wire = next(line for line in text.splitlines() if line.split()[:2] == ["1", "-6.0"])
    assert wire.split() == ["1", "-6.0", "O..", "open", "7.0", "0.200", ">0.999", "0.993"]
    assert "Files in out/test" in text
    assert "Trust: all limits kept" in text


def test_text_marks_an_exceeded_limit() -> None:
    text = report_text(report(strains(wire1_loop0=0.2), checks=(replace(GOOD[0], value=0.035),)))
    assert "Trust: LIMIT EXCEEDED" in text
    assert "provisional" in text


def test_a_terminal_gets_colours() -> None:
    console = Console(file=io.StringIO(), width=80, force_terminal=True, color_system="truecolor")
    console.print(render(report(strains(wire1_loop0=0.2))))
    red, green, blue = (int(STATES[3].colour[k : k + 2], 16) for k in (1, 3, 5))
    assert f"48;2;{red};{green};{blue}m" in console.file.getvalue()  # type: ignore[attr-defined]


def test_forty_wires_are_grouped_but_broken_ones_stay_single() -> None:
    def row(k: int, state: str) -> dict[str, Any]:
        return {"wire": k, "state": state}

    states = ["intact"] * 15 + ["plastic"] * 5 + ["partial"] * 3 + ["open"] * 2 + ["plastic"] * 15
    groups = [[one["wire"] for one in group] for group in grouped([row(k, state) for k, state in enumerate(states)])]
    assert [len(group) for group in groups] == [15, 5, 1, 1, 1, 1, 1, 15]
    assert [wire for group in groups for wire in group] == list(range(40))
    alternating = grouped([row(k, "open") for k in range(40)])
    assert len(alternating) == 1


def test_listed_displacements_are_even_and_end_with_the_last() -> None:
    assert spread(21) == [4, 8, 12, 16, 20]
    assert spread(22)[-1] == 21
    assert spread(3) == [1, 2]
    assert spread(1) == [0]


def test_probabilities_claim_no_certainty() -> None:
    assert [probability(p) for p in (0.0, 1e-5, 0.02, 0.9999, 1.0)] == ["<0.001", "<0.001", "0.020", ">0.999", ">0.999"]
    assert [percent(p) for p in (0.0, 0.001, 0.5, 0.999, 1.0)] == ["0 %", "<1 %", "50 %", ">99 %", "100 %"]


def test_curves_of_different_length_are_refused() -> None:
    with pytest.raises(ValueError, match="curves differ in length"):
        replace(CURVES, force_N=np.zeros(2))


def test_wires_csv_has_a_row_per_loop(tmp_path: Path) -> None:
    made = report(strains(wire1_loop0=0.2))
    write_wires_csv(made, tmp_path / "wires.csv")
    with (tmp_path / "wires.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == LOOP_COLUMNS
    assert len(rows) == 15
    assert [row["state"] for row in rows if row["first_failure_mm"]] == ["open"]
    assert float(rows[3]["first_failure_mm"]) == pytest.approx(7.0)
    assert {row["wire_state"] for row in rows[3:6]} == {"open"}


def test_force_displacement_csv_holds_the_curve(tmp_path: Path) -> None:
    write_force_displacement_csv(report(strains()), tmp_path / "curve.csv")
    with (tmp_path / "curve.csv").open(encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert tuple(rows[0]) == CURVE_COLUMNS
    assert [float(row[1]) for row in rows[1:]] == [0.0, 20.0, 171.0]


def test_files_are_not_overwritten_silently(tmp_path: Path) -> None:
    path, made = tmp_path / "report.json", report(strains())
    write_report_json(made, path)
    with pytest.raises(BadInput, match="is there already"):
        write_report_json(made, path)
    write_report_json(made, path, overwrite=True)
    found = json.loads(path.read_text(encoding="utf-8"))
    assert re.fullmatch("[0-9a-f]{64}", found.pop("seal"))
    assert found == made
