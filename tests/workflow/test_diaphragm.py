"""The diaphragm of a burst tester: what the gauge shows of a run, and what is taken off a measurement."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import etextile as et
from etextile.errors import BadInput
from etextile.motion.diaphragm import Diaphragm
from loadcases.measurements import load_measurements


SHORT = {"outputs.maps": [], "fabric.coarsening": 30, "motion.total": 10, "motion.steps": 10}
CUBE = 2e-5
"""Pressure of a flat rubber sheet over its height cubed, bar/mm3: 8 E t / (3 (1 - nu) a^4) for small heights."""


def rubber(folder: Path, largest: float = 40.0, name: str = "rubber.csv") -> Path:
    height = np.linspace(0.0, largest, 41)
    rows = "\n".join(f"{CUBE * h**3:.9g},{h:.6g}" for h in height)
    folder.mkdir(exist_ok=True)
    (folder / name).write_text(f"pressure_bar,height_mm\n{rows}\n")
    return folder / name


def test_between_points_and_beyond_them() -> None:
    height = np.linspace(0.0, 40.0, 41)
    found = Diaphragm(height, CUBE * height**3)
    at = np.linspace(2.5, 40.0, 76)
    np.testing.assert_allclose(found.at(at), CUBE * at**3, rtol=0.02)
    slope = CUBE * (40.0**3 - 39.0**3)
    assert found.at(np.array([50.0]))[0] == pytest.approx(CUBE * 40.0**3 + 10.0 * slope)
    assert Diaphragm(height[1:], CUBE * height[1:] ** 3).at(np.array([0.0]))[0] == 0.0


@pytest.mark.slow
def test_the_gauge_shows_fabric_and_diaphragm_and_the_correction_gives_the_fabric_back(tmp_path: Path) -> None:
    """ISO 13938: mean bursting pressure less the diaphragm's at the same distension is the bursting strength."""
    path = rubber(tmp_path / "m")
    case = et.load("burst_50cm2", {**SHORT, "motion.diaphragm": str(path)})
    assert case.case.motion.diaphragm is None
    report = et.run(case, tmp_path / "run").report
    plain = et.run(et.load("burst_50cm2", SHORT), tmp_path / "plain").report
    block, first = report["pressure"], report["rupture"]["first"]
    assert block["height_mm"] == plain["pressure"]["height_mm"]
    assert first["pressure_bar"] == plain["rupture"]["first"]["pressure_bar"]
    height = np.array(block["height_mm"])
    np.testing.assert_allclose(block["diaphragm_bar"], CUBE * height**3, rtol=2e-3)
    np.testing.assert_allclose(block["gauge_bar"], np.add(block["pressure_bar"], block["diaphragm_bar"]), rtol=1e-12)
    assert first["gauge_bar"] == pytest.approx(first["pressure_bar"] + CUBE * first["displacement_mm"] ** 3, rel=0.01)
    assert "gauge_bar" not in plain["pressure"]
    assert "on the gauge" in " ".join(report["notes"])
    assert "the gauge shows" in et.summary(et.open(tmp_path / "run"))
    # the gauge's readings, corrected, are the fabric's again
    rows = "\n".join(f"{p:.9g},{h:.9g}" for p, h in zip(block["gauge_bar"], height, strict=True))
    (tmp_path / "m" / "h.csv").write_text(f"pressure_bar,height_mm\n{rows}\n")
    text = "title: m\nchannels:\n  pressure_height: {files: [h.csv]"
    (tmp_path / "m" / "measured.yaml").write_text(f"{text}, diaphragm: rubber.csv}}\n")
    (curve,) = load_measurements(tmp_path / "m").pressure_height
    np.testing.assert_allclose(curve.pressure, block["pressure_bar"], rtol=1e-6)
    assert "taken off" in curve.notes[-1]
    shown = json.dumps(et.compare(et.load("burst_50cm2", SHORT), tmp_path / "m", tmp_path / "cmp").data)
    gap = json.loads(shown)["gap"][0]
    assert gap["percent"] < 0.1
    assert "taken off" in shown
    (tmp_path / "m" / "measured.yaml").write_text(f"{text}}}\n")
    raw = et.compare(et.load("burst_50cm2", SHORT), tmp_path / "m", tmp_path / "raw").data["gap"][0]
    assert raw["percent"] > 0.5


def test_a_run_beyond_the_curve_says_so_and_points_do_as_a_file(tmp_path: Path) -> None:
    points = [[10.0, 0.02], [15.0, 0.07]]
    report = et.run(et.load("burst_50cm2", {**SHORT, "motion.diaphragm_curve": points}), tmp_path / "run").report
    assert any("measured up to 15 mm" in note for note in report["notes"])
    height = report["pressure"]["height_mm"][-1]
    assert report["pressure"]["diaphragm_bar"][-1] == pytest.approx(0.07 + 0.01 * (height - 15.0))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"motion.diaphragm": "nowhere.csv"}, "no such file"),
        ({"motion.diaphragm_curve": [[1.0, 0.2], [1.0, 0.3]]}, "does not rise"),
        ({"motion.diaphragm_curve": [[1.0, 0.2], [2.0, 0.1]]}, "gets no softer"),
        ({"motion.diaphragm_curve": [[0.0, 0.2], [2.0, 0.3]]}, "begins flat"),
    ],
)
def test_wrong_diaphragms_are_named(changes: dict[str, object], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        et.load("burst_50cm2", changes)


def test_a_diaphragm_belongs_to_a_pressure() -> None:
    with pytest.raises(BadInput, match="a diaphragm is inflated"):
        et.load("punch", {"motion.diaphragm_curve": [[1.0, 0.2], [2.0, 0.3]]})


def test_a_diaphragm_that_takes_more_than_there_is_is_named(tmp_path: Path) -> None:
    rubber(tmp_path)
    (tmp_path / "h.csv").write_text("pressure_bar,height_mm\n0.1,5\n0.15,25\n0.2,35\n")
    (tmp_path / "measured.yaml").write_text(
        "title: m\nchannels:\n  pressure_height: {files: [h.csv], diaphragm: rubber.csv}\n"
    )
    with pytest.raises(BadInput, match="the diaphragm takes"):
        load_measurements(tmp_path)
