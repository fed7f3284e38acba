"""Curves over displacement or angle as pictures inside of a page, and where a slider of the page meets them."""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import TYPE_CHECKING, Any

import numpy as np

from etextile.errors import EtextileError
from viz import plots
from viz.style import DASHES, EDGE, QUIET, SERIES, STATES, drawing
from wires.axis import axis_of
from wires.wording import unit_for


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.lines import Line2D

Report = Mapping[str, Any]


@dataclass(frozen=True)
class MeasuredCurve:
    """A further force-displacement curve to draw beside the computed one, such as a measurement."""

    label: str
    displacement_mm: Sequence[float]
    force_N: Sequence[float]


def data_address(content: bytes, mime: str) -> str:
    """Return bytes as an address inside of a page."""
    return f"data:{mime};base64,{base64.b64encode(content).decode('ascii')}"


def charts_of(report: Report, curves: Sequence[MeasuredCurve]) -> list[dict[str, Any]]:
    """Return the curves over displacement or angle as pictures with captions, and where a slider meets them."""
    axis = axis_of(report)
    charts = [("Greatest strain of each yarn family", _chart(report, _draw_strain, curves))]
    if "pressure" not in report:
        charts.insert(0, (f"{axis.response.capitalize()} over {axis.name}", _chart(report, _draw_force, curves)))
    if "joint" in report:
        charts.append(("Pressure on the skin", _chart(report, _draw_skin, curves)))
    if report["damage"] is not None:
        charts.append(("Wires of the specimen by state", _chart(report, _draw_states, curves)))
    if "pressure" in report:
        charts.append(
            ("Height over pressure", _chart(report, _draw_pressure, curves, across="pressure, bar", unit="bar"))
        )
    coupon = report.get("coupon")
    if coupon is not None:
        charts.append(("Coupon: stress over strain", _chart(report, _draw_coupon, curves, across=_NOMINAL)))
        if coupon.get("trellis") is not None:
            charts.append(("Coupon: shear in its centre", _chart(report, _draw_shear, curves, across=_NOMINAL)))
    return [{"caption": caption, **chart} for caption, chart in charts]


_NOMINAL = "nominal strain"


def _chart(
    report: Report, draw: Any, curves: Sequence[MeasuredCurve], *, across: str | None = None, unit: str | None = None
) -> dict[str, Any]:
    """Return one chart as an SVG data address, the same report gives the same bytes, and its `track`.

    `across`: what it runs over, `unit`: in which unit a slider meets it, when that is not the axis of the report.
    """
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
        met = axis.unit if across is None else unit
        found = None if met is None else track(axes, unit=met)
    return {"source": data_address(buffer.getvalue(), "image/svg+xml"), "track": found}


