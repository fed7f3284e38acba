"""A sleeve from case to report: the joint's blocks, angles in place of displacements, tables and maps."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from support.limb_lines import fitted, taut

import etextile as et
from etextile.studies.run.drawing import limb_at
from etextile.text.run import report_text
from etextile.types import Array
from loadcases.build_worn import limb_of
from loadcases.catalogue import ROOT
from loadcases.reader import stored_case
from wires.trust import ENERGY_LIMIT


pytestmark = pytest.mark.slow
SHORT = {"fabric.coarsening": 52, "motion.flexion": 60, "motion.steps": 6, "fabric.ease": "-2 %"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("sleeve")
    assert et.run(et.load("elbow_sleeve", SHORT), place).exit_code == 0
    return place


def test_the_report_speaks_of_the_joint(folder: Path) -> None:
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    joint = report["joint"]
    assert joint["angle_deg"] == pytest.approx([10, 20, 30, 40, 50, 60])
    assert (np.diff(joint["moment_Nmm"]) > 0.0).all()
    assert len(report["strain"]["warp_max"]) == 6
    assert report["punch"]["displacement_mm"] == []
    assert 0.0 < report["contact"]["pressure_kPa_mean"] < report["contact"]["pressure_kPa_max"]
    assert report["donning"]["growth_mm"][-1] > 0.5
    assert report["donning"]["force_N"][-1] > 0.0
    assert report["trust"]["ok"]


def test_loops_fail_at_angles_and_say_when_they_lie_in_folds(folder: Path) -> None:
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    loops = [loop for wire in report["wires"] for loop in wire["loops"]]
    angles = [loop["first_failure_deg"] for loop in loops if loop["first_failure_deg"] is not None]
    assert angles
    assert all(0.0 <= angle <= 60.0 for angle in angles)
    assert all(loop["first_failure_mm"] is None for loop in loops)
    folded = sum(
        loop["copies"] * wire["copies"] for wire in report["wires"] for loop in wire["loops"] if loop["folded"]
    )
    assert report["verdict"]["undetermined_loops"] == folded > 0
    assert f"{folded} of" in report["verdict"]["sentence"]


def test_the_tables_run_over_the_angle(folder: Path) -> None:
    with (folder / "moment_angle.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["angle_deg"]) for row in rows] == pytest.approx([10, 20, 30, 40, 50, 60])
    run = et.open(folder)
    assert "first_failure_deg" in list(run.tables["loops"].columns)
    assert (folder / "maps" / "failure_flat.png").is_file()


def test_the_text_says_angle_and_moment(folder: Path) -> None:
    report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    text = report_text(report)
    assert "angle, deg" in text
    assert "moment, N m" in text
    assert "Put on, straight" in text
    assert "displacement" not in text


def test_pressure_of_a_tight_sleeve_is_that_of_laplace(folder: Path) -> None:
    run = et.open(folder)
    results = run.results
    step = int(np.flatnonzero(results.displacement_mm <= 0.0)[-1])
    weft = results.family == 1
    force = results.array("force", step)[weft].astype(float)
    x = results.grid.reference[results.cells[weft], 0].mean(axis=1)
    ring = np.isclose(x, x[np.argmin(np.abs(x))])
    spacing = np.ptp(results.grid.reference[:, 0]) / (len(np.unique(x.round(6))) - 1)
    tension = force[ring].mean() / spacing  # N per mm of sleeve
    laplace = 1e3 * tension / (251.0 / (2.0 * np.pi))
    assert run.report["donning"]["pressure_kPa_mean"] == pytest.approx(laplace, rel=0.35)  # the limb is no cylinder


def test_an_ensemble_of_sleeves_counts_from_the_straight_arm(tmp_path: Path) -> None:
    et.ensemble(et.load("elbow_sleeve", {**SHORT, "motion.steps": 3}), tmp_path, samples=2, jobs=1)
    data = json.loads((tmp_path / "ensemble.json").read_text(encoding="utf-8"))
    assert data["unit"] == "deg"
    assert data["failed_runs"] == data["trust"]["samples_over_limits"] == 0
    assert data["fragility"]["displacement_mm"][0] < 0.0  # put on first, mm
    assert data["fragility"]["travel_mm"][-1] == pytest.approx(60.0)
    half = data["specimen"]["half_failed_mm"]["value"]
    assert 0.0 < half < 60.0


BENT = {"fabric.coarsening": 65, "motion.flexion": 60, "motion.steps": 3, "outputs.maps": []}


@pytest.fixture(scope="module")
def on_mesh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short sleeve on the shipped arm, whose mesh, rig and weights are gone when the folder is looked at."""
    place = tmp_path_factory.mktemp("mesh")
    arm = place / "arm"
    shutil.copytree(ROOT / "data" / "arm_cc0", arm)
    names = {"file": "arm.obj", "rig": "rig.json", "weights": "weights.json"}
    changes = {**BENT, "body.grid_spacing": 7}
    changes |= {f"body.{key}": str(arm / name) for key, name in names.items()}
    et.run(et.load("elbow_sleeve_mesh", changes), place / "out")
    shutil.rmtree(arm)
    return place / "out"


