"""Output folders of compare and diagnose: what tells questions apart, and what is left of the answer before."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from etextile.errors import BadInput
from etextile.studies.diagnose.folder import claim, key_of
from etextile.studies.diagnose.run import FILES
from etextile.studies.diagnose.setting import DiagnosisTask, assemble
from loadcases.measurements import load_measurements
from loadcases.reader import load_case
from loadcases.shipped import measured_folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of shipped measurements."""
    return Path(shutil.copytree(measured_folder("hidden_clamp"), tmp_path / "set"))


def task_of(folder: Path, *, seed: int = 0) -> DiagnosisTask:
    return assemble(load_case("punch"), load_measurements(folder), name_effects=False, own_fabric=True, seed=seed)


def test_another_noise_is_another_question(folder: Path, tmp_path: Path) -> None:
    """The noise stands in measured.yaml alone, whatever the file is called."""
    first = task_of(folder)
    assert key_of(first) == key_of(task_of(measured_folder("hidden_clamp")))
    claim(tmp_path / "out", first, FILES, verb="diagnose", force=False).write("diagnosis.json", "{}")
    text = (folder / "measured.yaml").read_text(encoding="utf-8")
    (folder / "louder.yaml").write_text(text.replace("4.127 N", "41.27 N"), encoding="utf-8")
    second = task_of(folder / "louder.yaml")
    assert second.measured.punch_force[0].noise == 41.27
    assert key_of(second) != key_of(first)
    with pytest.raises(BadInput, match=r"holds diagnosis\.json of another case or measurement"):
        claim(tmp_path / "out", second, FILES, verb="diagnose", force=False)


def test_no_run_of_the_answer_before_lies_beside_the_next(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    task = task_of(folder)
    claimed = claim(out, task, FILES, verb="diagnose", force=False)
    claimed.write("patch.yaml", "")
    for name in ("base", "patched", "held_out", "cache", "mine"):
        (out / name / "deeper").mkdir(parents=True)
        (out / name / "deeper" / "results.h5").write_text("")
    claim(out, task, FILES, verb="diagnose", force=False)
    assert sorted(path.name for path in out.iterdir()) == ["cache", "made_from.json", "mine"]
    assert (claimed.cache / "deeper" / "results.h5").is_file()


def test_a_link_is_taken_away_and_what_it_points_at_is_kept(folder: Path, tmp_path: Path) -> None:
    out, other = tmp_path / "out", tmp_path / "other"
    task = task_of(folder)
    claim(out, task, FILES, verb="diagnose", force=False)
    other.mkdir()
    (other / "results.h5").write_text("")
    (out / "base").symlink_to(other, target_is_directory=True)
    claim(out, task, FILES, verb="diagnose", force=False)
    assert not (out / "base").exists()
    assert (other / "results.h5").is_file()
