"""The part of a page that moves: what a browser needs to draw every step of a run, as compact arrays.

Places are rounded to a 65 000th of the scene and strains to a 250th of their largest value: nothing that is judged is
taken from here, states and probabilities come from the report.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from etextile.types import Array, IntArray
from etextile.vocabulary import STATES
from viz.scene import Colouring, Scene
from viz.style import BODY, FOLDED, STRAIN_RAMP, probability_ramp, round_up, wire_colour
from viz.style import STATES as LOOKS
from viz.surface import shear_angle
from wires.axis import axis_of


Report = Mapping[str, Any]
VENDOR = Path(__file__).parent / "vendor"
LIBRARY = {"three": "three-0.170.0.module.min.js", "orbit": "three-0.170.0.OrbitControls.js"}
STATIC = Path(__file__).parent / "static"
OWN = {"cursor": "cursor.js", "flatmap": "flatmap.js", "history": "history.js"}
"""Parts of the pages' programs by the name a script imports."""
MOST_CELLS = 12_000
"""Fabric cells that are drawn; a finer fabric is thinned to every second, third, ... yarn."""
STEPS_OF_FINE = 24
"""Steps that are kept of a fabric that had to be thinned."""
GRID_DIGITS = 4
"""Decimals of a millimetre by which yarns are told apart."""
FIRST_BROKEN = STATES.index("partial")
_TINY = 1e-9


def live_data(fields: Mapping[str, Sequence[Scene]], report: Report, *, onset: float | None) -> str:
    """Return the scenes of all steps as JSON for the page; `fields`: scenes by name of the field that colours them.

    `onset`: strain marked in the history of a loop.
    """
    first = next(iter(fields.values()))
    quads, owner = thinned(first[-1])
    used, cells = np.unique(quads, return_inverse=True)
    cells = cells.reshape(quads.shape)
    every = np.concatenate([scene.points for scene in first])
    low, size = every.min(axis=0), float(np.ptp(every, axis=0).max()) or 1.0
    wire_points, segments = np.unique(first[-1].wires.segments, return_inverse=True)
    data = {
        "axis": {"name": axis_of(report).name, "unit": axis_of(report).unit},
        "at": [round(scene.displacement_mm, 6) for scene in first],
        "moment": [scene.moment for scene in first],
        "low": low.tolist(),
        "scale": size / 65535.0,
        "points": packed(_rounded([scene.points[used] for scene in first], low, size)),
        "cells": packed(cells.astype(np.uint32)),
        "fields": fields_data(fields, owner),
        "wires": _wires(first, report, segments.reshape(-1, 2), wire_points, low=low, size=size),
        "loops": (loops := loops_data(first, report, low=low, size=size)),
        "first": _first(loops, report, [scene.displacement_mm for scene in first]),
        "flat": flat_shape(first[-1]),
        "body": _body(first, low, size),
        "onset": onset,
        "thinned": len(quads) < len(first[-1].quads),
        "ramp": list(STRAIN_RAMP),
        "probability_ramp": probability_ramp(),
        "states": [
            {"name": look.name, "label": look.label, "colour": look.colour, "marker": look.marker}
            for look in (*LOOKS, *((FOLDED,) if any(loop["folded"] for loop in loops) else ()))
        ],
        "parts": _parts(first, low, size),
        "body_colour": BODY,
    }
    return as_data(data)


def library(*, three: bool = True) -> dict[str, str]:
    """Return what scripts import as addresses that hold the files themselves; `three`: the drawing library as well."""
    files = {name: STATIC / file for name, file in OWN.items()}
    if three:
        files |= {name: VENDOR / file for name, file in LIBRARY.items()}
    return {
        name: f"data:text/javascript;base64,{base64.b64encode(file.read_bytes()).decode()}"
        for name, file in files.items()
    }


def script(name: str = "live") -> str:
    """Return the program of a page."""
    return (STATIC / f"{name}.js").read_text(encoding="utf-8")


