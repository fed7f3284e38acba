"""What a diagnosis hands over: strains of the run with the patch, the case it belongs to, the command to use it."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from etextile.diagnose.data.observe import PEAKS, Record
from etextile.diagnose.decide.proof import EFFECT, Proof
from etextile.studies.diagnose.folder import Folder
from etextile.studies.diagnose.patch import FABRIC, measured_levels, run_command, strains_up_to
from etextile.studies.diagnose.proof import case_to_run, diagnosed_case, lost_points
from etextile.studies.diagnose.setting import DiagnosisTask, assemble
from loadcases.measurements import load_measurements
from loadcases.patch import Strains
from loadcases.reader import LoadedCase, case_sha256, load_case
from loadcases.shipped import measured_folder


MEASURED = load_measurements(measured_folder("hidden_clamp"))
"""Goes to 40 mm."""


def task_of(*overrides: str) -> DiagnosisTask:
    """Return the task on the fabric of the case: the coupons would take their time and change nothing here."""
    task = assemble(load_case("punch", overrides=overrides), MEASURED, own_fabric=True, among=["clamp_slip"])
    return replace(task, fabric=None)


def as_printed(task: DiagnosisTask, folder: Path) -> LoadedCase:
    """Return the case that the printed command runs."""
    words = shlex.split(run_command(task, folder / "patch.yaml"))
    assert words[:2] == ["etextile", "run"]
    assert words[-2:] == ["--patch", str(folder / "patch.yaml")]
    assert set(words[3:-2:2]) <= {"--set"}
    return load_case(words[2], overrides=words[4:-2:2])


@pytest.mark.parametrize(
    "overrides",
    [
        (),
        ("motion.total=35 mm",),
        ("motion.total=35 mm", "motion.steps=5"),
        ("motion.total=45", "motion.path=[10, 5, 45]"),
    ],
)
def test_command_and_hash_belong_to_the_case_that_was_run(overrides: tuple[str, ...], tmp_path: Path) -> None:
    task = task_of(*overrides)
    run, notes = diagnosed_case(task, measured_levels(task), Folder(tmp_path, "key"))
    assert case_sha256(case_to_run(task, Folder(tmp_path, "key"))) == run.sha256
    printed = as_printed(task, tmp_path)
    assert printed.sha256 == run.sha256
    assert printed.case.motion.travel >= 40.0
    assert bool(notes) == bool(overrides)
    command = run_command(task, tmp_path / "patch.yaml")
    assert ("motion.path=null" in command) == any("path" in item for item in overrides)
    assert overrides or "--set" not in command


def test_the_command_names_the_fabric_of_the_coupons(tmp_path: Path) -> None:
    task = assemble(load_case("punch", overrides=["motion.total=35"]), MEASURED, among=["clamp_slip"])
    run, _ = diagnosed_case(task, measured_levels(task), Folder(tmp_path, "key"))
    printed = as_printed(task, tmp_path)
    assert Path(printed.case.fabric.set) == tmp_path / FABRIC
    assert printed.sha256 == run.sha256


def test_strains_count_up_to_the_measured_displacement_only() -> None:
    report = {
        "punch": {"displacement_mm": [10.0, 30.0, 50.0]},
        "strain": {"warp_max": [0.1, 0.2, 0.6], "weft_max": [0.3, 0.1, 0.1], "diagonal_max": [0.0, 0.1, 0.3]},
    }
    assert strains_up_to(40.0, report) == Strains(warp=0.4, weft=0.3, diagonal=0.2)
    assert strains_up_to(60.0, report) == Strains(warp=0.6, weft=0.3, diagonal=0.3)


def test_points_that_a_broken_off_run_does_not_reach_are_told() -> None:
    travel = np.linspace(1.0, 40.0, 40)
    x = np.zeros(2)
    whole = Record(x, x, (True, True), travel, travel, np.zeros((40, 2, 2, 3)), np.zeros((40, len(PEAKS))))
    short = replace(whole, displacement=travel[:33], force=travel[:33], completed=False)
    runs = {"the run with the patch": whole, "the other run": short}
    for end, said in ((40, ""), (33, "7 of 40 measured points, 7 of them held out")):
        predicted = np.where(np.arange(40) < end, travel, np.nan)
        proof = Proof({EFFECT: predicted}, travel > 30.0, np.ones(40), (), {})
        found = lost_points(proof, runs)
        assert found.startswith(said)
        assert ("the other run finds no equilibrium beyond 33.0 mm" in found) == (end < 40)
        assert "the run with the patch" not in found
