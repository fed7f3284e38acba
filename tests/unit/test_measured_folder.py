"""Folders of measurements: all channels read, units converted, everything that is wrong said at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from etextile.errors import BadInput
from loadcases.measurements import load_measurements


STRAIN = np.linspace(0.0, 0.12, 25)
FILES = {
    "punch_1.csv": ["displacement_mm,force_N", *(f"{d},{0.4 * d**2:.3f}" for d in range(12))],
    "punch_2.csv": ["displacement_mm,force_N", *(f"{d},{0.41 * d**2:.3f}" for d in range(12))],
    "free_edge.csv": [
        "displacement_mm,warp0_mm,warp_mm,weft_mm,height_mm",
        *(f"{d},{w},{w},50,0" for d in (0, 10) for w in (0, 20, 40)),
    ],
    "warp_1.csv": ["strain,stress_MPa", *(f"{e:.4f},{300 * e:.4f}" for e in STRAIN)],
    "weft_1.csv": ["strain,stress_MPa", *(f"{e:.4f},{250 * e:.4f}" for e in STRAIN)],
    "bare.csv": [f"{60 * e:.4f},{2900 * e:.4f}" for e in STRAIN],
    "field.csv": [
        "displacement_mm,warp0_mm,weft0_mm,strain_warp,strain_weft",
        *(f"{d},{w},0,0.01,0" for d in (10, 20) for w in (0, 20, 40)),
    ],
    "clamp.csv": ["displacement_mm,weft0_mm,slip_mm", *(f"{d},{w},0" for d in (10, 20) for w in (0, 20, 40))],
    "wires.csv": ["displacement_mm,wire,warp0_mm,state", "20,0,0,intact", "40,0,0,open"],
}
YAML = """\
title: punch test
channels:
  punch_force: {files: [punch_1.csv, punch_2.csv], noise: 0.002 kN}
  free_edge: {file: free_edge.csv, noise: 0.02 cm}
  tensile:
    warp: [warp_1.csv]
    weft: [weft_1.csv]
    bias: [{file: bare.csv, width: 2.9 cm, thickness: 0.35 mm, gauge_length: 60, columns: [displacement_mm, force_N]}]
  strain_field: {file: field.csv, noise: 0.3 %}
  clamp_line: {file: clamp.csv, noise: 0.1 mm}
  wires: {file: wires.csv}
"""


def folder(path: Path, yaml: str = YAML, **changed: list[str]) -> Path:
    for name, lines in FILES.items():
        (path / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
    for stem, lines in changed.items():
        (path / f"{stem}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (path / "measured.yaml").write_text(yaml, encoding="utf-8")
    return path


def problems(path: Path) -> list[tuple[str, int | None, str, str]]:
    with pytest.raises(BadInput) as caught:
        load_measurements(path)
    return [(Path(item.file).name, item.line, item.key, item.message) for item in caught.value.problems]


def test_every_channel_is_read_and_units_are_converted(tmp_path: Path) -> None:
    found = load_measurements(folder(tmp_path))
    assert found.channels == ("punch_force", "free_edge", "tensile", "strain_field", "clamp_line", "wires")
    assert [item.noise for item in found.punch_force] == [2.0, 2.0]
    assert found.free_edge is not None
    assert found.free_edge.noise == pytest.approx(0.2)
    assert found.strain_field is not None
    assert found.strain_field.noise == pytest.approx(0.003)
    (bias,) = found.tensile["bias"]
    np.testing.assert_allclose(bias.stress, 2900.0 * STRAIN / (29.0 * 0.35), atol=1e-4)
    np.testing.assert_allclose(bias.strain, STRAIN, atol=1e-5)
    assert found.title == "punch test"


def test_one_channel_is_enough_and_the_file_itself_may_be_named(tmp_path: Path) -> None:
    folder(tmp_path, "title: forces\nchannels:\n  punch_force: {files: [punch_1.csv]}\n")
    found = load_measurements(tmp_path / "measured.yaml")
    assert found.channels == ("punch_force",)
    assert found.punch_force[0].noise is None


def test_size_and_columns_of_all_tensile_files_stand_once(tmp_path: Path) -> None:
    yaml = """\
title: bare files
channels:
  tensile:
    columns: [displacement_mm, force_N]
    width: 29
    thickness: 0.35
    gauge_length: 60
    warp: [bare.csv]
