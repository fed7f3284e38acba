"""A measured moment over the angle of a joint: read with its mistakes named, compared and calibrated on a worn case."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import etextile as et
from etextile.diagnose.data.inflated import read_joint_moment
from etextile.errors import BadInput


SHORT = {"fabric.coarsening": 78, "fabric.ease": "-2 %", "motion.flexion": 30, "motion.steps": 3}
MISTAKES = {
    "rad": ("0,0\n0.5,100\n1.5,300\n", "convert to deg"),
    "way back": ("0,0\n30,100\n20,300\n", "leave out repeats and the way back"),
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
