"""An ensemble, or two designs on the same random numbers, as one page that needs nothing else.

Drawn from `ensemble.json` (and `compare.json`) and the undeformed specimen alone: what a map of the page says of a loop
at a step is the number that stands there.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from viz.charts import curve_chart, data_address
from viz.html import environment, state_styles
from viz.live import as_data, fields_data, flat_shape, library, script
from viz.mirror import whole
from viz.plots import Curve
from viz.scene import Scene
from viz.shape import shape_data, thinned
from viz.style import STRAIN_RAMP, probability_ramp
from wires.wording import chance, number


Data = Mapping[str, Any]
WORST_LOOPS = 20
DIGITS = 6
EVENTS = {
    "any_failure": "some wire has lost a filament",
    "any_open": "some wire is interrupted",
    "share_failed": "wires that lost a filament",
    "share_open": "wires interrupted",
}
"""What happens to a specimen, in words."""
CAPTIONS = {
    "probability": "Probability that a loop has lost a filament, end of the motion",
    "probability_open": "Probability that a loop is interrupted, end of the motion",
    "fragility_wires": "Every wire over the motion",
}


@dataclass(frozen=True)
class EnsembleView:
    """An ensemble as a page shows it: `ensemble.json`, the undeformed specimen as modelled, its short name."""

    data: Data
    specimen: Scene
    name: str = ""
    fields: Mapping[str, Sequence[Scene]] = field(default_factory=dict)
    """The run without scatter: its scenes over the steps by the field that colours them; none: only the flat map."""
    way: Sequence[float] = ()
    """How far the motion has come at each of these steps, there and back, from its beginning."""


def render_ensemble_html(
    chances: EnsembleView, *, curves: Sequence[Curve], x_label: str, maps: Sequence[Path] = ()
) -> str:
    """Return the page of an ensemble; `curves`: fragility of the specimen, `maps`: pictures made of it."""
    data = chances.data
    return (
        environment()
        .get_template("ensemble.html.j2")
        .render(
            data=data,
            states=state_styles(),
            tiles=_tiles(data),
            moving=_moving([chances]),
            unit=_unit(data),
            charts=[_chart("Fragility of the specimen, with 95 % bands", curves, x_label, "probability, share", data)],
            maps=[_picture(path) for path in maps if path.stem in CAPTIONS],
            worst=_worst(data),
            mirrored=any(item["copies"] > 1 for wire in data["wires"] for item in (wire, *wire["loops"])),
            panels=_ranking(data),
        )
    )


def render_comparison_html(
    data: Data,
    designs: Sequence[EnsembleView],
    *,
    curves: Sequence[Curve],
    fragility: Sequence[Curve],
    x_label: str,
    maps: Mapping[str, Path] | None = None,
) -> str:
    """Return the page of two designs side by side; `data` as in compare.json.

    `curves`: differences over the motion; `fragility`: the same event in both designs; `maps`: a picture of each.
    """
    one = designs[0].data
    return (
        environment()
        .get_template("compare.html.j2")
        .render(
            data=data,
            states=state_styles(),
            tone=_tone_of(data),
            moving=_moving(designs),
            unit=_unit(one),
            charts=[
                _chart("Wires that lost a filament, with 95 % bands", fragility, x_label, "share of the wires", one),
                _chart("Difference, B less A: below 0, B is better", curves, x_label, "B less A, share", one),
            ],
            maps=[
                _picture(path) | {"caption": f"{name}: {CAPTIONS['probability']}"}
                for name, path in (maps or {}).items()
            ],
            rows=_events(data),
        )
    )


def _chart(caption: str, curves: Sequence[Curve], x_label: str, y_label: str, data: Data) -> dict[str, Any]:
    return {"caption": caption, **curve_chart(curves, x_label=x_label, y_label=y_label, unit=_unit(data))}


def _picture(path: Path) -> dict[str, str]:
    return {"source": data_address(path.read_bytes(), "image/png"), "caption": CAPTIONS[path.stem]}


def _unit(data: Data) -> str:
    """Return the unit of the motion: mm, or deg of a joint."""
    return str(data.get("unit", "mm")).replace("**", "")


def _moving(designs: Sequence[EnsembleView]) -> dict[str, Any]:
    """Return what the maps with a slider are made of, and the fabrics that move with it where their runs are there."""
    solid = all(item.fields for item in designs)
    return {
        "solid": solid,
        "data": as_data(
            {
                "unit": _unit(designs[0].data),
                "ramp": probability_ramp(),
                "strain_ramp": list(STRAIN_RAMP),
                "designs": [map_data(item) | (solid_data(item) if solid else {}) for item in designs],
            }
        ),
        "names": [item.name for item in designs],
        "imports": json.dumps({"imports": library(three=solid)}),
        "script": script("chances"),
    }


def map_data(chances: EnsembleView) -> dict[str, Any]:
    """Return one map: the whole specimen, and the probabilities with intervals of its loops and wires at every step.

    A loop drawn as the mirror image of another has `of`, the number of the one that was modelled.
    """
    data, scene = chances.data, whole(chances.specimen)
    fragility = data["fragility"]
    return {
        "name": chances.name,
        "at": [round(float(value), DIGITS) for value in fragility["travel_mm"]],
        "moved": [round(float(value), DIGITS) for value in fragility["displacement_mm"]],
        "some": _rounded(fragility["any_failure"]),
        "flat": flat_shape(scene),
        "wire": scene.wires.wire.astype(int).tolist(),
        "wires": [
            {"name": str(wire.get("name", wire["wire"])), **_rounded(curve)}
            for wire, curve in zip(data["wires"], fragility["wires"], strict=True)
        ],
        "loops": _loops(data),
        "drawn": [
            {"of": int(of), "at": [round(float(value), 3) for value in place]}
            for of, place in zip(scene.loops.span_strain, scene.loops.flat, strict=True)
        ],
    }


def solid_data(chances: EnsembleView) -> dict[str, Any]:
    """Return the fabric of the run without scatter, and between which of its steps each step of the curves lies.

    Its loops stand in the order of those of the flat map.
    """
    scenes = next(iter(chances.fields.values()))
    travel = np.array(chances.data["fragility"]["travel_mm"])
    places = np.interp(travel - travel[0], chances.way, np.arange(len(scenes)))
    return {
        "shape": shape_data(scenes),
        "shape_wire": scenes[-1].wires.wire.astype(int).tolist(),
        "fields": fields_data(chances.fields, thinned(scenes[-1])[1]),
        "places": [round(float(place), 3) for place in places],
    }


def _loops(data: Data) -> list[dict[str, Any]]:
    """Return the loops in the order of the model with everything that is known of each."""
    curves = data["fragility"]["loops"]
    rows = [(wire, loop) for wire in data["wires"] for loop in wire["loops"]]
    return [
        {
            "wire": wire["wire"],
            "name": str(wire.get("name", wire["wire"])),
            "loop": loop["loop"],
            "warp_mm": loop["warp_mm"],
            "weft_mm": wire["weft_mm"],
            "open": [loop["open_probability"], loop["open_low"], loop["open_high"]],
            "strain": [loop["max_strain_mean"], loop["max_strain_std"]],
            **_rounded(curve),
        }
        for (wire, loop), curve in zip(rows, curves, strict=True)
    ]


def _rounded(curve: Data) -> dict[str, list[float]]:
    return {name: [round(float(value), DIGITS) for value in curve[name]] for name in ("value", "low", "high")}


def _between(values: Data, form: Any = chance) -> str:
    return f"{form(values['low'])} to {form(values['high'])}"


def _intervals(values: Data) -> str:
    """Return the interval of the samples, and what the coupons leave open where that is known."""
    low, high = (values.get(f"calibration_{end}", 0.0) for end in ("low", "high"))
    open_ = f"; what the coupons leave open: {chance(low)} to {chance(high)}" if high > low else ""
    return f"{_between(values)}{open_}"


def _tiles(data: Data) -> list[dict[str, str]]:
    """Return the key figures with their intervals: value, unit, label."""
    specimen, unit = data["specimen"], _unit(data)
    tiles = [
        {"value": chance(specimen[name]["value"]), "unit": "", "label": f"{words} ({_intervals(specimen[name])})"}
        for name, words in EVENTS.items()
    ]
    half = specimen["half_failed_mm"]
    if half["value"] is not None:
        span = _between(half, lambda value: number(value, "{:.1f}"))
        label = f"half of the specimens have lost a filament ({span})"
        tiles.append({"value": number(half["value"], "{:.1f}"), "unit": unit, "label": label})
    return [tile | {"label": tile["label"][0].upper() + tile["label"][1:]} for tile in tiles]


def _tone_of(data: Data) -> str:
    """Return the style of what a comparison says: withheld, none while it is undecided, else good."""
    if data["verdict"]["withheld"]:
        return "withheld"
    return "none" if data["better"] == "undecided" else "good"


def _worst(data: Data) -> list[dict[str, Any]]:
    """Return the loops that are likeliest to lose a filament."""
    rows = [
        {"name": wire.get("name", wire["wire"]), "weft_mm": wire["weft_mm"], **loop}
        for wire in data["wires"]
        for loop in wire["loops"]
    ]
    key = lambda row: (-row["failure_probability"], -row["open_probability"], -(row["max_strain_mean"] or 0.0))  # noqa: E731
    return sorted(rows, key=key)[:WORST_LOOPS]


def _ranking(data: Data) -> list[dict[str, Any]]:
    """Return per output the inputs by their rank correlation, each with where its interval lies on a scale."""
    headings = {"share_failed": "Wires broken at the end", "first_failure_mm": "Displacement of the first break"}
    panels = []
    for output, heading in headings.items():
        rows = [row for row in data["ranking"] if row["output"] == output]
        places = [{name: 50.0 * (1.0 + row[name]) for name in ("rank_correlation", "low", "high")} for row in rows]
        if rows:
            panels.append({"heading": heading, "rows": list(zip(rows, places, strict=True))})
    return panels


def _events(data: Data) -> list[dict[str, str]]:
    """Return what happens to the specimens of both designs at the end, and the difference."""
    first, second = (item["specimen"] for item in data["designs"].values())
    rows = []
    for name, words in EVENTS.items():
        change = data["difference"][name]
        rows.append(
            {
                "words": words[0].upper() + words[1:],
                "A": f"{chance(first[name]['value'])} ({_between(first[name])})",
                "B": f"{chance(second[name]['value'])} ({_between(second[name])})",
                "change": f"{100 * change['value']:+.1f}",
                "interval": f"{100 * change['low']:+.1f} to {100 * change['high']:+.1f}",
            }
        )
    return rows