def test_a_sleeve_on_a_skinned_mesh_keeps_its_energy_balance(on_mesh: Path) -> None:
    report = json.loads((on_mesh / "report.json").read_text(encoding="utf-8"))
    assert report["solver"]["all_converged"]
    assert report["solver"]["energy_error"] < ENERGY_LIMIT
    assert report["joint"]["name"] == "elbow_left"
    assert (np.diff(report["joint"]["moment_Nmm"]) > 0.0).all()
    assert report["donning"]["growth_mm"][-1] > 5.0


def test_the_folder_of_a_skinned_limb_is_drawn_without_its_mesh(on_mesh: Path) -> None:
    run = et.open(on_mesh)
    case = stored_case(run.results.case.effective, "case")
    straight, bent = (limb_at(run.results, case, step).vertices for step in (-4, -1))
    body = run.results.body
    assert body is not None
    assert body.skin is not None
    assert bent == pytest.approx(body.skin.bent(np.radians(60.0)))
    assert np.abs(bent - straight).max() > 10.0
    assert report_text(run.report)
    assert case.pattern[1] == pytest.approx(1.05 * 251.0)


def test_a_loose_sleeve_says_from_where_on_the_bend_is_too_wide_for_it(tmp_path: Path) -> None:
    """Along the crook the limb's section is an ellipse of 1 / cos 30 deg, less its blend: 7 % more at 60 degrees."""
    loose = {**SHORT, "motion.steps": 2, "outputs.maps": []}
    for ease, said in ((0.05, True), (0.08, False)):
        notes = et.run(et.load("elbow_sleeve", {**loose, "fabric.ease": ease}), tmp_path / str(said)).report["notes"]
        found = [note for note in notes if "too narrow" in note]
        assert len(found) == said
        assert all("grows by 7 % up to 60 deg: from 50 deg on" in note for note in found)


def over_the_tip(run: et.Run) -> Array:
    """Return the fabric's strain at 60 degrees under the loops within 30 degrees of the outer line."""
    wires = run.results.wires
    assert wires is not None
    around = wires.layout.weft_mm[wires.layout.loop_wire] / run.report["case"]["size_mm"][1]
    return np.asarray(wires.span_strain[-1, np.abs(around) < 30.0 / 360.0])


def test_loops_on_the_mesh_strain_less_than_on_the_parametric_elbow_as_its_joint_is_nearer_to_the_skin(
    on_mesh: Path, tmp_path: Path
) -> None:
    on_it = et.open(on_mesh)
    skinned = limb_of(et.load("elbow_sleeve_mesh", {"body.grid_spacing": 7}).case)
    shape = et.load("elbow_sleeve", {**BENT, "fabric.portion": "whole", **fitted(skinned)})
    apart = over_the_tip(et.run(shape, tmp_path)).mean() - over_the_tip(on_it).mean()
    string = taut(limb_of(shape.case), 60.0) - taut(skinned, 60.0)
    assert apart > 0.02
    assert apart == pytest.approx(string, abs=0.01)
