"""A run with a patch says where the patch does not fit: another case, displacements and strains beyond its data."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from etextile.app.cli import main
from loadcases.patch import Patch, PatchedCase, Strains, Validity, dump_patch
from loadcases.reader import load_case


SETTINGS = ("fabric.coarsening=80", "wires=null", "outputs.maps=[]", "motion.total=10", "motion.steps=4")
FITTED = Strains(warp=1.0, weft=0.0001, diagonal=1.0)


def notes(folder: Path, patch: Patch) -> list[str]:
    """Run the case with a patch and return the notes of the report."""
    folder.mkdir(exist_ok=True)
    (folder / "patch.yaml").write_text(dump_patch(patch))
    settings = [part for item in SETTINGS for part in ("--set", item)]
    assert main(["run", "punch", *settings, "--patch", str(folder / "patch.yaml"), "-o", str(folder / "out")]) in (0, 4)
    found: list[str] = json.loads((folder / "out" / "report.json").read_text())["notes"]
    return found


def patch(*, base: PatchedCase | None, reach: float = 10.0) -> Patch:
    valid = Validity(displacement=(0.0, reach), strain=FITTED)
    return Patch(schema_version=1, title="test", base=base, effects=(), valid=valid)


def test_a_patch_of_this_case_is_measured_by_the_strains_of_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    loaded = load_case("punch", overrides=SETTINGS)
    found = notes(tmp_path, patch(base=PatchedCase(title=loaded.case.title, sha256=loaded.sha256)))
    largest = max(json.loads((tmp_path / "out" / "report.json").read_text())["strain"]["weft_max"])
    assert f"the patch was fitted up to 0.0001 weft strain, this run reaches {largest:.3g}" in found
    assert not [note for note in found if "case" in note or "extrapolates" in note]
    captured = capsys.readouterr()
    assert "warning" not in captured.err
    assert "the patch was fitted up to" in captured.out


def test_a_patch_of_another_case_is_told_before_and_after(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = notes(tmp_path, patch(base=PatchedCase(title="Punch test", sha256="0" * 64), reach=5.0))
    said = "the patch was made for a case of this title, but the fabric or another value differs"
    assert said in found
    assert f"warning: {tmp_path / 'patch.yaml'}: {said}" in capsys.readouterr().err
    assert "the patch was found up to 5 mm; beyond that it extrapolates" in found


def test_a_patch_that_names_no_case_is_told_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "the patch does not say which case it was made for" in notes(tmp_path, patch(base=None))
    assert "warning" not in capsys.readouterr().err
