"""Many cycles end when the piece has settled, with the lives that all of them simulated would have given."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import etextile as et
from etextile.app.cli import main
from etextile.studies.run.settling import Settling, cycles_block, peaks
from loadcases.history import turning_points
from loadcases.reader import load_case


PATH = "[20, 19, 20, 19, 20, 19, 20, 19.5, 20, 19.2, 20]"
"""Not so far back that the piece lies slack, where its shape is not unique."""


def run(folder: Path, *more: str, path: str = PATH) -> dict[str, Any]:
    options = {
        "fabric.coarsening": "29",
        "motion.total": "20",
        "motion.steps": "10",
        "motion.path": path,
        "failure.cyclic": "{exponent: -0.6, coefficient: 0.3, source: made up}",
        "outputs.maps": "[]",
    }
    settings = [part for key, value in options.items() for part in ("--set", f"{key}={value}")]
    assert main(["run", "punch", "-o", str(folder), "--quiet", *settings, *more]) == 0
    report: dict[str, Any] = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    return report


@pytest.mark.slow
def test_a_settled_path_ends_early_with_the_lives_of_the_whole_one(tmp_path: Path) -> None:
    early, whole = run(tmp_path / "early"), run(tmp_path / "whole", "--set", "motion.settled=0")
    assert early["cycles"]["ended_early"]
    assert early["cycles"]["settled"]
    assert not whole["cycles"]["ended_early"]
    assert early["solver"]["steps"] < whole["solver"]["steps"]
    assert early["life"]["cycles_in_path"] == whole["life"]["cycles_in_path"]
    lives = [
        [loop["cycles_to_failure"] for wire in report["wires"] for loop in wire["loops"] if loop["strain_range"] > 5e-3]
        for report in (early, whole)
    ]
    assert len(lives[0]) > 3
    assert lives[0] == pytest.approx(lives[1], rel=0.02)


@pytest.mark.slow
def test_a_cycle_of_a_settled_piece_costs_friction_alone(tmp_path: Path) -> None:
    """The area of the second cycle in the force curve is what friction took of it, and plastic flow takes nothing."""
    friction = ("--set", "contact.friction=0.3", "--set", "motion.settled=0", "--set", "motion.steps=80")
    report = run(tmp_path, *friction, path="[20, 18, 20, 18, 20]")
    rows = et.open(tmp_path).results.increments
    first, last = (int(np.flatnonzero(rows.step == step)[0]) for step in (95, 111))
    assert rows.displacement_mm[[first, last]] == pytest.approx([20.0, 20.0])
    part = slice(first, last + 1)
    area = float(np.trapezoid(rows.punch_force_N[part], rows.displacement_mm[part]))
    lost = {name: report["cycles"][f"{name}_work_Nmm"][1] for name in ("plastic", "friction")}
    assert lost["friction"] > 0.0
    assert lost["plastic"] < 0.02 * lost["friction"]
    assert area == pytest.approx(lost["friction"] + lost["plastic"], rel=0.03)


@pytest.mark.slow
def test_a_path_that_had_settled_is_at_its_end_when_it_is_resumed(tmp_path: Path) -> None:
    path = "[20, 19, 20, 19, 20, 19, 20, 19, 20]"
    first = run(tmp_path, path=path)
    again = run(tmp_path, "--resume", path=path)
    assert first["cycles"]["ended_early"]
    assert again["solver"]["steps"] == first["solver"]["steps"]
    assert again["life"] == first["life"]


def test_peaks_are_where_a_path_turns_back() -> None:
    assert peaks(np.array([5.0, 10, 5, 0, 5, 8, 3, 9])).tolist() == [1, 5, 7]
    assert peaks(np.array([5.0, 10])).tolist() == [1]
    assert peaks(np.array([5.0, 10, 5])).tolist() == [1]


def flowing(growth: list[float], travel: list[float]) -> Settling:
    """A piece whose plastic strain grows by these amounts from peak to peak."""
    found = Settling(np.array(travel), 1e-4)
    total = 0.0
    for step, more in zip(found.at, [0.01, *growth], strict=False):
        total += more
        if found.take(int(step), np.array([total, 0.0])):
            break
    return found


def test_a_piece_that_flows_on_is_said_not_to_settle() -> None:
    found = flowing([1e-3] * 4, [10.0, 0] * 4 + [10.0])
    block = cycles_block(found, 9)
    assert block is not None
    assert not block["settled"]
    assert not block["ended_early"]
    assert block["sentence"].startswith("the piece has not settled: the last of 4 cycles still adds 1.0e-03")


def test_it_takes_two_quiet_cycles_and_nothing_deeper_to_come() -> None:
    quiet = [1e-3, 1e-5, 1e-5, 1e-5]
    assert len(flowing(quiet, [10.0, 0] * 4 + [10.0]).growth) == 3
    assert len(flowing(quiet, [10.0, 0] * 4 + [11.0]).growth) == 4
    assert len(flowing(quiet, [10.0, 3] * 3 + [10.0, 0, 10.0]).growth) == 4


def test_turning_points_of_a_noisy_swing_from_its_greatest_on() -> None:
    """A sine of 80 deg with noise of 2 deg: peaks and valleys alone, beginning and ending at the greatest value."""
    time = np.linspace(0.0, 5.0, 2001)
    rng = np.random.default_rng(3)
    angle = 40.0 - 40.0 * np.cos(2.0 * np.pi * time) + rng.uniform(-2.0, 2.0, len(time))
    found = turning_points(angle, swing=0.1)
    assert len(found) == 11
    assert found[0] == found[-1] == pytest.approx(angle.max(), abs=0.01)
    assert (found[::2] > 78.0).all()
    assert (found[1::2] < 2.0).all()


def test_a_history_becomes_the_path_of_a_case(tmp_path: Path) -> None:
    record = tmp_path / "knee.csv"
    rows = "".join(f"{0.1 * row},{angle}\n" for row, angle in enumerate([0, 30, 60, 20, -1, 40, 90, 45, 0, 50, 0]))
    record.write_text(f"time_s,angle_deg\n{rows}", encoding="utf-8")
    motion = load_case("elbow_sleeve", overrides=[f"motion.history={record}"]).case.motion
    assert motion.path == (90.0, 0.0, 50.0, 0.0, 60.0, 0.0, 90.0)
    assert motion.flexion == 90.0
    assert str(motion.path_from).startswith("knee.csv, 7 turning points")
    daily = load_case("elbow_sleeve", overrides=["motion.history=elbow_daily"]).case.motion
    assert daily.path == (130.0, 30.0, 130.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("time_s,angle_deg\n0,1\n0,2\n", "knee.csv:3: time_s: time does not go on (got 0)"),
        ("time_s,angle\n0,1\n", "angle_deg"),
        ("time_s,angle_deg\n0,0\n1,0\n", "the history does not move"),
        ("time_s,angle_deg\n0,0\n1,170\n", "the joint would bend by 170 deg, at most 160 deg are possible"),
    ],
)
def test_a_history_that_is_none_is_refused(tmp_path: Path, text: str, said: str) -> None:
    from etextile.errors import BadInput

    record = tmp_path / "knee.csv"
    record.write_text(text, encoding="utf-8")
    with pytest.raises(BadInput) as caught:
        load_case("elbow_sleeve", overrides=[f"motion.history={record}"])
    assert said in str(caught.value)
