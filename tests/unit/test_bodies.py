"""Exact bodies, their placing, implicit shapes and the anatomical bodies against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from etextile.contact.bodies import BODIES
from etextile.contact.body import Body
from etextile.contact.capsule import capsule
from etextile.contact.elbow import elbow, elbow_mesh, elbow_shape
from etextile.contact.ellipsoid import ellipsoid
from etextile.contact.implicit import (
    capped_cone,
    grown_ellipsoid,
    implicit_mesh,
    smooth_union,
    surface_nets,
    unambiguous,
)
from etextile.contact.knee import knee, knee_mesh, knee_shape
from etextile.contact.pose import place, rotation_matrix
from etextile.contact.sphere import sphere
from etextile.errors import BadInput


AXES = st.floats(0.5, 100.0)


@pytest.fixture(autouse=True)
def _own_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ETEXTILE_CACHE_DIR", str(tmp_path_factory.getbasetemp() / "grids"))


def directions(seed: int, count: int = 50) -> np.ndarray:
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def test_sphere_has_the_gap_and_curvature_of_its_offset_surfaces() -> None:
    n = directions(1)
    for height in (-10.0, -0.02, 0.0, 25.0):
        found = sphere(radius=15.0).distance((15.0 + height) * n)
        np.testing.assert_allclose(found.gap, height, atol=1e-13)
        np.testing.assert_allclose(found.normal, n, atol=1e-14)
        expected = (np.eye(3) - n[:, :, None] * n[:, None, :]) / (15.0 + height)
        np.testing.assert_allclose(found.hessian, expected, atol=1e-13)


@pytest.mark.parametrize("body", [sphere(radius=15.0), capsule(radius=15.0, length=20.0)], ids=["sphere", "capsule"])
def test_centre_and_axis_give_finite_answers(body: Body) -> None:
    found = body.distance(np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]]))
    assert found.gap[0] == -15.0
    assert all(np.isfinite(part).all() for part in (found.gap, found.normal, found.hessian))
    np.testing.assert_allclose(np.linalg.norm(found.normal, axis=1), 1.0)


def test_capsule_is_a_cylinder_between_two_half_spheres() -> None:
    body = capsule(radius=10.0, length=40.0)
    points = np.array([[5.0, 0.0, 13.0], [32.0, 0.0, 0.0], [-20.0 - 3.0, 0.0, 4.0]])
    found = body.distance(points)
    np.testing.assert_allclose(found.gap, [3.0, 2.0, -5.0], atol=1e-13)
    np.testing.assert_allclose(found.normal, [[0, 0, 1], [1, 0, 0], [-0.6, 0, 0.8]], atol=1e-14)
    np.testing.assert_allclose(found.hessian[0], np.diag([0, 1 / 13, 0]), atol=1e-14)
    np.testing.assert_allclose(found.hessian[1], np.diag([0, 1 / 12, 1 / 12]), atol=1e-14)
    assert body.support(np.array([1.0, 0.0, 0.0])) == 30.0


@given(axes=st.tuples(AXES, AXES, AXES), seed=st.integers(0, 10**6), share=st.floats(-0.95, 3.0))
def test_ellipsoid_knows_points_put_off_its_surface(axes: tuple[float, float, float], seed: int, share: float) -> None:
    semi = np.array(axes)
    surface = semi * directions(seed)
    normal = surface / semi**2
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    focal = semi.min() ** 2 / semi.max()  # no centre of curvature is nearer to the surface
    found = ellipsoid(semi_axes=axes).distance(surface + share * focal * normal)
    np.testing.assert_allclose(found.gap, share * focal, atol=1e-9 * semi.max())
    np.testing.assert_allclose(found.normal, normal, atol=1e-6)


def test_ellipsoid_with_equal_axes_is_a_sphere() -> None:
    points = np.random.default_rng(3).uniform(-20, 20, (100, 3))
    one, two = ellipsoid(semi_axes=(9.0, 9.0, 9.0)).distance(points), sphere(radius=9.0).distance(points)
    np.testing.assert_allclose(one.gap, two.gap, atol=1e-12)
    np.testing.assert_allclose(one.normal, two.normal, atol=1e-12)
    np.testing.assert_allclose(one.hessian, two.hessian, atol=1e-11)


def test_ellipsoid_has_its_principal_curvatures_at_the_tip() -> None:
    found = ellipsoid(semi_axes=(30.0, 20.0, 12.0)).distance(np.array([[0.0, 0.0, 12.0], [0.0, 0.0, 14.0]]))
    np.testing.assert_allclose(found.gap, [0.0, 2.0], atol=1e-13)
    for height, hessian in zip((0.0, 2.0), found.hessian, strict=True):
        radii = np.array([30.0**2 / 12.0, 20.0**2 / 12.0]) + height
        np.testing.assert_allclose(hessian, np.diag([1 / radii[0], 1 / radii[1], 0.0]), atol=1e-14)


@pytest.mark.parametrize(
    ("axes", "point", "gap"),
    [
        ((3.0, 2.0, 1.0), (0.0, 0.0, 0.0), -1.0),
        ((3.0, 2.0, 1.0), (0.0, 0.0, 0.5), -0.5),
        ((3.0, 2.0, 1.0), (2.9, 0.0, 0.0), -0.1),
        ((3.0, 2.0, 1.0), (1.0, 0.0, 0.0), -np.sqrt(1 - 1 / 8)),  # on the focal disc: the foot is off the plane
        ((1.0, 1.0, 3.0), (0.0, 0.0, 1.0), -np.sqrt(1 - 1 / 8)),
        ((2.0, 2.0, 2.0), (0.0, 0.0, 0.0), -2.0),
        ((3.0, 2.0, 1.0), (0.0, -5.0, 0.0), 3.0),
    ],
)
def test_ellipsoid_at_points_where_the_foot_is_not_unique_or_degenerate(
    axes: tuple[float, float, float], point: tuple[float, float, float], gap: float
) -> None:
    found = ellipsoid(semi_axes=axes).distance(np.array([point]))
    assert found.gap[0] == pytest.approx(gap, abs=1e-9)
    assert np.isfinite(found.hessian).all()


@pytest.mark.parametrize(
    ("name", "dimensions", "key", "words"),
    [
        ("sphere", {"radius": -3.0}, "body.radius", "positive length (got -3)"),
        ("sphere", {"radius": np.nan}, "body.radius", "got nan"),
        ("capsule", {"radius": 0.0, "length": 5.0}, "body.radius", "got 0"),
        ("ellipsoid", {"semi_axes": (1.0, 2.0)}, "body.semi_axes", "three lengths"),
        ("ellipsoid", {"semi_axes": (1.0, 2.0, -3.0)}, "body.semi_axes", "got [1, 2, -3]"),
        ("ellipsoid", {"semi_axes": (1.0, 2.0, 3000.0)}, "body.semi_axes", "factor of 1000"),
        ("elbow", {"flexion": 20.0}, "body.flexion", "between 60 and 150 deg (got 20)"),
        ("elbow", {"tip_radius": 40.0}, "body.tip_radius", "got 40"),
        ("knee", {"flexion": 180.0}, "body.flexion", "between 60 and 140 deg (got 180)"),
        ("knee", {"patella_height": 10.0}, "body.patella_height", "got 10"),
    ],
)
def test_impossible_dimensions_are_refused_at_their_key(
    name: str, dimensions: dict[str, Any], key: str, words: str
) -> None:
    with pytest.raises(BadInput) as caught:
        BODIES[name](**dimensions)
    assert caught.value.problems[0].key == key
    assert words in caught.value.problems[0].message


def test_all_impossible_dimensions_are_named_at_once() -> None:
    with pytest.raises(BadInput) as caught:
        capsule(radius=-1.0, length=-2.0)
    assert [problem.key for problem in caught.value.problems] == ["body.radius", "body.length"]


def test_unknown_body_is_answered_with_the_nearest_name() -> None:
    with pytest.raises(BadInput, match="did you mean 'elbow'"):
        BODIES["ellbow"]


def test_quarter_turns_are_exact_and_applied_about_fixed_axes() -> None:
    x, y, z = np.eye(3)
    assert np.array_equal(rotation_matrix((0, 0, 90)) @ x, y)
    assert np.array_equal(rotation_matrix((90, 0, 90)) @ y, z)  # first about x, y to z; z then stays
    assert np.array_equal(rotation_matrix((0, -270, 0)) @ z, x)
    np.testing.assert_allclose(rotation_matrix((30, 0, 0)) @ y, [0, np.sqrt(0.75), 0.5], atol=1e-15)


def test_capsule_stood_on_end_touches_with_its_cap() -> None:
    placed = place(capsule(radius=10.0, length=40.0), (1.0, 2.0), rotation_deg=(0.0, 90.0, 0.0))
    np.testing.assert_allclose(placed.bounds(), [[-9, -8, -60], [11, 12, 0]], atol=1e-12)
    found = placed.distance(np.array([[1.0, 2.0, 0.5], [1.0, 15.0, -30.0]]))
    np.testing.assert_allclose(found.gap, [0.5, 3.0], atol=1e-12)
    np.testing.assert_allclose(found.normal, [[0, 0, 1], [0, 1, 0]], atol=1e-12)
    assert placed.moved(np.array([0.0, 0.0, 7.0])).support(np.array([0.0, 0.0, 1.0])) == pytest.approx(7.0)


def test_capped_cone_is_the_hull_of_its_two_balls() -> None:
    start, end = np.array([0.0, 0.0, 0.0]), np.array([10.0, 0.0, 0.0])
    cone = capped_cone(start, end, 3.0, 1.0)
    points = np.random.default_rng(5).uniform(-15, 25, (200, 3))
    t = np.linspace(0, 1, 20001)[:, None]
    centres, radii = start + t * (end - start), 3.0 - 2.0 * t[:, 0]
    brute = np.array([(np.linalg.norm(centres - point, axis=1) - radii).min() for point in points])
    np.testing.assert_allclose(cone(points), brute, atol=1e-6)


def test_smooth_union_is_exact_away_from_the_seam_and_smooth_in_it() -> None:
    left = capped_cone(np.array([-9.0, 0, 0]), np.array([0.0, 0, 0]), 4.0, 4.0)
    right = capped_cone(np.array([0.0, 0, 9.0]), np.array([0.0, 0, 0]), 4.0, 4.0)
    both = smooth_union([left, right], 2.0)
    points = np.random.default_rng(6).uniform(-12, 12, (500, 3))
    a, b, union = left(points), right(points), both(points)
    apart = np.abs(a - b) >= 2.0
    assert np.array_equal(union[apart], np.minimum(a, b)[apart])
    assert np.all(union <= np.minimum(a, b))
    assert np.all(union >= np.minimum(a, b) - 2.0 / 6.0 - 1e-12)
    line = np.stack([np.linspace(-6, 6, 4001), np.full(4001, 4.2), np.ones(4001)], axis=1)
    kinked, smooth = (np.gradient(part, line[:, 0]) for part in (np.minimum(left(line), right(line)), both(line)))
    assert np.abs(np.diff(kinked)).max() > 0.05
    assert np.abs(np.diff(smooth)).max() < 0.005


def test_implicit_mesh_lies_on_the_zero_level() -> None:
    shape = grown_ellipsoid(np.zeros(3), (20.0, 14.0, 9.0), 3.0)
    vertices, faces = implicit_mesh(shape, np.array([[-23.0, -17, -12], [23, 17, 12]]), edge=2.5)
    assert np.abs(shape(vertices)).max() < 1e-6
    edges = vertices[faces] - vertices[np.roll(faces, 1, axis=1)]
    length = np.linalg.norm(edges, axis=2)
    assert 2.0 < length.mean() < 2.8
    assert length.max() < 2.0 * length.mean()
    volume = np.einsum("ij,ij->", vertices[faces[:, 0]], np.cross(vertices[faces[:, 1]], vertices[faces[:, 2]])) / 6
    assert volume == pytest.approx(4 / 3 * np.pi * 23 * 17 * 12, rel=0.05)


@given(seed=st.integers(0, 10**6))
def test_surface_nets_close_even_around_noise(seed: int) -> None:
    values = np.pad(np.random.default_rng(seed).normal(size=(5, 5, 5)), 2, constant_values=1.0)
    _, quads = surface_nets(unambiguous(values))
    edges = np.sort(np.concatenate([quads[:, [i, (i + 1) % 4]] for i in range(4)]), axis=1)
    uses = np.unique(edges, axis=0, return_counts=True)[1]
    assert len(uses) == 0 or np.all(uses == 2)


def test_elbow_has_the_tip_the_breadth_and_the_flexion_it_was_asked_for() -> None:
    body = elbow(tip_radius=15.0, flexion=100.0)
    tip = body.distance(np.array([[0.0, 0.0, body.support(np.array([0.0, 0.0, 1.0]))]]))
    np.testing.assert_allclose(tip.normal[0], [0, 0, 1], atol=2e-3)
    np.testing.assert_allclose(np.linalg.eigvalsh(tip.hessian[0]), [0, 1 / 15, 1 / 15], atol=0.03 / 15)
    vertices = body.surface()[0]
    joint = np.abs(vertices[:, 2] + 45.0) < 10.0
    assert 72.0 < np.ptp(vertices[joint, 1]) < 78.0  # bone and some 2 mm of skin on each side
    arms = vertices - np.array([0.0, 0.0, -45.0])
    reach = np.linalg.norm(arms, axis=1)
    upper, lower = (arms[np.argmax(np.where(side, reach, 0.0))] for side in (arms[:, 0] < 0, arms[:, 0] > 0))
    bend = upper @ lower / (np.linalg.norm(upper) * np.linalg.norm(lower))
    assert np.degrees(np.arccos(bend)) == pytest.approx(180.0 - 100.0, abs=2.0)


@pytest.mark.slow
def test_knee_carries_a_kneecap_of_the_asked_curvature() -> None:
    body = knee()
    top = body.distance(np.array([[0.0, 0.0, body.support(np.array([0.0, 0.0, 1.0]))]]))
    skin = 3.0
    along, across = 17.2**2 / 11.2 + skin, 22.4**2 / 11.2 + skin
    np.testing.assert_allclose(top.normal[0], [0, 0, 1], atol=5e-3)
    np.testing.assert_allclose(np.diag(top.hessian[0]), [1 / along, 1 / across, 0], rtol=0.15, atol=1e-3)
    vertices = body.surface()[0]
    joint = np.abs(vertices[:, 2] + 53.0) < 10.0
    assert 98.0 < np.ptp(vertices[joint, 1]) < 104.0


@pytest.mark.parametrize(
    ("body", "shape"),
    [
        (elbow, elbow_shape(15.0, 100.0, 72.0, 344.0, 282.0, 140.0)),
        (knee, knee_shape(90.0, 98.0, 480.0, 372.0, (34.4, 44.8, 22.4), 180.0)),
    ],
)
def test_anatomical_bodies_follow_their_shape_within_a_twentieth_of_a_millimetre(body: Any, shape: Any) -> None:
    made = body()
    assert made.worst_deviation < 0.05
    vertices, faces = made.surface()
    points = vertices[faces].mean(axis=1)  # on the facets, drawn onto the shape
    for _ in range(5):
        value, step = shape(points), 1e-4
        gradient = np.stack([shape(points + shift) - value for shift in step * np.eye(3)], axis=1) / step
        points = points - (value / np.sum(gradient**2, axis=1))[:, None] * gradient
    assert np.abs(made.distance(points).gap).max() < 0.05


@pytest.mark.parametrize("mesh", [elbow_mesh, knee_mesh])
def test_anatomical_meshes_are_shared_and_cannot_be_changed(mesh: Any) -> None:
    vertices, _ = mesh(flexion=95.0)
    assert mesh(flexion=95.0)[0] is vertices
    with pytest.raises(ValueError, match="read-only"):
        vertices[0, 0] = 1.0
