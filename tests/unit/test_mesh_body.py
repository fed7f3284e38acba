"""Bodies from triangle meshes: what is refused, what is repaired, how exact and how smooth the distance grid is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from etextile.contact import grid
from etextile.contact.mesh import MeshBody, checked, mesh, mesh_body
from etextile.contact.refine import corner_normals, refined
from etextile.errors import BadInput


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Keep baked grids in the test's own folder and forget those in memory."""
    grid._baked.cache_clear()
    monkeypatch.setenv("ETEXTILE_CACHE_DIR", str(tmp_path / "grids"))
    return tmp_path / "grids"


def ball(subdivisions: int = 3, radius: float = 15.0) -> tuple[np.ndarray, np.ndarray]:
    shape = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return np.array(shape.vertices), np.array(shape.faces, dtype=np.int64)


def box() -> tuple[np.ndarray, np.ndarray]:
    shape = trimesh.creation.box((40.0, 30.0, 20.0))
    return np.array(shape.vertices), np.array(shape.faces, dtype=np.int64)


def directions(count: int = 400) -> np.ndarray:
    vectors = np.random.default_rng(0).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def saved(shape: trimesh.Trimesh, file: Path) -> str:
    shape.export(str(file))
    return str(file)


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply"])
def test_ball_from_a_file_is_a_sphere(tmp_path: Path, suffix: str) -> None:
    file = saved(trimesh.Trimesh(*ball(), process=False), tmp_path / f"ball.{suffix}")
    body = mesh(file=file, scale=2.0, grid_spacing=2.0)
    n = directions()
    for height in (-2.0, 0.0, 2.0):
        found = body.distance((30.0 + height) * n)
        curvature = (np.eye(3) - n[:, :, None] * n[:, None, :]) / (30.0 + height)
        assert np.abs(found.gap - height).max() < 2e-3
        assert np.abs(found.normal - n).max() < 2e-3
        assert np.abs(found.hessian - curvature).max() < 0.05 / 30.0
    assert body.notes == ()
    assert body.worst_deviation < 1e-3


def test_facets_are_not_felt() -> None:
    vertices, faces = ball(subdivisions=2)  # flat facets sink 0.29 mm below the sphere
    flat = 15.0 - np.linalg.norm(vertices[faces].mean(axis=1), axis=1).min()
    gap = mesh_body(vertices, faces, grid_spacing=1.0).distance(15.0 * directions()).gap
    assert flat > 0.2
    assert np.abs(gap).max() < 0.02 * flat


def test_error_falls_with_the_fourth_power_of_the_spacing() -> None:
    vertices, faces = ball(subdivisions=4)
    coarse, fine = (
        np.abs(mesh_body(vertices, faces, grid_spacing=h).distance(15.0 * directions()).gap).max() for h in (4.8, 2.4)
    )
    assert coarse / fine > 8.0
    assert coarse < 0.1


def test_sharp_edges_stay_and_flat_faces_are_flat() -> None:
    vertices, faces = box()
    fine = refined(vertices, faces, tolerance=1e-3)
    assert len(fine.faces) == 12
    body = mesh_body(vertices, faces)
    rng = np.random.default_rng(2)
    points = rng.uniform(-1, 1, (300, 3)) * [14.0, 9.0, 0.0]
    for height in (-1.0, 0.0, 1.0):
        found = body.distance(points + np.array([0.0, 0.0, 10.0 + height]))
        np.testing.assert_allclose(found.gap, height, atol=2e-3)
        np.testing.assert_allclose(found.normal, np.tile([0.0, 0.0, 1.0], (300, 1)), atol=4e-3)
    assert 0.01 < body.worst_deviation < 0.5  # the corners are rounded, and it is said


def test_refined_ball_stays_closed_and_on_the_sphere() -> None:
    vertices, faces = ball(subdivisions=2)
    fine = refined(vertices, faces, tolerance=2e-3)
    shape = trimesh.Trimesh(fine.vertices, fine.faces, process=False)
    assert shape.is_watertight
    assert shape.is_winding_consistent
    assert np.array_equal(fine.vertices[: len(vertices)], vertices)
    assert np.abs(np.linalg.norm(fine.vertices, axis=1) - 15.0).max() < 6e-3
    assert np.abs(np.linalg.norm(fine.vertices[fine.faces].mean(axis=1), axis=1) - 15.0).max() < 8e-3


def test_a_torn_ball_is_not_split_for_ever() -> None:
    vertices, faces = ball(subdivisions=1, radius=5.0)
    fine = refined(vertices + np.random.default_rng(3).normal(0.0, 3.0, vertices.shape), faces, tolerance=4e-3)
    assert len(faces) < len(fine.faces) < 100 * len(faces)
    assert trimesh.Trimesh(fine.vertices, fine.faces, process=False).is_watertight


