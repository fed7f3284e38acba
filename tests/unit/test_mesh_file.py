"""Meshes as modellers, scanners and downloads leave them: welded, capped, centred, or named for what they are."""

from __future__ import annotations

import struct
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from etextile.contact.caps import capped, rims
from etextile.contact.mesh import prepared
from etextile.contact.mesh_file import open_edges, read_triangles
from etextile.errors import BadInput
from loadcases.build import plan
from loadcases.reader import load_case


BOX = trimesh.creation.box((40.0, 30.0, 20.0))
CORNERS, FACES = np.array(BOX.vertices), np.array(BOX.faces)


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def obj(*, normals: bool = False, seams: bool = False, header: str = "") -> str:
    """Write the box with its corners split by normals per face or by a texture seam per triangle."""
    lines = [header, *(f"v {x} {y} {z}" for x, y, z in CORNERS)]
    if normals:
        lines += [f"vn {x} {y} {z}" for x, y, z in BOX.face_normals]
    if seams:
        lines += [f"vt {i / 36} {(i * 7 % 36) / 36}" for i in range(36)]
    for number, face in enumerate(FACES):
        words = [
            f"{v + 1}/{3 * number + i + 1 if seams else ''}/{number + 1 if normals else ''}".rstrip("/")
            for i, v in enumerate(face)
        ]
        lines.append("f " + " ".join(words))
    return "\n".join(lines) + "\n"


def split_ply() -> str:
    head = "ply\nformat ascii 1.0\ncomment TextureFile secret.png\nelement vertex 36\n"
    head += "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    head += "element face 12\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [
        " ".join(str(value) for value in (*CORNERS[v], *BOX.face_normals[f]))
        for f, face in enumerate(FACES)
        for v in face
    ]
    return head + "\n".join(rows) + "\n" + "".join(f"3 {3 * f} {3 * f + 1} {3 * f + 2}\n" for f in range(12))


def save_3mf(file: Path, *, unit: str = "millimeter", scale: float = 1.0, transform: str = "") -> Path:
    points = "".join(f'<vertex x="{x * scale}" y="{y * scale}" z="{z * scale}"/>' for x, y, z in CORNERS)
    corners = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in FACES)
    place = f' transform="{transform}"' if transform else ""
    text = (
        f'<?xml version="1.0"?><model unit="{unit}" '
        'xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02"><resources><object id="1" type="model">'
        f"<mesh><vertices>{points}</vertices><triangles>{corners}</triangles></mesh></object></resources>"
        f'<build><item objectid="1"{place}/></build></model>'
    )
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("3D/3dmodel.model", text)
    return file


SPLIT = {
    "normals.obj": obj(normals=True),
    "seams.obj": obj(seams=True),
    "both.obj": obj(normals=True, seams=True),
    "materials.obj": obj(header="mtllib none.mtl\nusemtl red").replace("\nf 5", "\nusemtl blue\nf 5", 1),
    "split.ply": split_ply(),
}


def test_a_mesh_whose_triangles_have_no_area_is_named(tmp_path: Path) -> None:
    file = tmp_path / "flat.stl"
    file.write_bytes(bytes(80) + struct.pack("<I", 2) + 2 * struct.pack("<12fH", *[0.0] * 3, *[7.0, 1.0, 2.0] * 3, 0))
    with pytest.raises(BadInput, match="none of its triangles has an area"):
        prepared(file)


@pytest.mark.parametrize("name", SPLIT)
def test_a_box_whose_vertices_are_split_is_closed_again(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.write_text(SPLIT[name], encoding="utf-8")
    vertices, faces, _ = prepared(file)
    assert (len(vertices), len(faces)) == (8, 12)
    assert volume(vertices, faces) == pytest.approx(40.0 * 30.0 * 20.0)


def test_positions_that_differ_by_rounding_are_one_vertex(tmp_path: Path) -> None:
    shape = trimesh.creation.icosphere(subdivisions=3, radius=50.0)
    corners = shape.vertices[shape.faces].reshape(-1, 3)
    corners = corners + np.random.default_rng(0).normal(0.0, 5e-6, corners.shape)
    soup = trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)
    soup.export(str(tmp_path / "soup.ply"))
    vertices, faces, notes = prepared(tmp_path / "soup.ply")
    assert len(vertices) == len(shape.vertices)
    assert open_edges(faces) == 0
    assert "welded" in notes[0]