def curve_chart(curves: Sequence[plots.Curve], *, x_label: str, y_label: str, unit: str) -> dict[str, Any]:
    """Return curves with their bands as an SVG data address, the same curves give the same bytes, and its `track`."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with drawing(), rc_context({"svg.fonttype": "path", "font.size": 9, "axes.labelsize": 9, "axes.grid": True}):
        figure = Figure(figsize=(5.4, 3.4), layout="constrained")
        FigureCanvasSVG(figure)
        axes = figure.add_subplot()
        plots.draw_curves(axes, curves)
        axes.set(xlabel=x_label, ylabel=y_label, xlim=(min(0.0, *(c.x.min() for c in curves)), None))
        plots.legend_below(figure, axes)
        buffer = io.BytesIO()
        figure.savefig(buffer, format="svg", metadata={"Date": None}, transparent=True)
        found = track(axes, unit=unit)
    return {"source": data_address(buffer.getvalue(), "image/svg+xml"), "track": found}


def track(*panels: Axes, unit: str) -> dict[str, Any]:
    """Return where axes above each other lie in their picture, as shares from its upper left, and the curves.

    A page puts a cursor there and reads the curves at it (`static/cursor.js`). Call after the figure was drawn.
    """
    from matplotlib.transforms import Bbox

    first = panels[0]
    figure = first.get_figure(root=True)
    if figure is None:
        raise EtextileError("axes without a figure have no place in it")
    frame = figure.transFigure.inverted().transform_bbox(Bbox.union([axes.get_window_extent() for axes in panels]))
    lines = [
        {"label": str(line.get_label()), **_points(line)}
        for line in first.get_lines()
        if not str(line.get_label()).startswith("_") and len(np.unique(np.asarray(line.get_xdata()))) > 1
    ]
    return {
        "frame": [round(float(value), 5) for value in (frame.x0, 1.0 - frame.y1, frame.width, frame.height)],
        "span": [round(float(value), 6) for value in first.get_xlim()],
        "unit": unit,
        "lines": lines,
    }


def _points(line: Line2D) -> dict[str, list[float | None]]:
    """Return the places and values of a curve, None where it has a gap."""
    x, y = (np.asarray(values, dtype=float) for values in line.get_data())
    return {"x": [round(value, 6) for value in x.tolist()],
            "y": [float(f"{value:.5g}") if np.isfinite(value) else None for value in y.tolist()]}  # fmt: skip


def _draw_force(axes: Axes, report: Report, curves: Sequence[MeasuredCurve]) -> None:
    """Force, with other curves dashed, and where the first filament breaks."""
    axis = axis_of(report)
    by, unit = unit_for(axis.responses(report), axis.response_unit)
    axes.plot(axis.values(report), np.divide(axis.responses(report), by), color=SERIES[0], label="computed")
    for curve, dash in zip(curves, cycle(DASHES[1:]), strict=False):
        axes.plot(curve.displacement_mm, np.divide(curve.force_N, by), color=QUIET, linestyle=dash, label=curve.label)
    first = report["verdict"]["first_failure"]
    if first is not None:
        colour, label = STATES[2].colour, "first filament breaks"
        axes.axvline(first[axis.key], color=colour, linewidth=1, linestyle="--", label=label)
    axes.set_ylabel(f"{axis.response}, {unit}")
    axes.legend()


def _draw_skin(axes: Axes, report: Report, _: Sequence[MeasuredCurve]) -> None:
    """Largest and mean pressure on the skin, outside of folds."""
    skin = report["contact"]["over_angle"]
    by, unit = unit_for(skin["pressure_kPa_max"], "kPa")
    for name, colour, dash in zip(("max", "mean"), SERIES, DASHES, strict=False):
        values = np.array(skin[f"pressure_kPa_{name}"], dtype=float) / by
        axes.plot(report["joint"]["angle_deg"], values, color=colour, linestyle=dash, label=name)
    axes.set_ylabel(f"pressure, {unit}")
    axes.legend()


def _draw_strain(axes: Axes, report: Report, _: Sequence[MeasuredCurve]) -> None:
    """Greatest engineering strain of warp, weft and diagonals, told apart by the line as well."""
    for name, colour, dash in zip(("warp", "weft", "diagonal"), SERIES, DASHES, strict=False):
        values = report["strain"][f"{name}_max"]
        axes.plot(axis_of(report).values(report), values, color=colour, linestyle=dash, label=name)
    axes.set_ylabel("engineering strain, max")
    axes.legend()


def _draw_pressure(axes: Axes, report: Report, _: Sequence[MeasuredCurve]) -> None:
    """Height of a bulge over its pressure, and where the first yarn breaks."""
    block = report["pressure"]
    axes.plot([0.0, *block["pressure_bar"]], [0.0, *block["height_mm"]], color=SERIES[0], label="fabric")
    if "gauge_bar" in block:
        gauge = [0.0, *block["gauge_bar"]]
        axes.plot(gauge, [0.0, *block["height_mm"]], color=SERIES[1], linestyle="--", label="gauge, with the diaphragm")
    first = (report.get("rupture") or {}).get("first")
    if first is not None:
        label = f"first {first['family']} yarn breaks"
        axes.axvline(first["pressure_bar"], color=STATES[2].colour, linewidth=1, linestyle="--", label=label)
    axes.set_ylabel("height, mm")
    axes.legend()


def _draw_coupon(axes: Axes, report: Report, _: Sequence[MeasuredCurve]) -> None:
    """Nominal stress of a coupon, and of the single element that the direct identification takes for it."""
    coupon = report["coupon"]
    axes.plot(coupon["strain"], coupon["stress_MPa"], color=SERIES[0], label="coupon")
    if coupon["single_element_MPa"] is not None:
        axes.plot(coupon["strain"], coupon["single_element_MPa"], color=SERIES[1], linestyle="--", label="one element")
    axes.set_ylabel("engineering stress, MPa")
    axes.legend()


def _draw_shear(axes: Axes, report: Report, _: Sequence[MeasuredCurve]) -> None:
    """Shear angle in the centre of a bias coupon, beside that of a trellis with the same centre strain."""
    coupon = report["coupon"]
    trellis = [np.nan if angle is None else angle for angle in coupon["trellis"]["shear_angle_deg"]]
    axes.plot(coupon["strain"], coupon["centre"]["shear_angle_deg"], color=SERIES[0], label="computed")
    axes.plot(coupon["strain"], trellis, color=SERIES[1], linestyle="--", label="trellis")
    axes.set_ylabel("shear angle, deg")
    axes.legend()


def _draw_states(axes: Axes, report: Report, _: Sequence[MeasuredCurve]) -> None:
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
