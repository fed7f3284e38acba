"""What every registered body must fulfil: a body that passes here can be pressed into a fabric."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from etextile import foreign_code
from etextile.contact.bodies import BODIES
from etextile.contact.body import Body
from etextile.contact.capsule import Capsule
from etextile.contact.mesh import MeshBody
from etextile.contact.pose import PlacedBody, place
from loadcases.schema_body import BODIES as SCHEMAS
from loadcases.schema_body import Placed


EXAMPLES: dict[str, dict[str, Any]] = {
    "sphere": {"radius": 15.0},
    "ellipsoid": {"semi_axes": (30.0, 20.0, 12.0)},
    "capsule": {"radius": 12.0, "length": 40.0},
    "mesh": {"file": "egg.ply"},
    "elbow": {},
    "knee": {},
    "own": {"file": "own.py", "shape": "lens", "dimensions": {"radius": 25.0}},
}
OWN = """
import numpy as np
import etextile as et


def lens(*, radius):
    def gap(points):
        return np.linalg.norm(points / [1.0, 0.8, 0.7], axis=1) * 0.8 - 0.8 * radius

    return et.implicit_body(gap, low=[-1.2 * radius] * 3, high=[1.2 * radius] * 3, edge=radius / 12)
"""
SEEDS = st.integers(0, 2**32 - 1)


@pytest.fixture(autouse=True, scope="module")
def code_may_run() -> Iterator[None]:
    with foreign_code.trusting():
        yield


@pytest.fixture(scope="module", params=sorted(EXAMPLES))
def body(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Body]:
    """Each registered body with example dimensions; grids are kept in a temporary folder."""
    folder = tmp_path_factory.mktemp("bodies")
    dimensions = dict(EXAMPLES[request.param])
    if "shape" in dimensions:
        dimensions["file"] = str(folder / dimensions["file"])
        Path(dimensions["file"]).write_text(OWN)
    elif "file" in dimensions:
        dimensions["file"] = str(folder / dimensions["file"])
        egg = trimesh.creation.icosphere(subdivisions=4, radius=20.0)
        egg.vertices *= np.stack([np.ones(len(egg.vertices)), 0.7 + 0.005 * egg.vertices[:, 0], np.ones(2562)], axis=1)
        egg.export(dimensions["file"])
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ETEXTILE_CACHE_DIR", str(folder))
        yield BODIES[request.param](**dimensions)


def is_exact(body: Body) -> bool:
    return not isinstance(body, MeshBody)


def near_surface(body: Body, seed: int, reach: float = 1.5, count: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Return points up to `reach` mm off the surface and their offsets along the facet normals."""
    rng = np.random.default_rng(seed)
    vertices, faces = body.surface()
    corners = vertices[faces[rng.integers(len(faces), size=count)]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    offset = rng.uniform(-reach, reach, count)
    on_surface = np.einsum("ij,ijk->ik", rng.dirichlet(np.ones(3), count), corners)
    points = on_surface + offset[:, None] * normal
    if isinstance(body, Capsule):  # its Hessian jumps at the seams
        points[:, 0] += 0.01 * (np.abs(np.abs(points[:, 0]) - 0.5 * body.length) < 0.005)
    return points, offset


def anywhere(body: Body, seed: int, count: int = 60) -> np.ndarray:
    """Return points in a box three times as large as the body's."""
    low, high = body.bounds()
    return np.random.default_rng(seed).uniform(2 * low - high, 2 * high - low, (count, 3))


def differences(function: Any, points: np.ndarray, step: float = 1e-4) -> np.ndarray:
    """Return central differences of `function` along x, y, z in a new last axis."""
    columns = [(function(points + shift) - function(points - shift)) / (2 * step) for shift in step * np.eye(3)]
    return np.stack(columns, axis=-1)


def test_every_registered_body_is_tested() -> None:
    assert set(EXAMPLES) == set(BODIES)


@pytest.mark.parametrize("schema", SCHEMAS, ids=lambda schema: schema.__name__)
def test_case_file_offers_the_builder_keywords_and_defaults(schema: Any) -> None:
    name = schema.__name__.lower()
    offered = {key: field.default for key, field in schema.model_fields.items() if not field.is_required()}
    keywords = inspect.signature(BODIES[name]).parameters
    assert set(keywords) == set(schema.model_fields) - {"type", *Placed.model_fields}
    for key, parameter in keywords.items():
        assert parameter.default == offered.get(key, inspect.Parameter.empty), key


@settings(max_examples=15)
@given(seed=SEEDS)
def test_gap_changes_no_faster_than_the_point_moves(body: Body, seed: int) -> None:
    points = np.concatenate([anywhere(body, seed), near_surface(body, seed)[0]])
    gap = body.distance(points).gap
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    slack = 1e-12 if is_exact(body) else 0.03
    assert np.all(np.abs(gap[:, None] - gap[None]) <= (1 + slack) * apart + 1e-9)


@settings(max_examples=15)
@given(seed=SEEDS)
def test_sign_and_size_of_the_gap_near_the_surface(body: Body, seed: int) -> None:
    points, offset = near_surface(body, seed)
    gap = body.distance(points).gap
    flat = 0.15 if is_exact(body) else 0.45  # facets are this far off the true surface at most
    assert np.all(gap[offset > flat] > 0)
    assert np.all(gap[offset < -flat] < 0)
    assert np.all(np.abs(gap - offset) < flat)


@settings(max_examples=15)
@given(seed=SEEDS)
def test_normal_is_a_unit_vector_and_the_gradient_of_the_gap(body: Body, seed: int) -> None:
    points = near_surface(body, seed)[0]
    length = np.linalg.norm(body.distance(points).normal, axis=1)
    assert np.abs(length - 1).max() < (1e-12 if is_exact(body) else 0.03)
    points = np.concatenate([points, anywhere(body, seed)])
    gradient = differences(lambda x: body.distance(x).gap, points)
    # Differences across an edge of the grid's box or the medial axis mean nothing: a few points may hit one.
    off = np.abs(gradient - body.distance(points).normal).max(axis=1)
    assert np.mean(off > 1e-5) <= 0.02


@settings(max_examples=15)
@given(seed=SEEDS)
def test_hessian_is_symmetric_and_the_gradient_of_the_normal(body: Body, seed: int) -> None:
    points = near_surface(body, seed)[0]
    hessian = body.distance(points).hessian
    assert np.abs(hessian - hessian.transpose(0, 2, 1)).max() < 1e-12
    assert np.abs(hessian - differences(lambda x: body.distance(x).normal, points)).max() < 1e-4
    far = body.distance(anywhere(body, seed)).hessian
    assert np.isfinite(far).all()


@settings(max_examples=15)
@given(seed=SEEDS)
def test_far_gap_is_a_positive_lower_bound(body: Body, seed: int) -> None:
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(40, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    low, high = body.bounds()
    points = 0.5 * (low + high) + directions * rng.uniform(1.0, 20.0, (40, 1)) * np.linalg.norm(high - low)
    gap = body.distance(points).gap
    vertices = body.surface()[0]
    nearest = np.linalg.norm(points[:, None] - vertices[None], axis=2).min(axis=1)
    assert np.all(gap > 0)
    assert np.all(gap <= nearest + 1e-9)


@settings(max_examples=15)
@given(seed=SEEDS)
def test_support_is_the_furthest_point_of_the_surface(body: Body, seed: int) -> None:
    direction = np.random.default_rng(seed).normal(size=3)
    direction /= np.linalg.norm(direction)
    furthest = (body.surface()[0] @ direction).max()
    assert -0.05 < body.support(direction) - furthest < 0.2
    assert body.support(3.0 * direction) == pytest.approx(3.0 * body.support(direction), abs=1e-6)


def test_surface_is_closed_outward_and_well_shaped(body: Body) -> None:
    vertices, faces = body.surface()
    surface = trimesh.Trimesh(vertices, faces, process=False)
    assert surface.is_watertight
    assert surface.is_winding_consistent
    assert surface.volume > 0
    assert 1000 < len(faces) < 30000
    assert np.degrees(surface.face_angles.min()) > 15.0
    low, high = body.bounds()
    assert np.all(vertices >= low - 1e-9)
    assert np.all(vertices <= high + 1e-9)


@settings(max_examples=15)
@given(angles=st.tuples(*[st.floats(-180, 180)] * 3))
def test_placed_body_just_touches_the_flat_fabric(body: Body, angles: tuple[float, float, float]) -> None:
    placed = place(body, (3.0, -4.0), rotation_deg=angles)
    vertices = placed.surface()[0]
    top = vertices[np.argmax(vertices[:, 2])]
    side = np.linspace(-4.0, 4.0, 81)
    flat = np.stack(np.meshgrid(top[0] + side, top[1] + side, [0.0], indexing="ij"), axis=-1).reshape(-1, 3)
    assert placed.distance(flat).gap.min() > -1e-6
    assert placed.moved(np.array([0.0, 0.0, 0.05])).distance(flat).gap.min() < 0.0


@settings(max_examples=15)
@given(seed=SEEDS, angles=st.tuples(*[st.floats(-180, 180)] * 3))
def test_distance_does_not_depend_on_the_frame(body: Body, seed: int, angles: tuple[float, float, float]) -> None:
    points = near_surface(body, seed)[0]
    placed = place(body, (5.0, 6.0), rotation_deg=angles)
    turn, shift = placed.rotation, placed.translation
    own, world = body.distance(points), placed.distance(points @ turn.T + shift)
    np.testing.assert_allclose(world.gap, own.gap, atol=1e-9)
    np.testing.assert_allclose(world.normal, own.normal @ turn.T, atol=1e-9)
    np.testing.assert_allclose(world.hessian, turn @ own.hessian @ turn.T, atol=1e-8)
    assert isinstance(placed, PlacedBody)


def test_points_of_the_wrong_shape_are_refused(body: Body) -> None:
    with pytest.raises(ValueError, match=r"\(n, 3\)"):
        body.distance(np.zeros(3))


def test_no_points_give_no_distances(body: Body) -> None:
    found = body.distance(np.zeros((0, 3)))
    assert (found.gap.shape, found.normal.shape, found.hessian.shape) == ((0,), (0, 3), (0, 3, 3))


def test_cache_folder_is_the_one_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from etextile.contact.grid import cache_folder

    monkeypatch.setenv("ETEXTILE_CACHE_DIR", str(tmp_path))
    assert cache_folder() == tmp_path
