"""The reliability report as one page that needs nothing else: pictures and curves are inside the file.

The page is drawn from the report dictionary alone (`wires.report.build_report`), so it can be made again from
`report.json` and the maps.
"""

from __future__ import annotations

import base64
import io
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from viz.style import DASHES, EDGE, QUIET, SERIES, STATES, TEXT, StateStyle, drawing, luminance
from wires.axis import axis_of
from wires.life import by_life
from wires.wording import compact, cycles, number, percent, probability


if TYPE_CHECKING:
    from jinja2 import Environment
    from matplotlib.axes import Axes

Report = Mapping[str, Any]

WORST_LOOPS = 10

DARK = 50.0
"""Lightness below which a colour carries white letters."""

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


@dataclass(frozen=True)
class Curve:
    """A further force-displacement curve to draw beside the computed one, such as a measurement."""

    label: str
    displacement_mm: Sequence[float]
    force_N: Sequence[float]


def render_report_html(
    report: Report, *, maps: Sequence[Path] = (), curves: Sequence[Curve] = (), live: str | None = None
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
            states=state_styles(),
            tiles=_tiles(report),
            facts=_facts(report),
            worst=_worst(report),
            wearing=_wearing(report),
            maps=[{"source": _picture(path), "caption": _caption(path)} for path in maps],
            charts=_charts(report, curves),
            axis=axis_of(report),
            live=None if live is None else _live(live),
        )
    )


def _live(data: str) -> dict[str, Any]:
    """Return what the moving part of the page is made of."""
    from viz.live import library, script

    return {
        "data": data,
        "imports": json.dumps({"imports": library()}),
        "script": script(),
        "thinned": '"thinned":true' in data,
    }


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
    found.filters.update(number=number, percent=percent, probability=probability, cycles=cycles)
    return found


def state_styles() -> list[dict[str, str]]:
    """Return how the states of loops look on a page."""
    return [_state(state) for state in STATES]


def _state(state: StateStyle) -> dict[str, str]:
    """Return how a state looks on the page, the same as on the maps."""
    ink = TEXT if luminance(state.colour) > DARK else "#ffffff"
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


def _tiles(report: Report) -> list[dict[str, str]]:
    """Return the key figures: label, value, unit."""
    first, axis = report["verdict"]["first_failure"], axis_of(report)
    travel = "Flexion" if "joint" in report else "Travel"
    tiles = [
        (travel, number(_largest(axis.values(report)), "{:.4g}"), axis.unit),
        (f"Greatest {axis.response}", number(_largest(axis.responses(report)), "{:.4g}"), axis.response_unit),
        ("Greatest warp strain", number(_largest(report["strain"]["warp_max"]), "{:.3f}"), ""),
        ("Greatest weft strain", number(_largest(report["strain"]["weft_max"]), "{:.3f}"), ""),
        (
            "First filament breaks at",
            number(first[axis.key], "{:.1f}") if first else "none",
            axis.unit if first else "",
        ),
    ]
    if "joint" in report:
        tiles.append(("Greatest pressure on skin", number(report["contact"]["pressure_kPa_max"], "{:.2f}"), "kPa"))
    elif "contact" in report:
        tiles.append(("Pressure of the body, mean", number(report["contact"]["pressure_kPa_mean"], "{:.3g}"), "kPa"))
    return [{"label": label, "value": value, "unit": unit} for label, value, unit in tiles]


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


def data_address(content: bytes, mime: str) -> str:
    """Return bytes as an address inside of a page."""
    return f"data:{mime};base64,{base64.b64encode(content).decode('ascii')}"


def _charts(report: Report, curves: Sequence[Curve]) -> list[dict[str, str]]:
    """Return the curves over displacement or angle as pictures with captions."""
    axis = axis_of(report)
    charts = [
        (f"{axis.response.capitalize()} over {axis.name}", _chart(report, _draw_force, curves)),
        ("Greatest strain of each yarn family", _chart(report, _draw_strain, curves)),
    ]
    if "joint" in report:
        charts.append(("Pressure on the skin", _chart(report, _draw_skin, curves)))
    if report["damage"] is not None:
        charts.append(("Wires of the specimen by state", _chart(report, _draw_states, curves)))
    if "pressure" in report:
        charts.append(("Height over pressure", _chart(report, _draw_pressure, curves, across="pressure, bar")))
    coupon = report.get("coupon")
    if coupon is not None:
        charts.append(("Coupon: stress over strain", _chart(report, _draw_coupon, curves, across=_NOMINAL)))
        if coupon.get("trellis") is not None:
            charts.append(("Coupon: shear in its centre", _chart(report, _draw_shear, curves, across=_NOMINAL)))
    return [{"caption": caption, "source": source} for caption, source in charts]


_NOMINAL = "nominal strain"


