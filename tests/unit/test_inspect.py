"""What inspect says of a file is what the readers do with it: columns, rows left out by line, picture, exit code."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from matplotlib.image import imread

import etextile as et
from etextile.app.cli import main
from etextile.identify.coupon import pull
from etextile.identify.curves import CouponSize, read_curve
from etextile.importers.options import Options, Source
from etextile.laws.powerlaw import PowerLaw
from etextile.studies.inspect import InspectedMesh, Inspection, as_json, runs


STRAIN, STRESS = pull(PowerLaw(3000.0, 0.2, 9960.0, 1.5), 0.12, area_ratio=3.62, loading=60, unloading=12)
SIZE = CouponSize(width=30.0, thickness=0.35, gauge_length=60.0)
AREA = SIZE.width * SIZE.thickness


def export(folder: Path) -> Path:
    """Write an export of a machine that counts the crosshead from -700 mm, pulls in kN and prints `n. c.` as a head."""
    lines = ["Prüfer;Müller", "Breite;30", "Zeit;Traverse;Kraft", "s;mm;kN"]
    for i, (strain, stress) in enumerate(zip(STRAIN, STRESS, strict=True)):
        lines.append(f"{0.1 * i:.1f};{-700.0 + 60.0 * strain:.5f};{1e-3 * AREA * stress:.7f}".replace(".", ","))
    path = folder / "export.TRA"
    path.write_bytes("\r\n".join(lines).encode("latin-1"))
    return path


def pixels(path: Path, colour: str) -> int:
    """Count the pixels of a colour."""
    wanted = np.array([int(colour[i : i + 2], 16) for i in (0, 2, 4)])
    picture = np.rint(255 * imread(path)[..., :3]).astype(int)
    return int((np.abs(picture - wanted).max(axis=2) < 12).sum())


def test_columns_say_what_the_reader_did_to_every_cell(tmp_path: Path) -> None:
    path = export(tmp_path)
    options = Options(zero={"displacement": "first"})
    found = et.inspect(path, options=options, size=SIZE)
    assert isinstance(found, Inspection)
    assert not found.problems
    assert (found.channel, found.rows, len(found.used)) == ("tensile", len(STRAIN), len(STRAIN))
    assert "cp1252" in found.found
    assert "semicolon, decimal comma" in found.found
    curve = read_curve(path, size=SIZE, options=options)
    rows = [line.replace(",", ".").split(";") for line in path.read_bytes().decode("latin-1").split("\r\n")[4:]]
    read = {item.quantity: item for item in found.columns if item.quantity}
    by_hand = {
        name: item.sign * (item.factor * np.array([float(row[item.number - 1]) for row in rows]) - item.zero)
        for name, item in read.items()
    }
    np.testing.assert_allclose(by_hand["displacement_mm"] / SIZE.gauge_length, curve.strain, atol=1e-12)
    np.testing.assert_allclose(by_hand["force_N"] / AREA, curve.stress, rtol=1e-12)
    assert (read["force_N"].unit, read["force_N"].factor, read["displacement_mm"].zero) == ("kN", 1000.0, -700.0)
    assert (found.columns[0].name, found.columns[0].quantity) == ("Zeit", "")


def test_a_sign_that_was_stated_is_shown(tmp_path: Path) -> None:
    path = tmp_path / "compression.csv"
    rows = [f"{-60.0 * e:.6f},{-AREA * s:.6f}" for e, s in zip(STRAIN, STRESS, strict=True)]
    path.write_text("\n".join(["displacement_mm,force_N", *rows]), encoding="utf-8")
    refused = et.inspect(path, size=SIZE)
    assert "sign: -1" in str(refused.problems[0])
    found = et.inspect(path, size=SIZE, options=Options(sign={"": -1}))
    assert isinstance(found, Inspection)
    assert not found.problems
    assert [item.sign for item in found.columns] == [-1, -1]


def test_rows_left_out_are_named_by_line_and_reason(tmp_path: Path) -> None:
    top = int(np.argmax(STRAIN))
    rows = [f"{e:.6f},{s:.5f}" for e, s in zip(STRAIN[: top + 1], STRESS[: top + 1], strict=True)]
    rows[20] = f"{STRAIN[20]:.6f},"
    back = [f"{e:.6f},0.01" for e in np.linspace(STRAIN[top] * 0.999, 0.0, 30)]
    path = tmp_path / "broken.csv"
    path.write_text("\n".join(["strain,stress_MPa", *rows, *back, "end of test"]), encoding="utf-8")
    found = et.inspect(path)
    assert isinstance(found, Inspection)
    out = {item.why: runs(item.lines) for item in found.left_out}
    last = top + 2
    assert out["a quantity has no reading"] == [[22, 22]]
    assert out["after the specimen broke"] == [[last + 1, last + 30]]
    assert out["after the table"] == [[last + 31, last + 31]]
    told = np.concatenate([item.lines for item in found.left_out if item.why != "after the table"])
    assert sorted([*told, *found.used]) == list(range(2, last + 31))
    assert as_json(found)["rows_used"] == len(found.used)


def test_the_channel_follows_from_the_columns(tmp_path: Path) -> None:
    heads = {
        "punch_force": "displacement_mm,force_N",
        "free_edge": "displacement_mm,warp0_mm,warp_mm,weft_mm,height_mm",
        "strain_field": "displacement_mm,warp0_mm,weft0_mm,strain_warp,strain_weft",
        "clamp_line": "displacement_mm,weft0_mm,slip_mm",
        "pressure_height": "pressure_bar,height_mm",
        "joint_moment": "angle_deg,moment_Nmm",
        "moment_curvature": "curvature_1_per_m,moment_Nm_per_m",
    }
    for channel, head in heads.items():
        path = tmp_path / f"{channel}.csv"
        width = head.count(",") + 1
        scale = [1.0 / 60.0 if channel == "strain_field" and j > 2 else 1.0 for j in range(width)]
        rows = [",".join(f"{i * (j + 1) * scale[j]:g}" for j in range(width)) for i in range(1, 12)]
        path.write_text("\n".join([head, *rows]), encoding="utf-8")
        found = et.inspect(path)
        assert isinstance(found, Inspection)
        assert (found.channel, found.problems) == (channel, ()), channel
        assert [item.quantity for item in found.columns] == head.split(",")


def test_a_mesh_is_shown_with_its_box_and_why_it_is_refused(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(radius=20.0, subdivisions=2)
    ball.apply_translation([5.0, 0.0, 100.0])
    ball.export(tmp_path / "ball.stl")
    found = et.inspect(tmp_path / "ball.stl", tmp_path / "ball.png")
    assert isinstance(found, InspectedMesh)
    assert not found.problems
    np.testing.assert_allclose(found.box[:, 2], [80.0, 120.0], atol=0.3)
    np.testing.assert_allclose(found.highest, [5.0, 0.0, 120.0], atol=0.3)
    assert pixels(tmp_path / "ball.png", "d5502a") > 40, "a cross marks the top"
    ball.update_faces(np.arange(len(ball.faces)) > 3)
    ball.export(tmp_path / "open.stl")
    assert "open edges" in str(et.inspect(tmp_path / "open.stl").problems[0])


def test_the_command_draws_left_out_rows_in_grey_and_says_in_the_exit_code_what_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    travel = np.r_[np.linspace(0.0, 40.0, 80), np.linspace(39.9, 30.0, 20)]
    force = np.r_[np.linspace(0.0, 900.0, 80), np.linspace(400.0, 300.0, 20)]
    rows = [f"{x:.4f},{y:.3f}" for x, y in zip(travel, force, strict=True)]
    Path("punch_1.csv").write_text("\n".join(["displacement_mm,force_N", *rows]), encoding="utf-8")
    assert main(["inspect", "punch_1.csv"]) == 0
    said = capsys.readouterr().out
    assert "read as punch force: 80 of 100 rows" in said
    assert "82 to 101" in said
    assert pixels(Path("punch_1_read.png"), "1f4e79") > 200, "rows that count"
    assert pixels(Path("punch_1_read.png"), "a9adb3") > 200, "rows left out"
    assert main(["inspect", "punch_1.csv", "--format", "json", "-o", "none"]) == 0
    assert json.loads(capsys.readouterr().out)["left_out"][0]["lines"] == [[82, 101]]
    Path("two.csv").write_text("\n".join(["Kraft [N],Traverse [mm],Weg [mm]", *(f"{i},{i},{i}" for i in range(20))]))
    assert main(["inspect", "two.csv", "-o", "none"]) == 2
    assert "may both be displacement_mm" in capsys.readouterr().err


def test_a_column_can_be_said_for_inspect_as_for_the_readers(tmp_path: Path) -> None:
    path = tmp_path / "two.csv"
    path.write_text("\n".join(["Kraft [N],Traverse [mm],Weg [mm]", *(f"{i},{i},{2 * i}" for i in range(20))]))
    options = Options(sources={"displacement_mm": Source("Weg"), "force_N": Source("Kraft")})
    found = et.inspect(path, options=options)
    assert isinstance(found, Inspection)
    assert [item.quantity for item in found.columns] == ["force_N", "", "displacement_mm"]


def test_a_channel_nobody_knows_is_refused(tmp_path: Path) -> None:
    with pytest.raises(et.BadInput, match="unknown channel"):
        et.inspect(tmp_path / "any.csv", channel="tensil")


def test_the_way_back_of_a_punch_record_leaves_its_loading_out(tmp_path: Path) -> None:
    travel = np.r_[np.linspace(0.0, 40.0, 81), np.linspace(39.5, 30.0, 20)]
    path = tmp_path / "punch.csv"
    path.write_text("\n".join(["displacement_mm,force_N", *(f"{x:g},{10 * x:g}" for x in travel)]), encoding="utf-8")
    found = et.inspect(path, channel="punch_unloading")
    assert isinstance(found, Inspection)
    assert sorted(found.used) == list(range(82, 103))
    assert [(item.why, runs(item.lines)) for item in found.left_out] == [("no way back", [[2, 81]])]


def test_a_folder_shows_every_file_as_measured_yaml_has_it_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One file is read with a column map, one is refused, one is named nowhere."""
    rows = [f"{x};{2 * x},5" for x in range(1, 13)]
    (tmp_path / "punch.csv").write_text("\n".join(["Weg;Kraft", *rows]), encoding="utf-8")
    (tmp_path / "edge.csv").write_text("displacement_mm,warp0_mm\n1,2\n")
    (tmp_path / "spare.csv").write_text("a,b\n1,2\n")
    (tmp_path / "README.md").write_text("words")
    (tmp_path / "measured.yaml").write_text(
        "title: two channels\nchannels:\n  punch_force: {files: [punch.csv], columns: {displacement_mm: {column: Weg, "
        "unit: mm}, force_N: {column: Kraft, unit: N}}}\n  free_edge: {file: edge.csv}\n"
    )
    found = et.inspect_folder(tmp_path)
    assert [(item.file, item.channel) for item in found.files] == [
        ("punch.csv", "punch_force"), ("edge.csv", "free_edge"), ("spare.csv", ""),
    ]  # fmt: skip
    punch, edge, _ = found.files
    assert punch.found is not None
    assert len(punch.found.used) == 12
    assert edge.problems
    assert main(["inspect", str(tmp_path)]) == 2
    said = capsys.readouterr()
    assert "12 of 12" in said.out
    assert "edge.csv" in said.err
    (tmp_path / "measured.yaml").unlink()
    assert main(["inspect", str(tmp_path)]) == 2
    assert "no measured.yaml in this folder" in capsys.readouterr().err
