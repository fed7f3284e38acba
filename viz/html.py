"""The reliability report as one page that needs nothing else: pictures and curves are inside the file.

The page is drawn from the report dictionary alone (`wires.report.build_report`), so it can be made again from
`report.json` and the maps.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from viz.charts import MeasuredCurve, charts_of, data_address
from viz.style import STATES, StateStyle, contrast
from wires.axis import axis_of
from wires.construction import advice_sentences, laid_words
from wires.life import by_life
from wires.trust import as_provisional
from wires.wording import compact, cycles, number, percent, probability, quantity


if TYPE_CHECKING:
    from jinja2 import Environment

Report = Mapping[str, Any]

WORST_LOOPS = 10
SELDOM = 0.001
"""Probability from which on the likeliest break is told."""

INKS = ("#000000", "#ffffff")
"""Letters on a coloured ground: those that stand out more."""

_MIME = {".png": "image/png", ".svg": "image/svg+xml", ".jpg": "image/jpeg", ".jpeg": "image/jpeg"}
_CAPTIONS = {
    "failure": "Loops by state on the deformed fabric",
    "failure_inner": "The same from the inner side",
    "failure_flat": "Loops by state on the undeformed specimen",
    "warp_strain": "Warp strain",
    "weft_strain": "Weft strain",
    "diagonal_strain": "Diagonal strain",
    "wire_strain": "Strain of the wires",
}


_GLYPHS = {"o": "○", "s": "□", "^": "△", "X": "✕"}
"""The markers of the maps as letters."""


def render_report_html(
    report: Report, *, maps: Sequence[Path] = (), curves: Sequence[MeasuredCurve] = (), live: str | None = None
) -> str:
    """Return the page for a report; `maps` are pictures in the order in which they are shown.

    `live`: data of the scene that can be turned (`viz.live.live_data`); without it the page is still.
    """
    return (
        environment()
        .get_template("report.html.j2")
        .render(
            report={"nets": [], "parts": [], **report},
            tone=_tone(report["verdict"]),
            headline=_headline(report["verdict"]),
            states=state_styles(),
            tiles=_tiles(report),
            facts=_facts(report),
            worst=_worst(report),
            wearing=_wearing(report),
            maps=[{"source": _picture(path), "caption": _caption(path)} for path in maps],
            charts=charts_of(report, curves),
            axis=axis_of(report),
            live=None if live is None else _live(live),
            first=_first(report, live),
            advice=advice_sentences(report),
        )
    )


def _live(data: str) -> dict[str, Any]:
    """Return what the moving part of the page is made of."""
    from viz.live import library, script

    return {
        "data": data,
        "loops": '"loops":[]' not in data,
        "imports": json.dumps({"imports": library()}),
        "script": script(),
        "thinned": '"thinned":true' in data,
    }


def _first(report: Report, live: str | None) -> dict[str, Any] | None:
    """Return which loop breaks first, where, when, how sure, and its strain about the break where steps are known."""
    axis = axis_of(report)
    data = {} if live is None else json.loads(live)
    found = data.get("first")
    said = report["verdict"]["first_failure"]
    wires = [wire for wire in report["wires"] if said is not None and wire["wire"] == said["wire"]]
    if said is None:
        return _likeliest(report)
    if not wires:
        return None
    where = "in the weave" if said.get("loop") is None else f"loop {said['loop']}"
    parts = [spot for spot in wires[0]["loops"] if spot["loop"] == said.get("loop")] or wires
    facts = [
        ("Which", f"wire {said.get('name') or said['wire']}, {where}"),
        ("Where", f"warp {number(said['warp_mm'], '{:.1f}')} mm, weft {number(said['weft_mm'], '{:.1f}')} mm"),
        ("At", f"{number(said[axis.key], '{:.1f}')} {axis.unit}: a broken filament is from here on likelier than none"),
        ("How sure", f"probability {probability(parts[0]['failure_probability'])} that a filament is broken here at "
                     f"the end, {probability(parts[0]['open_probability'])} that all are"),
    ]  # fmt: skip
    around = found["around"] if found else []
    if around:
        words = [f"{number(item['strain'], '{:.4f}')} at {number(item['at'], '{:.1f}')} {axis.unit}" for item in around]
        before = f"{words[0]}, the last step before; " if len(words) > 1 else ""
        facts.append(("Strain there", f"{before}{words[-1]}, the first step after"))
    heading = as_provisional("The first break", passed=report["verdict"]["withheld"])
    return {"heading": heading, "facts": facts, "ringed": bool(found and found["breaks"])}


def _likeliest(report: Report) -> dict[str, Any] | None:
    """Return where a filament is likeliest to break when no break is likelier than none; None when hardly any is."""
    wire = max(report["wires"], key=lambda item: float(item["failure_probability"]), default=None)
    if wire is None or wire["failure_probability"] < SELDOM:
        return None
    spots = [("in the weave", piece) for piece in wire.get("woven", ())]
    spots += [(f"loop {loop['loop']}", loop) for loop in wire["loops"]]
    if not spots:
        return None
    where, spot = max(spots, key=lambda item: float(item[1]["failure_probability"]))
    axis, weft = axis_of(report), spot.get("weft_mm", wire["weft_mm"])
    end = number(_largest(axis.values(report)), "{:.1f}")
    facts = [
        ("Which", f"wire {wire.get('name') or wire['wire']}, {where}"),
        ("Where", f"warp {number(spot['warp_mm'], '{:.1f}')} mm, weft {number(weft, '{:.1f}')} mm"),
        ("At", f"up to {end} {axis.unit} a broken filament is at no place likelier than none"),
        ("How sure", f"probability {probability(spot['failure_probability'])} of a broken filament here at the end, "
                     f"{probability(wire['failure_probability'])} anywhere in this wire"),
        ("Strain there", f"{number(spot['max_strain'], '{:.4f}')} at most"),
    ]  # fmt: skip
    heading = as_provisional("The likeliest break", passed=report["verdict"]["withheld"])
    return {"heading": heading, "facts": facts, "ringed": False}


def environment() -> Environment:
    """Return the templates of all pages, with the words for numbers as filters."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    found = Environment(
        loader=PackageLoader("viz", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.filters.update(
        provisional=as_provisional,
        number=number,
        percent=percent,
        probability=probability,
        cycles=cycles,
        compact=_short,
    )
    return found


def _short(value: Any) -> str:
    """Return a value of a case file as text without needless digits."""
    if value is None:
        return "none"
    return compact(value) if isinstance(value, float) else str(value)


def state_styles() -> list[dict[str, str]]:
    """Return how the states of loops look on a page."""
    return [_state(state) for state in STATES]


def _state(state: StateStyle) -> dict[str, str]:
    """Return how a state looks on the page, the same as on the maps."""
    ink = max(INKS, key=lambda colour: contrast(colour, state.colour))
    return {
        "name": state.name,
        "colour": state.colour,
        "ink": ink,
        "glyph": _GLYPHS[state.marker],
        "label": state.label,
    }


def _tone(verdict: Mapping[str, Any]) -> str:
    """Return the style of the verdict: good, bad, withheld or none."""
    if verdict["withheld"]:
        return "withheld"
    return {True: "good", False: "bad", None: "none"}[verdict["survive"]]


def _headline(verdict: Mapping[str, Any]) -> str:
    """Return the verdict in two words: wires may fail where no break is likelier than none, but one is not unlikely."""
    fails = "Wires fail" if verdict["first_failure"] else "Wires may fail"
    return {"good": "The wires survive", "bad": fails, "withheld": "Verdict withheld", "none": "No verdict"}[
        _tone(verdict)
    ]


def _tiles(report: Report) -> list[dict[str, str]]:
    """Return the key figures: label, value, unit."""
    first, axis = report["verdict"]["first_failure"], axis_of(report)
    tiles = [
        *_motion_tiles(report),
        ("Greatest warp strain", number(_largest(report["strain"]["warp_max"]), "{:.3f}"), ""),
        ("Greatest weft strain", number(_largest(report["strain"]["weft_max"]), "{:.3f}"), ""),
    ]
    if report["wires"]:
        said = (number(first[axis.key], "{:.1f}"), axis.unit) if first else ("none", "in a typical wire")
        tiles.append(("First filament breaks at", *said))
    if "joint" in report:
        tiles.append(("Greatest pressure on skin", *quantity(report["contact"]["pressure_kPa_max"], "kPa")))
    elif "contact" in report:
        tiles.append(("Pressure of the body, mean", *quantity(report["contact"]["pressure_kPa_mean"], "kPa")))
    return [{"label": label, "value": value, "unit": unit} for label, value, unit in tiles]


def _motion_tiles(report: Report) -> list[tuple[str, str, str]]:
    """Return the figures of the motion: of a load, what its standard reads; else travel and force, angle and moment."""
    axis, travel = axis_of(report), "Flexion" if "joint" in report else "Travel"
    reached = quantity(_largest(axis.values(report)), axis.unit, digits=4)
    if "pressure" in report:
        first = (report.get("rupture") or {}).get("first")
        at_first = [("Bursting strength", *quantity(first["pressure_bar"], "bar"))] if first else []
        greatest = quantity(_largest(report["pressure"]["pressure_bar"]), "bar")
        return [("Greatest pressure", *greatest), ("Height there", *reached), *at_first]
    if "weight" in report:
        found = report["weight"]["at_standard_angle"]
        stiffness = None if found is None else found["peirce_stiffness_Nmm"]
        return [("Drop of the end", *reached), ("Bending stiffness by the standard", *quantity(stiffness, "N mm"))]
    response = quantity(_largest(axis.responses(report)), axis.response_unit)
    return [(travel, *reached), (f"Greatest {axis.response}", *response)]


def _largest(values: Sequence[float | None]) -> float | None:
    """Return the largest number, None when there is none."""
    return max((value for value in values if value is not None), default=None)


def _facts(report: Report) -> list[tuple[str, str]]:
    """Return what was computed, as label and text; what is unknown is left out."""
    case, solver, wires = report["case"], report["solver"], report["wire_model"]
    size = " × ".join(f"{length:g}" for length in case["size_mm"])
    facts = [
        ("Fabric", case["fabric"]),
        ("Specimen", f"{size} mm, {case['portion']} modelled" if any(case["size_mm"]) else ""),
        ("Lattice", f"coarsening {case['coarsening']:g}: {solver['nodes']} nodes, {solver['trusses']} trusses"),
        ("Body", case["body"]),
        ("Contact", f"friction {compact(case['friction'])}"),
        ("Effects", ", ".join(case["effects"])),
    ]
    if wires is not None:
        diameter = f"{1000 * wires['filament_diameter_mm']:.0f} µm"
        facts += [
            ("Wires", f"{wires['filaments']} filaments of {diameter}, {wires['material']}, bond {wires['bond']}"),
            ("Layout", laid_words(wires)),
            ("Share of the wires", _share(wires["stiffness_share"])),
        ]
    facts += [
        (
            "Solution",
            f"{solver['steps']} steps, {solver['linear_solves']} linear solves, cut back {solver['cut_backs']} times",
        ),
        (
            "Time",
            f"{solver['wall_s']:.1f} s, {solver['solve_s']:.1f} s of it solving ({solver['linear'] or 'unnamed'})",
        ),
    ]
    return [(label, text) for label, text in facts if text]


def _worst(report: Report) -> list[dict[str, Any]]:
    """Return the loops with the greatest strain, each with its wire's name and weft coordinate."""
    loops = [
        {"weft_mm": wire["weft_mm"], **loop, "wire": wire.get("name") or wire["wire"]}
        for wire in report["wires"]
        for loop in wire["loops"]
    ]
    return sorted(loops, key=lambda loop: -float(loop["max_strain"]))[:WORST_LOOPS]


def _wearing(report: Report) -> list[dict[str, Any]]:
    """Return the loops of the shortest lives, of the largest swings where no life is known."""
    if report.get("life") is None:
        return []
    return by_life(report["wires"], WORST_LOOPS)


def _caption(path: Path) -> str:
    """Return the caption of a map from its file name."""
    return _CAPTIONS.get(path.stem, path.stem.replace("_", " ").capitalize())


def _picture(path: Path) -> str:
    """Return a picture file as a data address."""
    return data_address(path.read_bytes(), _MIME[path.suffix.lower()])


def _share(share: float) -> str:
    """Say how much of the coupon's warp stiffness the wires had."""
    return f"{100 * share:.2g} % of the warp stiffness" if share else "the fabric's coupons had no wires"