def test_rim_of_a_cylinder_splits_the_normals_of_cap_and_side() -> None:
    shape = trimesh.creation.cylinder(20.0, 50.0, sections=32)
    normals = corner_normals(np.array(shape.vertices), np.array(shape.faces, dtype=np.int64))
    upright = np.abs(shape.face_normals[:, 2]) > 0.5
    np.testing.assert_allclose(np.abs(normals[upright][..., 2]), 1.0, atol=1e-12)
    np.testing.assert_allclose(normals[~upright][..., 2], 0.0, atol=1e-12)


def test_sign_is_right_in_the_hole_and_in_the_ring_of_a_torus() -> None:
    shape = trimesh.creation.torus(30.0, 10.0)
    body = mesh_body(np.array(shape.vertices), np.array(shape.faces, dtype=np.int64))
    angle = np.linspace(0, 2 * np.pi, 50)
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(50)], axis=1)
    for radius, gap in ((0.0, 20.0), (19.0, 1.0), (21.0, -1.0), (39.0, -1.0), (40.5, 0.5)):
        assert np.abs(body.distance(radius * ring).gap - gap).max() < (0.5 if radius == 0.0 else 0.03)


def test_distances_at_grid_nodes_are_those_to_the_triangles() -> None:
    vertices, faces = box()
    baked = grid.bake(vertices, faces, 1.7)
    rng = np.random.default_rng(4)
    shape = np.array(baked.coefficients.shape)
    nodes = baked.origin + 1.7 * rng.integers(grid.RIM, shape - grid.RIM, (2000, 3))
    beyond = np.abs(nodes) - [20.0, 15.0, 10.0]
    exact = np.linalg.norm(np.maximum(beyond, 0), axis=1) + np.minimum(beyond.max(axis=1), 0)
    assert np.abs(baked.distance(nodes).gap - exact).max() < 1e-6


