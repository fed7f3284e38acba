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
from viz.scene import Colouring, Scene
from viz.shape import MOST_CELLS, PARTS, packed, rounded, shape_data, spans, thinned
from viz.style import FOLDED, STRAIN_RAMP, probability_ramp, round_up, wire_colour
from viz.style import STATES as LOOKS
from viz.surface import shear_angle
from wires.axis import axis_of


Report = Mapping[str, Any]
VENDOR = Path(__file__).parent / "vendor"
LIBRARY = {"three": "three-0.170.0.module.min.js", "orbit": "three-0.170.0.OrbitControls.js"}
STATIC = Path(__file__).parent / "static"
OWN = {"cursor": "cursor.js", "flatmap": "flatmap.js", "history": "history.js", "names": "names.js"}
TURNED = {"fabric": "fabric.js"}
"""Parts of the pages' programs by the name a script imports; `TURNED` needs the drawing library."""
STEPS_OF_FINE = 24
"""Steps that are kept of a fabric that had to be thinned."""


def live_data(
    fields: Mapping[str, Sequence[Scene]], report: Report, *, onset: float | None, at: Sequence[float] | None = None
) -> str:
    """Return the scenes of all steps as JSON for the page; `fields`: scenes by name of the field that colours them.

    `onset`: strain marked in the history of a loop; `at`: where the steps stand along the axis of the report, when it
    is another one than that of the scenes, which know a load.
    """
    first = next(iter(fields.values()))
    own = [round(scene.displacement_mm, 6) for scene in first]
    axis = axis_of(report)
    at = own if at is None else [round(value, 6) for value in at]
    data = {
        "axis": {"name": axis.name, "unit": axis.unit},
        "at": at,
        "follow": {axis.unit: at} if first[0].worn else {first[0].travel_unit: own, axis.unit: at},
        "moment": [scene.moment for scene in first],
        "shape": shape_data(first),
        "fields": fields_data(fields, thinned(first[-1])[1]),
        "wires": _wires(first, report),
        "loops": (loops := loops_data(first, report)),
        "first": _first(loops, report, at),
        "flat": flat_shape(first[-1]),
        "onset": onset,
        "ramp": list(STRAIN_RAMP),
        "probability_ramp": probability_ramp(),
        "states": [
            {"name": look.name, "label": look.label, "colour": look.colour, "marker": look.marker}
            for look in (*LOOKS, *((FOLDED,) if any(loop["folded"] for loop in loops) else ()))
        ],
    }
    return as_data(data)


def library(*, three: bool = True) -> dict[str, str]:
    """Return what scripts import as addresses that hold the files themselves; `three`: the drawing library as well."""
    files = {name: STATIC / file for name, file in OWN.items()}
    if three:
        files |= {name: STATIC / file for name, file in TURNED.items()}
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
    low, size = spans(scene.flat[:, :2])
    places = scene.flat[scene.wires.segments][:, :, :2]
    return {
        "low": low.tolist(),
        "high": scene.flat[:, :2].max(axis=0).tolist(),
        "scale": size / PARTS,
        "segments": packed(rounded(places, low, size)),
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


def _wires(scenes: Sequence[Scene], report: Report) -> dict[str, Any]:
    """Return the wires: the wire of each segment and its strain over the steps; states, names, nets, probabilities."""
    strain = np.stack([np.maximum(100.0 * scene.wires.strain, 0.0) for scene in scenes])
    most = round_up(float(strain.max(initial=0.0)))
    state = states_data(report, scenes)
    return {
        "wire": scenes[-1].wires.wire.astype(int).tolist(),
        "strain": _bytes(strain, most),
        "most": most,
        "state": state,
        "colour": [wire_colour(number) for number in range(len(LOOKS))],
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


def loops_data(scenes: Sequence[Scene], report: Report) -> list[dict[str, Any]]:
    """Return the loops in their order: how strained over the steps, and what the report says of each."""
    last = scenes[-1].loops
    said = {(wire["wire"], spot["loop"]): (wire, spot) for wire in report.get("wires", []) for spot in wire["loops"]}
    key = axis_of(report).failure_key
    states = [scene.loops.shown for scene in scenes]
    found = []
    for k, (wire, index) in enumerate(zip(last.wire.tolist(), last.index.tolist(), strict=True)):
        owner, spot = said[wire, index]
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
                "strain": [round(float(value), 5) for value in strain],
                "kind": kind,
                "states": [int(shown[k]) for shown in states],
                "folded": bool(spot.get("folded")),
                "state": spot["state"],
                "max_strain": spot["max_strain"],
                "fails_at": spot.get(key),
                "broken": spot["failure_probability"],
                "open": spot.get("open_probability"),
            }
        )
    return found


def _bytes(values: Array, largest: float) -> str:
    """Return values from 0 to `largest` as bytes, packed."""
    return packed(np.round(np.clip(values / largest, 0.0, 1.0) * 250.0).astype(np.uint8))
