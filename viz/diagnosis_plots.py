"""Curves of a measurement against the simulation before and after: values above, what is left below.

One panel is one quantity of one channel. The band around a simulated curve is two standard deviations of what it leaves
open (fabric parameters, lattice, the effect's own parameters); the band of the lower axes is two standard deviations of
what noise, scatter and simulation may leave when nothing is missing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from etextile.types import Array
from etextile.units import probability
from viz.legend import finish
from viz.style import DASHES, EDGE, FAINT, QUIET, SERIES, STATES, drawing


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure

BEFORE, AFTER, BEYOND = SERIES[1], SERIES[0], SERIES[2]
HELD_OUT = "#f4f1e6"
HEADING = 0.4
"""Height of the title of several panels, inch."""


LOADS = {"mm": "displacement", "bar": "pressure", "deg": "angle", "1/m": "curvature"}


@dataclass(frozen=True)
class Simulated:
    """A simulated curve (n,) over displacement (n,) mm with its standard deviation (n,)."""

    displacement: Array
    value: Array
    deviation: Array


@dataclass(frozen=True)
class Readings:
    """Measured values (n,) of one specimen over displacement (n,), and measured minus simulated before and after."""

    displacement: Array
    value: Array
    left_before: Array
    left_after: Array | None = None


@dataclass(frozen=True)
class Panel:
    """One quantity; `noise` (n,) is the standard deviation of measured minus simulated over `before.displacement`.

    `held_out`: prediction beyond `split` (mm) by the effect as fitted up to there; `onset`: displacement at which the
    gap begins with its 95 % interval; `load_unit`: mm of displacement or bar of pressure.
    """

    channel: str
    title: str
    unit: str
    readings: tuple[Readings, ...]
    before: Simulated
    noise: Array
    after: Simulated | None = None
    held_out: Simulated | None = None
    onset: tuple[float, float, float] | None = None
    split: float | None = None
    load_unit: str = "mm"


def save_panels(panels: Sequence[Panel], path: Path, *, title: str = "", after_label: str = "") -> Path:
    """Write all panels into one PNG, side by side, and return its path."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    across = 2 if len(panels) == 4 else min(len(panels), 3)
    down = -(-len(panels) // across)
    with drawing():
        height = 5.1 * down + HEADING
        figure = Figure(figsize=(4.5 * across, height), dpi=110)
        FigureCanvasAgg(figure)
        parts = figure.subfigures(down + 1, across, squeeze=False, height_ratios=(HEADING, *[5.1] * down))[1:].ravel()
        for part, panel in zip(parts, panels, strict=False):
            draw_panel(part, panel, after_label=after_label)
        figure.text(0.01, 1.0 - 0.25 * HEADING / height, title, fontsize=12.5, fontweight="bold", va="top")
        return finish(figure, path)


def save_evidence(candidates: Sequence[Mapping[str, Any]], path: Path, *, title: str, most: int = 12) -> Path:
    """Write the probability of every candidate and what it leaves of the held-out gap as PNG, and return its path.

    `candidates`: rows of diagnosis.json, the most probable first.
    """
    with drawing():
        return finish(evidence_figure(candidates[:most], title=title), path)


def evidence_figure(candidates: Sequence[Mapping[str, Any]], *, title: str = "") -> Figure:
    """Return bars of probability and of the held-out gap that is left, one row per candidate."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 0.32 * len(candidates) + 1.4), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=(1.0, 1.0))
    rows = np.arange(len(candidates))
    sure = [float(item["probability"]) for item in candidates]
    rest = [np.nan if item["held_out_percent"] is None else float(item["held_out_percent"]) for item in candidates]
    colours = [AFTER if not item["rejected_because"] else QUIET for item in candidates]
    for axes, values, label, form in (
        (left, sure, "probability that it acts", probability),
        (right, rest, "held-out gap that is left, %", "{:.1f}".format),
    ):
        axes.barh(rows, np.nan_to_num(values), color=colours, height=0.62)
        for row, value in zip(rows, values, strict=True):
            text = form(value) if np.isfinite(value) else "-"
            axes.annotate(
                text, (np.nan_to_num(value), row), xytext=(4, 0), textcoords="offset points", va="center", fontsize=8.5
            )
        axes.set_xlabel(label)
        axes.margins(x=0.16)
        axes.grid(axis="x", color=FAINT, linewidth=0.6)
        axes.set_axisbelow(True)
    left.set_xlim(0.0, 1.15)
    left.set_yticks(rows, [str(item["id"]) for item in candidates])
    left.invert_yaxis()
    figure.suptitle(title, x=0.01, ha="left", fontsize=12.5, fontweight="bold")
    return figure


def panel_figure(panel: Panel, *, after_label: str = "") -> Figure:
    """Return a figure of one panel; use it within `viz.style.drawing`."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.4, 4.9))
    draw_panel(figure, panel, after_label=after_label)
    return figure


def draw_panel(figure: Figure | SubFigure, panel: Panel, *, after_label: str = "") -> None:
    """Draw values above and what is left below, over one displacement axis."""
    # fixed margins: a layout that measures every label takes seconds
    grid = figure.add_gridspec(
        2, 1, height_ratios=(3.0, 1.7), left=0.205, right=0.975, bottom=0.1, top=0.95, hspace=0.07
    )
    above = figure.add_subplot(grid[0])
    below = figure.add_subplot(grid[1], sharex=above)
    for axes in (above, below):
        axes.grid(color=FAINT, linewidth=0.6)
        axes.set_axisbelow(True)
    _draw_values(above, panel, after_label or "with the effect")
    _draw_left(below, panel)
    _mark(above, below, panel)
    above.tick_params(labelbottom=False)
    above.set_ylabel(_with_unit(panel.title, panel.unit))
    below.set_ylabel(_with_unit("difference", panel.unit))
    below.set_xlabel(f"{LOADS[panel.load_unit]}, {panel.load_unit}")
    end = max(float(panel.before.displacement[-1]), *(float(item.displacement[-1]) for item in panel.readings))
    above.set_xlim(0.0, end * 1.01)
    for axes in (above, below):
        axes.yaxis.set_label_coords(-0.19, 0.5)


def _with_unit(text: str, unit: str) -> str:
    return f"{text}, {unit}" if unit else text


def _draw_values(axes: Axes, panel: Panel, after_label: str) -> None:
    """Readings as small dots, the simulated curves with their bands."""
    for number, item in enumerate(panel.readings):
        axes.plot(
            item.displacement, item.value, linestyle="none", marker="o", markersize=3.4, color=EDGE, alpha=0.5,
            markeredgewidth=0, label="measured" if number == 0 else None, zorder=2,
        )  # fmt: skip
    curves = [(panel.before, BEFORE, DASHES[1], "simulated")]
    if panel.after is not None:
        curves.append((panel.after, AFTER, DASHES[0], after_label))
    if panel.held_out is not None:
        curves.append((panel.held_out, BEYOND, DASHES[3], "predicted, held out"))
    for curve, colour, dash, label in curves:
        low, high = curve.value - 2.0 * curve.deviation, curve.value + 2.0 * curve.deviation
        if np.any(high > low):
            axes.fill_between(curve.displacement, low, high, color=colour, alpha=0.16, linewidth=0, zorder=3)
        axes.plot(curve.displacement, curve.value, color=colour, linestyle=dash, linewidth=1.6, label=label, zorder=4)
    falls = panel.before.value[-1] < panel.before.value[0]
    axes.legend(loc="lower left" if falls else "upper left", fontsize=8.5)


def _draw_left(axes: Axes, panel: Panel) -> None:
    """Differences before and after, with what noise alone may leave."""
    x = panel.before.displacement
    axes.fill_between(x, -2.0 * panel.noise, 2.0 * panel.noise, color=QUIET, alpha=0.18, linewidth=0)
    axes.axhline(0.0, color=EDGE, linewidth=0.8)
    for item in panel.readings:
        axes.plot(
            item.displacement, item.left_before, linestyle="none", marker="o", markersize=3.2, markeredgewidth=0.8,
            markerfacecolor="none", markeredgecolor=BEFORE,
        )  # fmt: skip
        if item.left_after is not None:
            axes.plot(
                item.displacement, item.left_after, linestyle="none", marker="o", markersize=3.0, markeredgewidth=0,
                color=AFTER,
            )  # fmt: skip


def _mark(above: Axes, below: Axes, panel: Panel) -> None:
    """Mark the onset with its interval and the held-out part."""
    for axes in (above, below):
        if panel.onset is not None:
            at, low, high = panel.onset
            axes.axvspan(low, high, color=STATES[1].colour, alpha=0.25, linewidth=0, zorder=1)
            axes.axvline(at, color=STATES[1].colour, linewidth=1.2, zorder=1)
        if panel.split is not None:
            axes.axvspan(panel.split, axes.get_xlim()[1] + 1e3, color=HELD_OUT, linewidth=0, zorder=0)
    if panel.onset is not None:
        _name(above, panel.onset[0], "onset")
    if panel.split is not None:
        _name(above, panel.split, "held out", right=True)


def _name(axes: Axes, x: float, text: str, *, right: bool = False) -> None:
    """Write a word on top of the frame, beside x."""
    axes.annotate(
        text, (x, 1.0), xycoords=("data", "axes fraction"), xytext=(1 if right else -1, 2),
        textcoords="offset points", ha="left" if right else "right", va="bottom", fontsize=8, color=QUIET,
    )  # fmt: skip
