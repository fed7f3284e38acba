"""What the moving part of a page shows of folds and parts: folds are undetermined, parts lie where they are."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from etextile.studies.run.drawing import SKIN_MM, limb_at
from etextile.studies.run.worn import folded_loops
from loadcases.build_worn import limb_of
from loadcases.reader import load_case
from viz.html import _first
from viz.live import live_data
from viz.scene import Parts, Scene
from viz.style import STATES


def report(**more: Any) -> dict[str, Any]:
    """A report of the scene's three wires with three loops each, the middle ones in folds."""
    loops = [
        {"loop": k, "state": "intact", "max_strain": 0.1, "first_failure_mm": None, "first_failure_deg": None,
         "failure_probability": 0.1 * k, "open_probability": 0.0, "warp_mm": 20.0 * k, "folded": k == 1}
        for k in range(3)
    ]  # fmt: skip
    wires = [
        {"wire": k, "name": f"w{k}", "weft_mm": 20.0 * k, "failure_probability": 0.3 - 0.1 * k, "loops": loops}
        for k in range(3)
    ]
    return {"wires": wires, "verdict": {"first_failure": None, "withheld": False}, **more}


def steps(scene: Scene) -> list[Scene]:
    """Put on (its loops slack), bent a little, bent so far that the loops numbered 1 are folded, bent back."""
    loops = replace(scene.loops, state=np.where(scene.loops.wire == 2, 2, 0))
    angles = (-1.0, 10.0, 20.0, 30.0)
    return [
        replace(scene, displacement_mm=at, worn=True, loops=replace(loops, folded=(loops.index == 1) & (at >= 20.0)))
        for at in angles
    ]


def test_loops_fold_where_their_span_is_shorter_while_the_joint_bends() -> None:
    spans = np.array([[0.0] * 3, [-0.2, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, -0.2, -0.04], [0.0, 0.0, 0.0]])
    run: Any = SimpleNamespace(
        displacement_mm=np.array([-1.0, 10.0, 20.0, 30.0]), wires=SimpleNamespace(span_strain=spans)
    )
    until = [folded_loops(run, until=step).tolist() for step in range(4)]
    assert until == [[False] * 3, [False] * 3, [False, True, False], [False, True, False]]
    assert folded_loops(run).tolist() == until[-1]


def test_loops_in_folds_are_neither_whole_nor_broken_from_where_they_fold(scene: Callable[..., Scene]) -> None:
    made = steps(scene())
    bent = {"joint": {"angle_deg": [10.0, 20.0, 30.0], "moment_Nmm": [1.0, 2.0, 3.0], "folded_beyond": 0.02}}
    data = json.loads(live_data({"warp_strain": made}, report(**bent), onset=None))
    undetermined = len(STATES)
    assert data["states"][undetermined]["label"] == "in folds: undetermined"
    for loop in data["loops"]:
        sound = 2 if loop["wire"] == 2 else 0  # what had failed before stays so in a fold
        late = undetermined if loop["loop"] == 1 and sound == 0 else sound
        assert loop["states"] == [sound, sound, late, late]


def test_without_folds_there_are_four_states(scene: Callable[..., Scene]) -> None:
    rows = [{**wire, "loops": [{**loop, "folded": False} for loop in wire["loops"]]} for wire in report()["wires"]]
    data = json.loads(live_data({"warp_strain": [scene()]}, {**report(), "wires": rows}, onset=None))
    assert [look["name"] for look in data["states"]] == [look.name for look in STATES]
    assert data["shape"]["parts"] is None


def test_parts_lie_where_they_are_at_every_step(scene: Callable[..., Scene]) -> None:
    flat = np.array([[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]])
    lifted = [np.concatenate([flat, np.full((1, 4, 1), height)], axis=2) for height in (0.0, 12.5)]
    made = [replace(scene(), parts=Parts(("J1",), flat, places)) for places in lifted]
    data = json.loads(live_data({"warp_strain": made}, report(), onset=None))["shape"]
    assert data["parts"]["names"] == ["J1"]
    whole = np.frombuffer(base64.b64decode(data["parts"]["places"]), dtype="<u2").reshape(2, 1, 4, 3)
    assert np.array(data["low"]) + data["scale"] * whole == pytest.approx(np.stack(lifted), abs=0.01)


def test_a_limb_that_bends_back_is_kept_once_for_every_pose(scene: Callable[..., Scene]) -> None:
    made = scene()
    assert made.body is not None
    still, bent = made.body.vertices, made.body.vertices * (1.0, 1.0, 2.0)
    poses = (still, bent, still + 1e-9, bent)
    moved = [replace(made, body=replace(made.body, vertices=places)) for places in poses]
    body = json.loads(live_data({"warp_strain": moved}, report(), onset=None))["shape"]["body"]
    kept = np.frombuffer(base64.b64decode(body["points"]), dtype="<u2").reshape(-1, len(still), 3)
    assert len(kept) == 2
    for step, places in enumerate(poses):
        assert np.array(body["low"]) + body["scale"] * kept[body["pose"][step]] == pytest.approx(places, abs=0.01)
    lifted = [replace(made, body=replace(made.body, vertices=np.add(still, (0.0, 0.0, up)))) for up in (0.0, 5.0)]
    rigid = json.loads(live_data({"warp_strain": lifted}, report(), onset=None))["shape"]["body"]
    assert rigid["pose"] == [0, 0]
    assert np.array(rigid["shift"]) == pytest.approx(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 5.0]]))


def test_where_no_break_is_likelier_than_none_the_likeliest_is_told() -> None:
    made = report(punch={"displacement_mm": [10.0, 40.0], "force_N": [1.0, 2.0]})
    told = _first(made, None)
    assert told is not None
    assert told["heading"] == "The likeliest break"
    facts = dict(told["facts"])
    assert facts["Which"] == "wire w0, loop 2"
    assert "0.200 of a broken filament here" in facts["How sure"]
    assert "0.300 anywhere" in facts["How sure"]
    assert _first({**made, "wires": [{**wire, "failure_probability": 1e-5} for wire in made["wires"]]}, None) is None


def test_charts_follow_the_slider_in_their_own_unit_where_a_load_is_raised(scene: Callable[..., Scene]) -> None:
    made = [replace(scene(), displacement_mm=bar, travel_unit="bar") for bar in (0.5, 2.0)]
    data = json.loads(live_data({"warp_strain": made}, report(), onset=None, at=[10.0, 30.0]))
    assert data["follow"] == {"bar": [0.5, 2.0], "mm": [10.0, 30.0]}
    assert data["at"] == [10.0, 30.0]
    usual = json.loads(live_data({"warp_strain": [scene()]}, report(), onset=None))
    assert usual["follow"] == {"mm": usual["at"]}


def test_a_drawn_limb_does_not_stand_out_of_the_skin() -> None:
    case = load_case("elbow_sleeve").case
    bent: Any = SimpleNamespace(displacement_mm=np.array([120.0]), body=None)
    posed = replace(limb_of(case), flexion=np.radians(120.0))
    gap = posed.distance(limb_at(bent, case, 0).vertices).gap
    assert gap.max() < SKIN_MM
    assert np.mean(gap > -SKIN_MM) > 0.75, "most of it lies on the skin, the rest is what the crook has swallowed"
