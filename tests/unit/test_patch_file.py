"""Patch files: up to which strains they hold, and which case they belong to."""

from __future__ import annotations

from pathlib import Path

import pytest

from etextile.errors import BadInput
from loadcases import catalogue
from loadcases.patch import Patch, PatchedCase, Strains, Validity, beyond, dump_patch, misfit, read_patch
from loadcases.reader import LoadedCase, load_case


STRETCHED = {"warp": 0.4, "weft": 0.6, "diagonal": 0.2}
TEXT = """schema_version: 1
title: clamp_slip
effects: [{{id: clamp_slip, limit: 9}}]
valid: {{displacement: [0, 40], strain: {strain}}}
"""


def patch(*, base: PatchedCase | None = None, strain: Strains | None = None) -> Patch:
    return Patch(
        schema_version=1, title="test", base=base, effects=(), valid=Validity(displacement=(0.0, 40.0), strain=strain)
    )


def made_for(loaded: LoadedCase) -> Patch:
    return patch(base=PatchedCase(title=loaded.case.title, sha256=loaded.sha256))


def remark(found: Patch, loaded: LoadedCase, folder: Path) -> str:
    problem = misfit(found, loaded, folder / "patch.yaml")
    return "" if problem is None else problem.message


@pytest.fixture
def other_fabric(tmp_path: Path) -> Path:
    """A fabric beside a patch that is a tenth stiffer along the warp than the shipped one."""
    text = catalogue.find("fabric", load_case("punch").case.fabric.set).read_text(encoding="utf-8")
    changed = text.replace("E: 3000 ", "E: 3300 ", 1)
    assert changed != text
    path = tmp_path / "fabric.yaml"
    path.write_text(changed, encoding="utf-8")
    return path


def test_strains_are_kept_by_family(tmp_path: Path) -> None:
    known = Strains(warp=0.24, weft=0.26, diagonal=0.27)
    (tmp_path / "patch.yaml").write_text(dump_patch(patch(strain=known)))
    valid = read_patch(tmp_path / "patch.yaml").valid
    assert valid is not None
    assert valid.strain == known


def test_one_number_counts_for_every_family(tmp_path: Path) -> None:
    (tmp_path / "patch.yaml").write_text(TEXT.format(strain="38 %"))
    valid = read_patch(tmp_path / "patch.yaml").valid
    assert valid is not None
    assert valid.strain == Strains(warp=0.38, weft=0.38, diagonal=0.38)


@pytest.mark.parametrize("strain", ["much", "-0.1", "{warp: 0.1, weft: 0.1}"])
def test_other_strains_are_refused(tmp_path: Path, strain: str) -> None:
    (tmp_path / "patch.yaml").write_text(TEXT.format(strain=strain))
    with pytest.raises(BadInput, match=r"valid\.strain"):
        read_patch(tmp_path / "patch.yaml")


def test_strains_beyond_the_fitted_ones_are_told_by_family() -> None:
    found = beyond(patch(strain=Strains(warp=0.24, weft=0.27, diagonal=0.27)), STRETCHED)
    assert found == (
        "the patch was fitted up to 0.24 warp strain, this run reaches 0.4; up to 0.27 weft strain, "
        "this run reaches 0.6"
    )


def test_strains_within_the_fitted_ones_and_unknown_ones_are_not_worth_a_word() -> None:
    assert beyond(patch(strain=Strains(**STRETCHED)), STRETCHED) is None
    assert beyond(patch(), STRETCHED) is None
    assert beyond(patch().model_copy(update={"valid": None}), STRETCHED) is None


def test_a_patch_fits_the_case_it_was_made_for_and_any_when_it_names_none(tmp_path: Path) -> None:
    loaded = load_case("punch")
    assert remark(made_for(loaded), loaded, tmp_path) == ""
    assert remark(patch(), loaded, tmp_path) == ""


def test_a_case_of_another_title_is_another_case(tmp_path: Path) -> None:
    assert "another case (Punch test)" in remark(made_for(load_case("punch")), load_case("elbow"), tmp_path)


def test_a_forgotten_fabric_beside_the_patch_is_named(other_fabric: Path, tmp_path: Path) -> None:
    found = made_for(load_case("punch", overrides=[f"fabric.set={other_fabric}"]))
    said = remark(found, load_case("punch"), tmp_path)
    assert "another fabric" in said
    assert f"--set fabric.set={other_fabric}" in said
    assert "another case" not in said


def test_what_cannot_be_known_is_said_as_a_guess(other_fabric: Path, tmp_path: Path) -> None:
    """Friction and fabric differ: that the diagnosis had the fabric beside the patch is all there is to say."""
    fabric = f"fabric.set={other_fabric}"
    found = made_for(load_case("punch", overrides=[fabric, "contact.friction=0.3"]))
    said = remark(found, load_case("punch"), tmp_path)
    assert "the fabric or another value differs" in said
    assert f"--set {fabric}" in said
    same_fabric = remark(found, load_case("punch", overrides=[fabric]), tmp_path)
    assert "another value differs" in same_fabric
    assert "--set" not in same_fabric
    other_fabric.unlink()
    assert "--set" not in remark(found, load_case("punch"), tmp_path)