def test_nothing_outside_of_the_file_is_opened(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Materials and textures of a mesh are other files: a named pipe among them would hang, a path would be read."""
    (tmp_path / "secret.mtl").write_text("newmtl red\nmap_Kd secret.png\n", encoding="utf-8")
    opened: list[str] = []
    original = Path.read_bytes

    def watched(path: Path) -> bytes:
        opened.append(path.name)
        return original(path)

    monkeypatch.setattr(Path, "read_bytes", watched)
    monkeypatch.setattr(
        trimesh.resolvers.FilePathResolver, "get", lambda self, name: opened.append(name) or b"", raising=True
    )
    for name, text in (("box.obj", obj(header="mtllib secret.mtl\nusemtl red")), ("box.ply", split_ply())):
        (tmp_path / name).write_text(text, encoding="utf-8")
        assert len(read_triangles(tmp_path / name)[1]) == 12
    assert opened == ["box.obj", "box.ply"]


@pytest.mark.parametrize(("unit", "scale"), [("millimeter", 1.0), ("meter", 1e-3), ("inch", 1.0 / 25.4)])
def test_3mf_is_read_in_its_unit_where_its_build_puts_it(tmp_path: Path, unit: str, scale: float) -> None:
    shift = f"1 0 0 0 1 0 0 0 1 {100 * scale} 0 0"
    vertices, faces, _ = prepared(save_3mf(tmp_path / "box.3mf", unit=unit, scale=scale, transform=shift))
    assert volume(vertices, faces) == pytest.approx(40.0 * 30.0 * 20.0)
    np.testing.assert_allclose(vertices.mean(axis=0), [100.0, 0.0, 0.0], atol=1e-9)


def test_a_3mf_with_entities_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "bomb.3mf"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("3D/3dmodel.model", '<!DOCTYPE a [<!ENTITY b "c">]><model>&b;</model>')
    with pytest.raises(BadInput, match="a document type"):
        read_triangles(file)


NAMED: dict[str, tuple[bytes, str]] = {
    "lfs.stl": (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n", "pointer of Git LFS"),
    "lfs.obj": (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n", "pointer of Git LFS"),
    "page.ply": (b"<!DOCTYPE html>\n<html><body>Not Found</body></html>", "a web page (HTML)"),
    "page.obj": (b"\n  <html lang='en'><head></head></html>", "a web page (HTML)"),
    "zipped.stl": (b"PK\x03\x04" + bytes(100), "a zip archive"),
    "packed.ply": (b"\x1f\x8b\x08" + bytes(100), "gzip"),
}


@pytest.mark.parametrize("name", NAMED)
def test_a_file_that_is_something_else_is_named_for_what_it_is(tmp_path: Path, name: str) -> None:
    content, words = NAMED[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(BadInput) as caught:
        read_triangles(tmp_path / name)
    assert words in str(caught.value)


def tube(*, tilt: float = 0.0) -> trimesh.Trimesh:
    """Return the open side of a cylinder of radius 30 and length 120, as a scan of a limb is cut."""
    shape = trimesh.creation.cylinder(30.0, 120.0, sections=48)
    side = np.abs(shape.face_normals[:, 2]) < 0.5
    open_ = trimesh.Trimesh(shape.vertices, shape.faces[side], process=True)
    open_.vertices[:, 2] += tilt * open_.vertices[:, 0]
    return open_


@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_planar_holes_are_closed_on_request_and_enclose_the_volume(tmp_path: Path, tilt: float) -> None:
    shape = tube(tilt=tilt)
    shape.export(str(tmp_path / "limb.stl"))
    with pytest.raises(BadInput, match=r"not watertight: 96 open edges.*cap_holes: true"):
        prepared(tmp_path / "limb.stl")
    vertices, faces, notes = prepared(tmp_path / "limb.stl", cap_holes=True)
    area = 0.5 * 48 * 30.0**2 * np.sin(2 * np.pi / 48)
    assert volume(vertices, faces) == pytest.approx(120.0 * area, rel=1e-5)
    assert len(notes) == 2
    assert all("planar hole" in note for note in notes)


def test_a_hole_that_is_not_planar_is_left_to_a_person() -> None:
    shape = trimesh.creation.icosphere(subdivisions=2, radius=30.0)
    keep = (shape.triangles_center[:, 0] < 10.0) | (shape.triangles_center[:, 2] < 0.0)
    with pytest.raises(BadInput, match="that is not planar"):
        capped(np.array(shape.vertices), np.array(shape.faces)[keep], name="dented")


def test_rims_run_around_every_hole() -> None:
    shape = tube()
    found = rims(np.array(shape.faces, dtype=np.int64))
    assert sorted(len(rim) for rim in found) == [48, 48]


def case_of(folder: Path, **body: Any) -> Path:
    lines = "".join(f"  {key}: {value}\n" for key, value in body.items())
    file = folder / "case.yaml"
    file.write_text(
        "schema_version: 1\nextends: punch\ntitle: mesh\n"
        f"fabric: {{portion: whole, size: [100, 100]}}\nbody:\n  type: mesh\n{lines}motion: {{total: 5, steps: 2}}\n",
        encoding="utf-8",
    )
    return file


@pytest.fixture
def far(tmp_path: Path) -> Path:
    shape = trimesh.creation.icosphere(subdivisions=3, radius=15.0)
    shape.apply_translation((310.0, -95.0, 20.0))
    shape.export(str(tmp_path / "far.stl"))
    return tmp_path


def checked(file: Path) -> str:
    loaded = load_case(file)
    with loaded.locating():
        return "\n".join(plan(loaded.case)["notes"])


def test_check_refuses_a_body_beside_the_specimen_and_says_how_to_centre_it(far: Path) -> None:
    with pytest.raises(BadInput) as caught:
        checked(case_of(far, file="far.stl"))
    (problem,) = caught.value.problems
    assert problem.key == "body.position"
    assert problem.line is not None
    assert "at x = 310, y = -95 mm" in problem.message
    assert "write position: centre, or position: [-310, 95]" in problem.message


@pytest.mark.parametrize("position", ["centre", "[-310, 95]"])
def test_scanner_coordinates_are_brought_over_the_specimen(far: Path, position: str) -> None:
    assert "highest point at x = 0, y = 0 mm" in checked(case_of(far, file="far.stl", position=position)).replace(
        "-0 ", "0 "
    )


def test_centring_holds_for_a_turned_body(far: Path) -> None:
    said = checked(case_of(far, file="far.stl", position="centre", rotation="[90, 0, 30]"))
    assert "highest point at x = 0, y = 0 mm" in said


def test_check_finds_an_open_mesh(far: Path) -> None:
    tube().export(str(far / "open.stl"))
    with pytest.raises(BadInput, match="not watertight"):
        checked(case_of(far, file="open.stl"))
