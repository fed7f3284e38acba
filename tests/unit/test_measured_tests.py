"""Several tests in one folder: each with its own changes of the case, its channels, and the folder it is added to."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from etextile.errors import BadInput
from loadcases.measurements import load_measurements


def record(path: Path, displacement: np.ndarray, force: np.ndarray) -> None:
    rows = [f"{u:.3f},{f:.3f}" for u, f in zip(displacement, force, strict=True)]
    path.write_text("\n".join(["displacement_mm,force_N", *rows]) + "\n")


@pytest.fixture
def first(tmp_path: Path) -> Path:
    """A punch to 40 mm and back to 30 mm, in one record."""
    folder = tmp_path / "first"
    folder.mkdir()
    there, back = np.linspace(1.0, 40.0, 40), np.linspace(39.5, 30.0, 20)
    record(
        folder / "punch.csv", np.concatenate([there, back]), np.concatenate([there**2, 1600.0 - 150.0 * (40.0 - back)])
    )
    (folder / "measured.yaml").write_text(
        "title: first\nchannels:\n  punch_force: {files: [punch.csv], noise: 2 N}\n"
        "  punch_unloading: {files: [punch.csv], noise: 2 N}\n"
    )
    return folder


def test_one_record_holds_the_way_there_and_the_way_back(first: Path) -> None:
    found = load_measurements(first)
    assert found.channels == ("punch_force", "punch_unloading")
    assert found.punch_force[0].displacement[-1] == 40.0
    back = found.punch_unloading[0]
    assert (back.displacement[0], back.displacement[-1]) == (30.0, 40.0)
    assert back.force[0] == pytest.approx(100.0)


def test_further_tests_are_added_to_the_first_with_their_changes_of_the_case(first: Path, tmp_path: Path) -> None:
    folder = tmp_path / "next"
    folder.mkdir()
    record(folder / "wide.csv", np.linspace(1.0, 30.0, 30), np.linspace(1.0, 900.0, 30))
    (folder / "measured.yaml").write_text(
        "title: next\nafter: ../first\ntests:\n"
        "- name: second radius\n  case: {body.radius: 25 mm, motion: {speed: 10}}\n  without: [punch_friction]\n"
        "  channels: {punch_force: {files: [wide.csv], noise: 2 N}}\n"
    )
    found = load_measurements(folder)
    assert found.title == "first"
    assert found.channels == ("punch_force", "punch_unloading")
    (test,) = found.tests
    assert (test.name, test.without) == ("second radius", ("punch_friction",))
    assert test.case == ("body.radius=25 mm", "motion.speed=10")
    assert test.measured.punch_force[0].displacement[-1] == 30.0


def test_a_folder_that_leads_to_itself_and_a_record_that_never_falls_are_refused(first: Path, tmp_path: Path) -> None:
    folder = tmp_path / "next"
    folder.mkdir()
    record(folder / "wide.csv", np.linspace(1.0, 30.0, 30), np.linspace(1.0, 900.0, 30))
    text = "title: next\nafter: {}\ntests:\n- name: again\n  channels: {{{}: {{files: [wide.csv]}}}}\n"
    (folder / "measured.yaml").write_text(text.format(".", "punch_force"))
    with pytest.raises(BadInput, match="leads back to this folder"):
        load_measurements(folder)
    (folder / "measured.yaml").write_text(text.format("../first", "punch_unloading"))
    with pytest.raises(BadInput, match=r"never falls by 0\.5 mm"):
        load_measurements(folder)


def test_nothing_measured_is_refused_and_two_places_for_one_test_too(tmp_path: Path) -> None:
    (tmp_path / "measured.yaml").write_text("title: nothing\n")
    with pytest.raises(BadInput, match="give channels or tests"):
        load_measurements(tmp_path)