def as_data(data: Any) -> str:
    """Return data as JSON that may stand inside of a page: nothing in it ends the element it stands in."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def chosen_steps(cells: int, steps: int, *, keep: Sequence[int] = ()) -> list[int]:
    """Return the steps to draw: all, or some where cells are many; first, last and those to `keep` always."""
    if cells <= MOST_CELLS or steps <= STEPS_OF_FINE:
        return list(range(steps))
    even = {round(number) for number in np.linspace(0, steps - 1, STEPS_OF_FINE)}
    return sorted(even.union(step for step in keep if 0 <= step < steps))


def thinned(scene: Scene) -> tuple[IntArray, IntArray]:
    """Return the cells (q, 4) to draw, and for every cell of the scene the number of the drawn one it lies in.

    Squares of cells become one each; where a square is not full, at holes and curved edges, its cells are kept.
    """
    quads = scene.quads
    if len(quads) <= MOST_CELLS:
        return quads, np.arange(len(quads))
    stride = int(np.ceil(np.sqrt(len(quads) / MOST_CELLS)))
    place, lines = _grid(scene)
    low = place[quads].min(axis=1)
    blocks, block, count = np.unique(low // stride, axis=0, return_inverse=True, return_counts=True)
    near, far = blocks * stride, np.minimum((blocks + 1) * stride, lines - 1)
    corners = np.stack([near, np.stack([far[:, 0], near[:, 1]], 1), far, np.stack([near[:, 0], far[:, 1]], 1)], axis=1)
    nodes = np.unique(quads)
    key, first = np.unique(place[nodes] @ (lines[1], 1), return_index=True)
    wanted = corners @ (lines[1], 1)
    at = np.minimum(np.searchsorted(key, wanted), len(key) - 1)
    whole = (count == np.prod(far - near, axis=1)) & (key[at] == wanted).all(axis=1)
    number = np.cumsum(whole) - 1
    kept = ~whole[block.ravel()]
    owner = np.where(kept, whole.sum() + np.cumsum(kept) - 1, number[block.ravel()])
    return np.concatenate([nodes[first[at[whole]]], quads[kept]]), owner


def _grid(scene: Scene) -> tuple[IntArray, IntArray]:
    """Return the yarns (n, 2) that cross at each point of the fabric, counted along both directions, and how many."""
    angle = np.radians(scene.warp_angle_deg)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    nodes = np.unique(scene.quads)
    flat = np.round(scene.flat[nodes, :2] @ turn, GRID_DIGITS)
    found = [np.unique(flat[:, axis], return_inverse=True) for axis in (0, 1)]
    place = np.full((len(scene.flat), 2), -1)
    place[nodes] = np.stack([inverse for _, inverse in found], axis=1)
    return place, np.array([len(values) for values, _ in found])


def fields_data(fields: Mapping[str, Sequence[Scene]], owner: IntArray) -> dict[str, Any]:
    """Return all fields on the drawn cells, and the change of the angle between the yarns."""
    found = {name: field_data(scenes, owner) for name, scenes in fields.items()}
    return found | {"shear": _shear(next(iter(fields.values())), owner)}


def field_data(scenes: Sequence[Scene], owner: IntArray) -> dict[str, Any]:
    """Return a field on the drawn cells over the steps: the largest of what a drawn cell stands for."""
    values = np.zeros((len(scenes), int(owner.max(initial=-1)) + 1))
    for row, scene in zip(values, scenes, strict=True):
        np.maximum.at(row, owner, scene.colouring.cells)
    largest = round_up(max(scene.colouring.peak for scene in scenes))
    colouring = scenes[0].colouring
    return {"label": colouring.heading, "unit": colouring.unit, "most": largest, "values": _bytes(values, largest)}


def _shear(scenes: Sequence[Scene], owner: IntArray) -> dict[str, Any]:
    """Return by how much the angle between the yarns has changed, degrees."""
    angles = [np.degrees(np.abs(shear_angle(scene.points, scene.quads))) for scene in scenes]
    colouring = [Colouring("shear angle", "deg", values, float(values.max(initial=0.0))) for values in angles]
    return field_data([replace(scene, colouring=own) for scene, own in zip(scenes, colouring, strict=True)], owner)


def flat_shape(scene: Scene) -> dict[str, Any]:
    """Return the wires on the undeformed specimen, mm, and its corners."""
    low, high = scene.flat[:, :2].min(axis=0), scene.flat[:, :2].max(axis=0)
    size = float(max(np.ptp(scene.flat[:, :2], axis=0).max(), _TINY))
    places = scene.flat[scene.wires.segments][:, :, :2]
    return {
        "low": low.tolist(),
        "high": high.tolist(),
        "scale": size / 65535.0,
        "segments": packed(np.round(np.clip((places - low) / size, 0.0, 1.0) * 65535.0).astype(np.uint16)),
    }


def _first(loops: Sequence[Mapping[str, Any]], report: Report, at: Sequence[float]) -> dict[str, Any] | None:
    """Return the loop that breaks first, or comes nearest to it, and its strains at the drawn steps about the break."""
    if not loops:
        return None
    said = report["verdict"]["first_failure"]
    alike = [k for k, loop in enumerate(loops) if said is None or loop["wire"] == said["wire"]]
    exact = [k for k in alike if said is not None and loops[k]["loop"] == said.get("loop")]
    number = max(exact or alike, key=lambda k: (loops[k]["broken"], loops[k]["max_strain"]), default=None)
    if number is None:
        return None
    chosen = loops[number]
    place = next((step for step, value in enumerate(at) if exact and value >= chosen["fails_at"]), None)
    around = [] if place is None else [step for step in (place - 1, place) if step >= 0]
    return {
        "number": number,
        "breaks": bool(exact),
        "step": place,
        "around": [{"at": at[step], "strain": chosen["strain"][step]} for step in around],
    }


def _wires(
    scenes: Sequence[Scene], report: Report, segments: IntArray, points: IntArray, *, low: Array, size: float
) -> dict[str, Any]:
    """Return the wires: segments between points of their own, wire of each, strain over the steps, names."""
    strain = np.stack([np.maximum(100.0 * scene.wires.strain, 0.0) for scene in scenes])
    most = round_up(float(strain.max(initial=0.0)))
    state = states_data(report, scenes)
    return {
        "points": packed(_rounded([scene.points[points] for scene in scenes], low, size)),
        "segments": packed(segments.astype(np.uint32)),
        "wire": scenes[-1].wires.wire.astype(int).tolist(),
        "strain": _bytes(strain, most),
        "most": most,
        "state": state,
        "colour": [wire_colour(number) for number in range(len(STATES))],
        "names": [str(wire.get("name", wire["wire"])) for wire in report.get("wires", [])],
        "nets": _nets(report),
        "broken": [wire["failure_probability"] for wire in report.get("wires", [])],
    }


def _nets(report: Report) -> dict[str, list[int]]:
    """Return the wires of every net by its name."""
    names = {str(wire.get("name", wire["wire"])): wire["wire"] for wire in report.get("wires", [])}
    found: dict[str, list[int]] = {}
    for net in report.get("nets", []):
        wires = [names[str(name)] for name in net.get("wires", ()) if str(name) in names]
        found[str(net.get("name", ""))] = wires or ([net["wire"]] if net.get("wire") is not None else [])
    return found


def states_data(report: Report, scenes: Sequence[Scene]) -> list[list[int]]:
    """Return the state of every wire at every drawn step: as judged, else that of its worst loop."""
    count = len(report.get("wires", []))
    found = []
    for scene in scenes:
        judged = scene.wires.state
        row = [0] * count if judged is None else np.asarray(judged).astype(int).tolist()
        found.append(row)
    return found


def loops_data(scenes: Sequence[Scene], report: Report, *, low: Array, size: float) -> list[dict[str, Any]]:
    """Return the loops: where they are and how strained over the steps, and what the report says of each."""
    last = scenes[-1].loops
    said = {(wire["wire"], spot["loop"]): (wire, spot) for wire in report.get("wires", []) for spot in wire["loops"]}
    key = axis_of(report).failure_key
    beyond = report.get("joint", {}).get("folded_beyond")
    found = []
    for k, (wire, index) in enumerate(zip(last.wire.tolist(), last.index.tolist(), strict=True)):
        entry = said.get((wire, index))
        if entry is None:
            continue
        owner, spot = entry
        kind = spot.get("strain_kind", "")
        strain = [(s.loops.span_strain if kind == "fabric" else s.loops.wire_strain)[k] for s in scenes]
        found.append(
            {
                "wire": wire,
                "name": str(owner.get("name", wire)),
                "loop": index,
                "warp_mm": float(last.flat[k, 0]),
                "weft_mm": float(last.flat[k, 1]),
                "flat": [round(float(value), 3) for value in last.flat[k, :2]],
                "place": packed(_rounded([s.loops.deformed[k] for s in scenes], low, size)),
                "strain": [round(float(value), 5) for value in strain],
                "kind": kind,
                "states": _states(scenes, k, beyond if spot.get("folded") else None),
                "folded": bool(spot.get("folded")),
                "state": spot["state"],
                "max_strain": spot["max_strain"],
                "fails_at": spot.get(key),
                "broken": spot["failure_probability"],
                "open": spot.get("open_probability"),
            }
        )
    return found


def _states(scenes: Sequence[Scene], k: int, beyond: float | None) -> list[int]:
    """Return the states of a loop over the steps; from where its span is shorter by `beyond` on, sound is undetermined.

    Only while the joint bends: a piece that is put on does not fold.
    """
    states, folded = [], False
    for scene in scenes:
        state = int(scene.loops.state[k])
        folded |= beyond is not None and scene.displacement_mm > 0.0 and float(scene.loops.span_strain[k]) < -beyond
        states.append(len(LOOKS) if folded and state < FIRST_BROKEN else state)
    return states


def _parts(scenes: Sequence[Scene], low: Array, size: float) -> dict[str, Any] | None:
    """Return the lands of parts: names, corners (P, 4, 2) when flat and over the steps (S, P, 4, 3)."""
    last = scenes[-1].parts
    if last is None:
        return None
    places = [scene.parts.deformed.reshape(-1, 3) for scene in scenes if scene.parts is not None]
    return {
        "names": list(last.names),
        "flat": np.round(last.flat, 3).tolist(),
        "places": packed(_rounded(places, low, size)),
    }


def _body(scenes: Sequence[Scene], low: Array, size: float) -> dict[str, Any] | None:
    """Return the body: every pose once and which one a step has; a rigid body once, with its shift at every step."""
    bodies = [scene.body for scene in scenes]
    if any(body is None for body in bodies):
        return None
    vertices = [body.vertices for body in bodies if body is not None]
    shift = [(item - vertices[0]).mean(axis=0) for item in vertices]
    rigid = all(np.abs(item - vertices[0] - by).max() < 1e-6 for item, by in zip(vertices, shift, strict=True))
    places = [vertices[0]] if rigid else vertices
    box_low = np.min([item.min(axis=0) for item in places], axis=0)
    box = float(max(np.ptp(np.concatenate(places), axis=0).max(), _TINY))
    faces = next(body.faces for body in bodies if body is not None)
    poses, pose = _distinct(_rounded(places, box_low, box))
    return {
        "low": box_low.tolist(),
        "scale": box / 65535.0,
        "points": packed(poses),
        "pose": [0] * len(scenes) if rigid else pose,
        "faces": packed(np.asarray(faces).astype(np.uint32)),
        "shrink": _sag(scenes[-1]),
        "shift": [item.tolist() for item in shift] if rigid else None,
    }


def _distinct(places: Any) -> tuple[Any, list[int]]:
    """Return the rows (P, n, 3) of places (S, n, 3) that differ, in their order, and the row of every step (S,)."""
    number: dict[bytes, int] = {}
    pose = [number.setdefault(row.tobytes(), len(number)) for row in places]
    return places[[pose.index(k) for k in range(len(number))]], pose


def _sag(scene: Scene) -> float:
    """Return by how much (mm) the body is drawn smaller: flat cells cut into it between their corners."""
    touching = scene.quads[scene.touched[scene.quads].any(axis=1)]
    if not len(touching):
        return 0.0
    across = scene.points[touching[:, 2]] - scene.points[touching[:, 0]]
    return 0.18 * float(np.median(np.linalg.norm(across, axis=1)))


def _rounded(places: Sequence[Array], low: Array, size: float) -> Any:
    """Return places (S, n, 3) as whole 65 535ths of `size` from `low` on."""
    return np.round(np.clip((np.stack(places) - low) / size, 0.0, 1.0) * 65535.0).astype(np.uint16)


def _bytes(values: Array, largest: float) -> str:
    """Return values from 0 to `largest` as bytes, packed."""
    return packed(np.round(np.clip(values / largest, 0.0, 1.0) * 250.0).astype(np.uint8))


def packed(values: Any) -> str:
    """Return the bytes of an array, little-endian, as text."""
    little = values.astype(values.dtype.newbyteorder("<"), copy=False)
    return base64.b64encode(np.ascontiguousarray(little).tobytes()).decode()