"""
    (curve,) = load_measurements(folder(tmp_path, yaml)).tensile["warp"]
    assert curve.strain[-1] == pytest.approx(0.12)


def test_everything_wrong_is_said_at_once_with_its_place(tmp_path: Path) -> None:
    yaml = YAML.replace("noise: 0.02 cm", "noise: 3 N").replace("[weft_1.csv]", "[weft_l.csv]")
    yaml = yaml.replace("  clamp_line:", "  clampline:")
    found = problems(folder(tmp_path, yaml, punch_2=["displacement_mm,force_N", "0,1", "1,x"]))
    assert ("measured.yaml", 4, "channels.free_edge.noise") in [item[:3] for item in found]
    assert ("measured.yaml", 7, "channels.tensile.weft.0") in [item[:3] for item in found]
    assert ("measured.yaml", 10, "channels.clampline") in [item[:3] for item in found]
    assert ("punch_2.csv", 3, "force_N") in [item[:3] for item in found]
    assert len(found) == 4
    assert any("did you mean 'weft_1.csv'" in message for *_, message in found)
    assert any("did you mean 'clamp_line'" in message for *_, message in found)


def test_a_file_named_twice_and_an_incomplete_size_are_refused(tmp_path: Path) -> None:
    yaml = YAML.replace("[punch_1.csv, punch_2.csv]", "[punch_1.csv, punch_1.csv]").replace("thickness: 0.35 mm, ", "")
    found = problems(folder(tmp_path, yaml))
    assert [(line, key) for _, line, key, _ in found] == [
        (3, "channels.punch_force.files.1"),
        (8, "channels.tensile.bias.0"),
    ]
    assert "belong together" in found[1][3]


@pytest.mark.parametrize(
    ("yaml", "message"),
    [
        ("title: nothing\nchannels: {}\n", "no channel, give at least one of punch_force"),
        ("title: nothing\nchannels: {tensile: {width: 29}}\n", "no specimens"),
        ("title: nothing\n", "give channels or tests"),
        ("", "the file is empty"),
    ],
)
def test_a_folder_without_measurements_is_refused(tmp_path: Path, yaml: str, message: str) -> None:
    (problem,) = problems(folder(tmp_path, yaml))
    assert message in problem[3]


def test_a_table_in_the_place_of_a_measured_yaml_is_told_what_it_lacks(tmp_path: Path) -> None:
    table = tmp_path / "export.csv"
    table.write_bytes("strain\tstress_MPa\n0\t0\n".encode("utf-16"))
    with pytest.raises(BadInput, match=r"measured\.yaml .*etextile inspect FILE .*--warp FILE"):
        load_measurements(table)


def test_a_folder_without_measured_yaml_says_what_it_holds(tmp_path: Path) -> None:
    (tmp_path / "measurd.yaml").write_text("title: x\n", encoding="utf-8")
    with pytest.raises(BadInput, match=r"no measured\.yaml in this folder, it holds measurd\.yaml"):
        load_measurements(tmp_path)
    with pytest.raises(BadInput, match="no such folder of measurements"):
        load_measurements(tmp_path / "nowhere")


@pytest.mark.parametrize(
    ("before", "after", "line", "channel"),
    [
        ("0.002 kN", "0.2 kN", 3, "punch_force"),
        ("0.02 cm", "200 mm", 4, "free_edge"),
        ("0.3 %", "30 %", 9, "strain_field"),
    ],
)
def test_a_noise_as_large_as_the_readings_is_refused(
    tmp_path: Path, before: str, after: str, line: int, channel: str
) -> None:
    (found,) = problems(folder(tmp_path, YAML.replace(before, after)))
    assert found[:3] == ("measured.yaml", line, f"channels.{channel}.noise")
    assert "as large as what was read (got " in found[3]


def test_the_slip_of_a_clamp_that_holds_is_noise_and_nothing_else(tmp_path: Path) -> None:
    found = load_measurements(folder(tmp_path))
    assert found.clamp_line is not None
    assert (found.clamp_line.slip.max(), found.clamp_line.noise) == (0.0, 0.1)


def test_one_specimen_in_another_unit_is_refused_with_its_file(tmp_path: Path) -> None:
    kilonewtons = ["displacement_mm,force_N", *(f"{d},{5e-3 * d**2:.6f}" for d in range(12))]
    (found,) = problems(folder(tmp_path, punch_2=kilonewtons))
    assert found[:3] == ("punch_2.csv", 13, "force_N")


def test_rows_remember_their_lines(tmp_path: Path) -> None:
    """Comments and blank lines count as lines of the file."""
    header, *rows = FILES["free_edge.csv"]
    found = load_measurements(folder(tmp_path, free_edge=[header, "# a comment", "", *rows]))
    assert found.free_edge is not None
    assert [found.free_edge.line(row) for row in (0, 5)] == [4, 9]
    assert found.wires is not None
    assert found.wires.line(1) == 3