def test_same_mesh_is_baked_once_and_read_again(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    vertices, faces = ball()
    first = mesh_body(vertices, faces, grid_spacing=2.0)
    assert len(list(cache.glob("distance-*.npz"))) == 1
    assert not list(cache.glob("**/.*.part*"))
    grid._baked.cache_clear()

    def refuse(*_: Any) -> None:
        raise AssertionError("baked again")

    monkeypatch.setattr(grid, "bake", refuse)
    second = mesh_body(vertices.copy(), faces.copy(), grid_spacing=2.0)
    assert np.array_equal(first.grid.coefficients, second.grid.coefficients)
    with pytest.raises(AssertionError, match="baked again"):
        mesh_body(vertices, faces, grid_spacing=2.1)


def test_baking_gives_the_same_numbers_every_time() -> None:
    vertices, faces = ball()
    assert np.array_equal(grid.bake(vertices, faces, 1.9).coefficients, grid.bake(vertices, faces, 1.9).coefficients)


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 torn", b"\x93NUMPY"])
def test_damaged_grid_on_disk_is_baked_again(cache: Path, content: bytes) -> None:
    vertices, faces = ball()
    first = mesh_body(vertices, faces, grid_spacing=2.0)
    next(cache.glob("*.npz")).write_bytes(content)
    grid._baked.cache_clear()
    second = mesh_body(vertices, faces, grid_spacing=2.0)
    assert np.array_equal(first.grid.coefficients, second.grid.coefficients)


def test_cache_that_cannot_be_written_does_no_harm(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("not a folder")
    monkeypatch.setenv("ETEXTILE_CACHE_DIR", str(tmp_path / "file" / "grids"))
    assert mesh_body(*ball(), grid_spacing=2.0).worst_deviation < 0.01


def refusal(*arguments: Any, **keywords: Any) -> str:
    with pytest.raises(BadInput) as caught:
        mesh(*arguments, **keywords)
    return str(caught.value)


def test_missing_and_foreign_files_are_refused(tmp_path: Path) -> None:
    assert "no such mesh file" in refusal(file=tmp_path / "none.stl")
    (tmp_path / "body.step").write_text("ISO-10303-21;")
    assert "'.step' is not known, use one of .stl, .obj, .ply" in refusal(file=tmp_path / "body.step")


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply"])
@pytest.mark.parametrize("content", [b"", b"no mesh at all\n", bytes(range(256)) * 3])
def test_unreadable_and_empty_files_are_refused(tmp_path: Path, suffix: str, content: bytes) -> None:
    file = tmp_path / f"broken.{suffix}"
    file.write_bytes(content)
    said = refusal(file=file)
    assert said.startswith(str(file))
    assert "cannot be read" in said or "no triangles" in said


def test_open_mesh_is_refused_with_the_number_of_open_edges(tmp_path: Path) -> None:
    vertices, faces = ball()
    file = saved(trimesh.Trimesh(vertices, faces[1:], process=False), tmp_path / "open.stl")
    assert "not watertight: 3 open edges" in refusal(file=file)


def test_mesh_with_an_inner_wall_is_refused(tmp_path: Path) -> None:
    vertices, faces = box()
    wall = np.concatenate([faces, faces[:1]])
    file = saved(trimesh.Trimesh(vertices, wall, process=False), tmp_path / "wall.ply")
    assert "3 edges of more than two triangles" in refusal(file=file)


def test_two_bodies_in_one_file_are_refused(tmp_path: Path) -> None:
    one, two = trimesh.creation.box((20, 20, 20)), trimesh.creation.box((20, 20, 20))
    two.apply_translation((50, 0, 0))
    file = saved(trimesh.util.concatenate([one, two]), tmp_path / "two.stl")
    assert "2 separate closed surfaces" in refusal(file=file)


@pytest.mark.parametrize(
    ("size", "scale", "advice"),
    [
        (0.24, 1.0, "in metres: set scale to 1000"),
        (240.0, 100.0, "is 24000 mm long with scale 100"),
        (240.0, 0.01, "in millimetres: set scale to 1"),
        (240000.0, 1.0, "in micrometres: set scale to 0.001"),
        (3.0, 1.0, "in inches: set scale to 25.4"),
    ],
)
def test_doubtful_size_is_refused_with_the_scale_to_set(tmp_path: Path, size: float, scale: float, advice: str) -> None:
    file = saved(trimesh.creation.box((size, size / 2, size / 2)), tmp_path / "size.ply")
    said = refusal(file=file, scale=scale)
    assert "expected 5 to 2000 mm" in said
    assert advice in said


def test_mesh_inside_out_is_turned_and_noted() -> None:
    vertices, faces = ball()
    _, turned, notes = checked(vertices, faces[:, ::-1], name="ball")
    assert "inside out" in notes[0]
    assert trimesh.Trimesh(vertices, turned, process=False).volume > 0


def test_triangles_wound_at_random_are_turned_and_counted() -> None:
    vertices, faces = ball()
    flip = np.random.default_rng(1).random(len(faces)) < 0.3
    _, turned, notes = checked(vertices, np.where(flip[:, None], faces[:, ::-1], faces), name="ball")
    repaired = trimesh.Trimesh(vertices, turned, process=False)
    assert repaired.is_winding_consistent
    assert repaired.volume == pytest.approx(trimesh.Trimesh(vertices, faces, process=False).volume)
    assert notes == (f"{flip.sum()} of {len(faces)} triangles pointed inward and were turned outward",)


def test_notes_of_a_repair_reach_the_body(tmp_path: Path) -> None:
    vertices, faces = ball()
    file = saved(trimesh.Trimesh(vertices, faces[:, ::-1], process=False), tmp_path / "inverted.stl")
    body = mesh(file=file, grid_spacing=2.0)
    assert "inside out" in body.notes[0]
    assert body.distance(np.array([[0.0, 0.0, 16.0]])).gap[0] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize(
    ("spacing", "words"), [(0.0, "positive length"), (9.0, "too coarse"), (0.02, "20 million nodes")]
)
def test_grid_spacing_that_does_not_fit_is_refused(spacing: float, words: str) -> None:
    with pytest.raises(BadInput, match=words) as caught:
        mesh_body(*ball(), grid_spacing=spacing)
    assert caught.value.problems[0].key == "body.grid_spacing"


def test_scale_must_be_positive(tmp_path: Path) -> None:
    file = saved(trimesh.creation.box((20, 20, 20)), tmp_path / "box.stl")
    assert "body.scale: must be a positive factor (got -1)" in refusal(file=file, scale=-1.0)


def test_gap_is_continuous_where_the_grid_ends() -> None:
    body: MeshBody = mesh_body(*ball(), grid_spacing=1.0)
    edge = body.grid.origin[2] + body.grid.spacing * (body.grid.coefficients.shape[2] - 1 - grid.RIM)
    side = np.random.default_rng(3).uniform(-10, 10, (50, 2))
    inner, outer = (np.column_stack([side, np.full(50, edge + shift)]) for shift in (-1e-9, 1e-9))
    assert np.abs(body.distance(inner).gap - body.distance(outer).gap).max() < 1e-8
