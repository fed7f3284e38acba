"""The page of a sizing, from its data alone: what was found in words, where how much slack is needed, every loop."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from viz.charts import data_address
from viz.html import environment, state_styles
from viz.style import BODY, FAINT, QUIET, SERIES, STRAIN_RAMP, TEXT, drawing
from wires.sizing_words import sentences


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Data = Mapping[str, Any]


def render_sizing_html(data: Data) -> str:
    """Return the page; `data` as in loop_sizes.json."""
    found = data["verified"]
    met = data["slack_for_all"] is not None and (found is None or found["met"])
    barely = met and found is not None and not found["surely_met"]
    held = data["verdict"]["withheld"]
    rows = sorted(data["loops"], key=lambda row: -row["span_strain"])
    return (
        environment()
        .get_template("sizing.html.j2")
        .render(
            data=data,
            tone="withheld" if held or barely else "good" if met else "bad",
            label="Verdict withheld"
            if held
            else "Enough slack, but not surely"
            if barely
            else "Enough slack"
            if met
            else "No slack is enough",
            sentences=list(sentences(data)),
            states=state_styles(),
            charts=[
                {"source": _svg(_map(data)), "caption": "Slack that each loop needs, on the undeformed fabric"},
                {"source": _svg(_sizes(data)), "caption": "Slack that each loop needs over the strain under it"},
            ],
            rows=rows,
        )
    )


def _svg(figure: Figure) -> str:
    """Return a figure as an SVG data address; the same figure gives the same bytes."""
    from matplotlib import rc_context

    buffer = io.BytesIO()
    with drawing(), rc_context({"svg.fonttype": "path"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return data_address(buffer.getvalue(), "image/svg+xml")


def _figure() -> tuple[Figure, Axes]:
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.4, 4.3), layout="constrained")
    FigureCanvasSVG(figure)
    axes = figure.add_subplot()
    axes.grid(color=FAINT, linewidth=0.6)
    axes.set_axisbelow(True)
    return figure, axes


def _map(data: Data) -> Figure:
    """Draw the loops where they lie, coloured by the slack they need; crosses where none is enough."""
    from matplotlib.colors import LinearSegmentedColormap

    with drawing():
        figure, axes = _figure()
        rows = data["loops"]
        warp, weft = (np.array([row[name] for row in rows]) for name in ("warp_mm", "weft_mm"))
        slack = np.array([np.nan if row["slack"] is None else row["slack"] for row in rows])
        there = np.isfinite(slack)
        colours = LinearSegmentedColormap.from_list("slack", STRAIN_RAMP)
        if there.any():
            drawn = axes.scatter(warp[there], weft[there], c=100 * slack[there], cmap=colours, vmin=0.0, s=46,
                                 edgecolors=TEXT, linewidths=0.5)  # fmt: skip
            figure.colorbar(drawn, ax=axes, label="slack, %")
        if not there.all():
            axes.plot(warp[~there], weft[~there], "x", color=SERIES[1], label="no slack is enough")
            figure.legend(loc="outside lower center")
        axes.set_aspect("equal")
        axes.margins(0.08)
        axes.set_xlabel("warp, mm")
        axes.set_ylabel("weft, mm")
    return figure


def _sizes(data: Data) -> Figure:
    """Draw slack needed and present over the strain of the fabric under each loop."""
    with drawing():
        figure, axes = _figure()
        rows = data["loops"]
        strain = np.array([row["span_strain"] for row in rows])
        needed = np.array([np.nan if row["slack"] is None else row["slack"] for row in rows])
        axes.plot(
            strain, 100 * np.array([row["slack_now"] for row in rows]), "o", color=BODY, markersize=4, label="now"
        )
        axes.plot(strain, 100 * needed, "o", color=SERIES[0], markersize=4.5, label="needed")
        if data["slack_for_all"] is not None:
            axes.axhline(100 * data["slack_for_all"], color=QUIET, linewidth=1.0, linestyle="--", label="one for all")
        axes.set_ylim(bottom=0.0)
        axes.set_xlabel("greatest strain of the fabric under the loop [-]")
        axes.set_ylabel("slack, %")
        figure.legend(loc="outside upper left", ncols=3)
    return figure