def _chart(report: Report, draw: Any, curves: Sequence[Curve], *, across: str | None = None) -> str:
    """Return one chart as an SVG data address; the same report gives the same bytes."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with drawing(), rc_context({"svg.fonttype": "path", "font.size": 9, "axes.labelsize": 9, "axes.grid": True}):
        figure = Figure(figsize=(3.9, 2.9), layout="constrained")
        FigureCanvasSVG(figure)
        axes = figure.add_subplot()
        draw(axes, report, curves)
        axis = axis_of(report)
        axes.set_xlabel(f"{axis.name}, {axis.unit}" if across is None else across)
        axes.set_xlim(left=0.0)
        axes.set_ylim(bottom=0.0)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None}, transparent=True)
    return data_address(buffer.getvalue(), "image/svg+xml")


def _draw_force(axes: Axes, report: Report, curves: Sequence[Curve]) -> None:
    """Force, with other curves dashed, and where the first filament breaks."""
    axis = axis_of(report)
    axes.plot(axis.values(report), axis.responses(report), color=SERIES[0], label="computed")
    for curve, dash in zip(curves, cycle(DASHES[1:]), strict=False):
        axes.plot(curve.displacement_mm, curve.force_N, color=QUIET, linestyle=dash, label=curve.label)
    first = report["verdict"]["first_failure"]
    if first is not None:
        colour, label = STATES[2].colour, "first filament breaks"
        axes.axvline(first[axis.key], color=colour, linewidth=1, linestyle="--", label=label)
    axes.set_ylabel(f"{axis.response}, {axis.response_unit}")
    axes.legend()


def _draw_skin(axes: Axes, report: Report, _: Sequence[Curve]) -> None:
    """Largest and mean pressure on the skin, outside of folds."""
    for name, colour, dash in zip(("max", "mean"), SERIES, DASHES, strict=False):
        values = report["contact"]["over_angle"][f"pressure_kPa_{name}"]
        axes.plot(report["joint"]["angle_deg"], values, color=colour, linestyle=dash, label=name)
    axes.set_ylabel("pressure, kPa")
    axes.legend()


def _draw_strain(axes: Axes, report: Report, _: Sequence[Curve]) -> None:
    """Greatest engineering strain of warp, weft and diagonals, told apart by the line as well."""
    for name, colour, dash in zip(("warp", "weft", "diagonal"), SERIES, DASHES, strict=False):
        values = report["strain"][f"{name}_max"]
        axes.plot(axis_of(report).values(report), values, color=colour, linestyle=dash, label=name)
    axes.set_ylabel("engineering strain, max")
    axes.legend()


def _draw_pressure(axes: Axes, report: Report, _: Sequence[Curve]) -> None:
    """Height of a bulge over its pressure, and where the first yarn breaks."""
    block = report["pressure"]
    axes.plot([0.0, *block["pressure_bar"]], [0.0, *block["height_mm"]], color=SERIES[0], label="computed")
    first = (report.get("rupture") or {}).get("first")
    if first is not None:
        label = f"first {first['family']} yarn breaks"
        axes.axvline(first["pressure_bar"], color=STATES[2].colour, linewidth=1, linestyle="--", label=label)
    axes.set_ylabel("height, mm")
    axes.legend()


def _draw_coupon(axes: Axes, report: Report, _: Sequence[Curve]) -> None:
    """Nominal stress of a coupon, and of the single element that the direct identification takes for it."""
    coupon = report["coupon"]
    axes.plot(coupon["strain"], coupon["stress_MPa"], color=SERIES[0], label="coupon")
    if coupon["single_element_MPa"] is not None:
        axes.plot(coupon["strain"], coupon["single_element_MPa"], color=SERIES[1], linestyle="--", label="one element")
    axes.set_ylabel("engineering stress, MPa")
    axes.legend()


def _draw_shear(axes: Axes, report: Report, _: Sequence[Curve]) -> None:
    """Shear angle in the centre of a bias coupon, beside that of a trellis with the same centre strain."""
    coupon = report["coupon"]
    trellis = [np.nan if angle is None else angle for angle in coupon["trellis"]["shear_angle_deg"]]
    axes.plot(coupon["strain"], coupon["centre"]["shear_angle_deg"], color=SERIES[0], label="computed")
    axes.plot(coupon["strain"], trellis, color=SERIES[1], linestyle="--", label="trellis")
    axes.set_ylabel("shear angle, deg")
    axes.legend()


def _draw_states(axes: Axes, report: Report, _: Sequence[Curve]) -> None:
    """Number of wires in each state, stacked with the worst state at the bottom."""
    from matplotlib.ticker import MaxNLocator

    damage, worst_first = report["damage"], STATES[::-1]
    areas = axes.stackplot(
        damage[axis_of(report).key],
        [damage["wires"][state.name] for state in worst_first],
        colors=[state.colour for state in worst_first],
        edgecolor=EDGE,
        linewidth=0.6,
    )
    axes.set_ylabel("wires")
    axes.grid(visible=False)
    axes.margins(x=0)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))
    names = [state.name for state in STATES]
    axes.legend(
        areas[::-1],
        names,
        loc="lower center",
        bbox_to_anchor=(0.45, 1.0),
        ncols=4,
        columnspacing=0.9,
        handlelength=1.1,
        handletextpad=0.4,
    )


def _share(share: float) -> str:
    """Say how much of the coupon's warp stiffness the wires had."""
    return f"{100 * share:.2g} % of the warp stiffness" if share else "the fabric's coupons had no wires"
