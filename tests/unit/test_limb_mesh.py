"""A skinned mesh as a limb: against formulas where the mesh is a cylinder, and what it says of files it cannot use."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.tube_rig import write_limb

from etextile.contact.contact import Contact
from etextile.contact.limb import Limb
from etextile.contact.limb_mesh import SkinnedLimb, limb_mesh
from etextile.contact.limb_recipe import LimbRecipe, unbaked
from etextile.contact.poses import PosedMesh
from etextile.contact.skinning import SkinnedMesh
from etextile.errors import BadInput
from etextile.motion.flexion import Flexion
from etextile.types import Array


RADIUS = 20.0
STEP = 1e-4


@pytest.fixture(scope="module")
def limb(tmp_path_factory: pytest.TempPathFactory) -> Iterator[SkinnedLimb]:
    """A cylinder of 20 mm that bends at its middle, by rotations that keep distances from the hinge."""
    folder = tmp_path_factory.mktemp("limb")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ETEXTILE_CACHE_DIR", str(folder))
        found = limb_mesh(
            **write_limb(folder, radius=RADIUS), joint="elbow_left", skinning="dual_quaternion", segment_length=75.0
        )
        yield replace(found, source=PosedMesh(found.skin, 4.5, tuple(np.radians(np.arange(0.0, 141.0, 10.0)).tolist())))


def analytic(degrees: float) -> Limb:
    return Limb(RADIUS, (RADIUS, 200.0), (RADIUS, 200.0), flexion=np.radians(degrees))


def beside(degrees: float, *, off: float) -> Array:
    """Places `off` mm from the skin of both segments, 30 to 50 mm from the hinge, away from the crook."""
    along, around = np.meshgrid(np.linspace(30.0, 50.0, 5), np.radians(np.linspace(-80.0, 80.0, 9)))
    along, around = along.ravel(), around.ravel()
    half = np.radians(0.5 * degrees)
    found = []
    for side in (-1.0, 1.0):
        x, y, z = side * along, (RADIUS + off) * np.sin(around), (RADIUS + off) * np.cos(around)
        cos, sin = np.cos(side * half), np.sin(side * half)
        found.append(np.stack([cos * x + sin * z, y, cos * z - sin * x], axis=1))
    return np.concatenate(found)


@pytest.mark.parametrize("degrees", [0.0, 37.0, 90.0])
@pytest.mark.parametrize("off", [-3.0, 0.0, 4.0])
def test_segments_of_a_skinned_cylinder_are_those_of_the_parametric_limb(
    limb: SkinnedLimb, degrees: float, off: float
) -> None:
    places = beside(degrees, off=off)
    posed, exact = limb.posed(flexion=np.radians(degrees), deflated=0.0), analytic(degrees)
    found, wanted = posed.distance(places), exact.distance(places)
    assert found.gap == pytest.approx(wanted.gap, abs=0.04)
    assert found.normal == pytest.approx(wanted.normal, abs=0.02)
    assert posed.rate(places) == pytest.approx(exact.rate(places), abs=0.01 * np.abs(places).max() * 0.5)


def test_gap_normal_and_rate_are_derivatives_of_one_function(limb: SkinnedLimb) -> None:
    places = np.random.default_rng(4).uniform(-55.0, 55.0, (300, 3)) * [1.0, 0.6, 0.6]
    posed = limb.posed(flexion=1.3, deflated=2.0)
    found = posed.distance(places)
    for axis in range(3):
        shift = STEP * np.eye(3)[axis]
        ahead, behind = posed.distance(places + shift), posed.distance(places - shift)
        assert found.normal[:, axis] == pytest.approx((ahead.gap - behind.gap) / (2 * STEP), abs=1e-6)
        assert found.hessian[:, axis] == pytest.approx((ahead.normal - behind.normal) / (2 * STEP), abs=1e-6)
    further, less = (limb.posed(flexion=1.3 + step, deflated=2.0) for step in (STEP, -STEP))
    rate = (further.distance(places).gap - less.distance(places).gap) / (2 * STEP)
    assert posed.rate(places) == pytest.approx(rate, abs=1e-5)
    assert found.gap == pytest.approx(limb.posed(flexion=1.3, deflated=0.0).distance(places).gap + 2.0)


def test_moment_on_a_skinned_limb_is_the_derivative_of_what_contact_stores(limb: SkinnedLimb) -> None:
    motion, travel = Flexion(limb, donning=3.0), 71.0
    x = beside(travel, off=-0.05)
    contact = Contact(np.arange(len(x))[:, None], np.ones(len(x)), limb, motion, 0.0, 0.02, 30.0)
    state = contact.initial_state()
    response = contact.respond(x, travel, state)
    ahead, behind = (contact.respond(x, travel + step, state).energy().contact for step in (STEP, -STEP))
    assert response.penetration > 0.01
    assert response.driving_force == pytest.approx((ahead - behind) / (2 * STEP), rel=1e-5)


def test_bent_far_the_crook_is_the_union_of_what_overlaps(limb: SkinnedLimb) -> None:
    """Between hinge and crook two segments overlap; but for a cell around the crease no sheet of the mesh is felt."""
    degrees = 130.0
    posed = limb.posed(flexion=np.radians(degrees), deflated=0.0)
    down = -np.linspace(0.0, RADIUS / np.cos(np.radians(0.5 * degrees)) - 17.0, 12)
    places = np.stack([np.zeros(12), np.zeros(12), down], axis=1)
    exact = analytic(degrees).distance(places).gap
    assert exact.max() < -10.0
    assert np.all(posed.distance(places).gap < 0.5 * exact), "a sheet within would be felt as gap 0, at 20 mm"


def test_linear_blend_skinning_draws_the_joint_in_and_dual_quaternions_do_not() -> None:
    half = np.array([[0.0, 5.0, 30.0]])
    for rest, flexion in ((0.0, 1.5), (0.4, 1.2)):
        linear, dual = (
            SkinnedMesh(half, np.zeros((0, 3), int), np.array([0.5]), rest, kind).bent(flexion)
            for kind in ("linear", "dual_quaternion")
        )
        assert linear[0] == pytest.approx([0.0, 5.0, 30.0 * np.cos(0.5 * (flexion - rest))])
        assert dual[0] == pytest.approx(half[0])


def test_vertices_of_one_bone_turn_with_it_whatever_the_skinning() -> None:
    for kind in ("linear", "dual_quaternion"):
        mesh = SkinnedMesh(np.array([[40.0, 0.0, 5.0]]), np.zeros((0, 3), int), np.ones(1), 0.2, kind)
        moved = mesh.bent(1.0)[0]
        assert np.arctan2(-moved[2], moved[0]) - np.arctan2(-5.0, 40.0) == pytest.approx(0.4)


def test_sections_are_those_of_the_cylinder(limb: SkinnedLimb) -> None:
    along = np.linspace(-60.0, 60.0, 13)
    assert limb.girth(along) == pytest.approx(2.0 * np.pi * RADIUS, rel=2e-3)
    assert limb.middle == pytest.approx([0.0, 0.0], abs=0.05)
    angle = np.linspace(0.0, 2.0 * np.pi, 9)[:-1]
    for radius, wanted in ((RADIUS - 3.0, RADIUS), (RADIUS + 3.0, RADIUS + 3.0)):
        places = np.stack([np.full(8, 20.0), radius * np.sin(angle), radius * np.cos(angle)], axis=1)
        fitted = limb.fitted(places)
        assert np.hypot(*fitted[:, 1:].T) == pytest.approx(wanted, rel=2e-3)
        assert fitted * [1.0, radius / wanted, radius / wanted] == pytest.approx(places, abs=0.05)


def test_rest_pose_and_fading_of_the_weights_are_found(limb: SkinnedLimb) -> None:
    assert limb.skin.rest == pytest.approx(0.5, abs=1e-9)
    assert limb.skin_length == pytest.approx(40.0, rel=0.02)


def test_a_girth_at_the_joint_scales_the_whole_limb(tmp_path: Path) -> None:
    files = write_limb(tmp_path)
    plain, wide = (unbaked(LimbRecipe(**files, joint="elbow_left", joint_girth=girth)) for girth in (None, 150.0))
    assert wide.girth == pytest.approx(150.0, rel=1e-6)
    assert wide.length == pytest.approx(plain.length * 150.0 / plain.girth)
    same = unbaked(LimbRecipe(**files, joint="elbow_left", joint_girth=plain.girth, segment_length=plain.length))
    assert np.array_equal(same.mesh.vertices, plain.mesh.vertices)


def changed(folder: Path, name: str, change: Any) -> None:
    data = json.loads((folder / name).read_text())
    change(data)
    (folder / name).write_text(json.dumps(data))


BAD: dict[str, tuple[dict[str, Any], Any, str]] = {
    "joint": ({"joint": "elbow_lft"}, None, "elbow_left.*forearm_l.*did you mean"),
    "group": ({"group": "skin"}, None, "no group 'skin', it has 'default'"),
    "scale": ({"scale": 0.01}, None, "expected 100 to 700 mm"),
    "metres": ({"scale": 1e-3, "group": None}, None, "seems to be in millimetres: set scale to 1"),
    "girth": ({"joint_girth": -3.0}, None, "positive length"),
    "length": ({"segment_length": 900.0}, None, "longer than its bone"),
    "axis along": ({"axis": (0.0, 0.0, 1.0)}, None, "across the limb"),
    "skinning": ({"skinning": "cubic"}, None, "linear, dual_quaternion"),
    "format": ({"file": "limb.stl"}, None, "OBJ"),
    "no file": ({"rig": "rigg.json"}, None, "no such file.*did you mean 'rig.json'"),
    "no JSON": ({"rig": "limb.obj"}, None, "cannot be read as JSON"),
    "no bones": ({}, ("rig.json", lambda rig: rig["bones"]["arm"].pop("tail")), "'arm' has no head and tail"),
    "point": ({}, ("rig.json", lambda rig: rig["bones"]["arm"].update(head=[1, 2])), r"write \[x, y, z\]"),
    "cube": (
        {}, ("rig.json", lambda rig: rig["bones"]["arm"].update(head={"strategy": "CUBE", "cube_name": "j"})),
        "group 'j', which the mesh does not have",
    ),
    "bone": ({}, ("weights.json", lambda weights: weights.update(hand=[[0, 1.0]])), "'hand', which the rig"),
    "count": ({}, ("weights.json", lambda weights: weights["arm"].append([99999, 1.0])), "weights of another mesh"),
    "pairs": ({}, ("weights.json", lambda weights: weights["arm"].append([1, -1.0])), "neither below 0"),
    "bare": ({}, ("weights.json", lambda weights: weights.update(arm=[])), "moved by no bone"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_files_that_cannot_be_used_are_refused_with_key_and_remedy(tmp_path: Path, name: str) -> None:
    keys, change, words = BAD[name]
    given = {**write_limb(tmp_path), "joint": "elbow_left"}
    given |= {key: str(tmp_path / value) if key in ("file", "rig") else value for key, value in keys.items()}
    if change is not None:
        changed(tmp_path, *change)
    with pytest.raises(BadInput, match=f"(?s){words}") as caught:
        unbaked(LimbRecipe(**given))
    assert len(caught.value.problems) == 1
    problem = caught.value.problems[0]
    assert problem.key.startswith("body.") or problem.file


def test_a_straight_rest_pose_needs_the_axis(tmp_path: Path) -> None:
    files = write_limb(tmp_path, rest=0.0)
    with pytest.raises(BadInput, match="give axis"):
        unbaked(LimbRecipe(**files, joint="forearm_l"))
    found = unbaked(LimbRecipe(**files, joint="forearm_l", axis=(1.0, 0.0, 0.0)))
    assert found.mesh.rest == pytest.approx(0.0, abs=1e-9)
    assert found.mesh.bent(1.0)[:, 2].min() < found.mesh.vertices[:, 2].min() - 20.0


def test_two_skins_around_the_joint_are_refused_by_their_groups(tmp_path: Path) -> None:
    files = write_limb(tmp_path)
    text = Path(files["file"]).read_text()
    faces = "\n".join(line for line in text.splitlines() if line.startswith("f"))
    points = [line.split() for line in text.splitlines() if line.startswith("v")]
    more = "\n".join(f"v {float(a) + 2} {b} {c}" for _, a, b, c in points)
    count = len(points)
    shifted = "\n".join(
        "f " + " ".join(str(int(corner) + count) for corner in line.split()[1:]) for line in faces.splitlines()
    )
    Path(files["file"]).write_text(f"g skin\n{text}\n{more}\ng cloth\n{shifted}\n")

    def doubled(data: Any) -> None:
        data.update({name: [*pairs, *([i + count, w] for i, w in pairs)] for name, pairs in data.items()})

    changed(tmp_path, "weights.json", doubled)
    with pytest.raises(BadInput, match=r"2 surfaces reach.*'skin', 'cloth'"):
        unbaked(LimbRecipe(**files, joint="elbow_left"))
    assert unbaked(LimbRecipe(**files, joint="elbow_left", group="cloth")).girth > 100.0


def test_what_a_mesh_file_refers_to_is_not_opened(tmp_path: Path) -> None:
    files = write_limb(tmp_path)
    text = Path(files["file"]).read_text()
    Path(files["file"]).write_text("mtllib /dev/zero\nusemtl skin\n" + text)
    assert unbaked(LimbRecipe(**files, joint="elbow_left")).girth > 100.0
