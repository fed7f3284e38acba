"""A measured moment over the angle of a joint: read with its mistakes named, compared and calibrated on a worn case."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import etextile as et
from etextile.diagnose.data.inflated import read_joint_moment
from etextile.diagnose.predict.simulate import Request
from etextile.errors import BadInput
from etextile.studies.diagnose.setting import simulator_of
from etextile.vocabulary import FABRIC_FAMILIES
from loadcases.fabric import load_fabric


SHORT = {"fabric.coarsening": 78, "fabric.ease": "-2 %", "motion.flexion": 30, "motion.steps": 3}
MISTAKES = {
    "rad": ("0,0\n0.5,100\n1.5,300\n", "convert to deg"),
    "way back": ("0,0\n30,100\n20,300\n", "rows must be ordered by angle; leave out unloading"),
    "other zero": ("-5,0\n30,100\n40,300\n", "from the straight limb"),
    "two rows": ("0,0\n30,100\n", "at least 3"),
}


@pytest.mark.parametrize(("rows", "message"), MISTAKES.values(), ids=MISTAKES)
def test_wrong_records_are_named(rows: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "moment.csv"
    path.write_text("angle_deg,moment_Nmm\n" + rows)
    with pytest.raises(BadInput, match=message):
        read_joint_moment(path)


def measured(folder: Path, angle: np.ndarray, moment: np.ndarray) -> Path:
    folder.mkdir()
    rows = "\n".join(f"{a:.6g},{m:.8g}" for a, m in zip(angle, moment, strict=True))
    folder.joinpath("moment.csv").write_text(f"angle_deg,moment_Nmm\n{rows}\n")
    folder.joinpath("measured.yaml").write_text(
        "title: A sleeve on a jig\nchannels:\n  joint_moment: {files: [moment.csv]}\n"
    )
    return folder


def test_a_moment_needs_a_joint(tmp_path: Path) -> None:
    folder = measured(tmp_path / "m", np.array([10.0, 20.0, 30.0]), np.array([1.0, 2.0, 3.0]))
    with pytest.raises(BadInput, match="a moment over the angle needs"):
        et.compare("punch", folder, tmp_path / "out")


@pytest.mark.slow
def test_the_moment_of_a_run_is_met_by_compare_and_a_third_more_is_said(tmp_path: Path) -> None:
    """Compare calculates the moment that the report of an ordinary run tells."""
    case = et.load("elbow_sleeve", SHORT)
    joint = et.run(case, tmp_path / "run").report["joint"]
    angle, moment = np.array(joint["angle_deg"]), np.array(joint["moment_Nmm"])
    assert moment[-1] > 100.0
    row = et.compare(case, measured(tmp_path / "m", angle, moment), tmp_path / "same").data["gap"][0]
    assert row["channel"] == "joint_moment"
    assert row["percent"] < 3.0  # compare leaves out the wires
    row = et.compare(case, measured(tmp_path / "more", angle, 4.0 / 3.0 * moment), tmp_path / "out").data["gap"][0]
    assert row["percent"] == pytest.approx(25.0, abs=3.0)
    assert row["measured_over_computed"]["factor"] == pytest.approx(4.0 / 3.0, rel=0.03)
    assert (tmp_path / "out" / "compare.png").stat().st_size > 10_000


@pytest.mark.slow
def test_moment_slip_and_wires_of_a_run_are_met_by_compare_and_by_the_simulator_of_a_diagnosis(tmp_path: Path) -> None:
    """What is measured on a case itself leaves no gap, in the simulator behind diagnose and in compare."""
    case = et.load("elbow_sleeve", {**SHORT, "supports.ends": ["held", "free"]})
    laws = tuple(
        (item.E.value, item.sigma_y0.value, item.H.value, item.n.value)
        for item in (getattr(load_fabric(case.case.fabric.set), name) for name in FABRIC_FAMILIES)
    )
    record = simulator_of(case.case, [])(Request(laws, (), 78.0, 30.0, 3))
    folder = measured(tmp_path / "m", record.displacement[1:], record.force[1:])
    rows = [
        (angle, x, y, record.slip[step, i, j])
        for step, angle in enumerate(record.displacement)
        for i, x in list(enumerate(record.x))[::8]
        for j, y in list(enumerate(record.y))[::10]
    ]
    assert max(abs(row[3]) for row in rows) > 1.0
    marks = "".join(f"{a:g},{x:.9g},{y:.9g},{s:.9g}\n" for a, x, y, s in rows)
    (folder / "marks.csv").write_text(f"angle_deg,warp0_mm,weft0_mm,slip_mm\n{marks}")
    (folder / "wires.csv").write_text("angle_deg,wire,warp0_mm,state\n30,13,0,intact\n30,0,0,open\n")
    (folder / "measured.yaml").write_text(
        "title: A sleeve on a jig\nchannels:\n  joint_moment: {files: [moment.csv]}\n"
        "  mark_slip: {file: marks.csv}\n  wires: {file: wires.csv}\n"
    )
    data = et.compare(case, folder, tmp_path / "out").data
    assert {row["channel"] for row in data["gap"]} == {"joint_moment", "mark_slip"}
    assert all(row["percent"] < 0.1 for row in data["gap"])
    assert data["wires"]["hits"] == 1
    assert data["wires"]["missed_breaks"] == 1
