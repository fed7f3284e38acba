"""Curves: force over displacement with the solver's verdicts, strain histories of the loops, and a plain line plot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from etextile.types import Array
from viz import style
from viz.legend import finish, fit_title


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE = (1200, 800)
TITLE_ROOM = 0.8
"""Width that the title of a plot has, as a part of the figure: the rest is the labels of axes and scale."""


@dataclass(frozen=True)
class Curve:
    """A line (n,) over (n,) with its name; `band` (n, 2) shades a range from low to high; `dots` draws points only."""

    x: Array
    y: Array
    label: str = ""
    band: Array | None = None
    dots: bool = False


@dataclass(frozen=True)
class Event:
    """Something that happened at x, marked by a thin upright line with its name."""

    x: float
    label: str


def line_plot(
    curves: Sequence[Curve],
    path: Path,
    *,
    x_label: str,
    y_label: str,
    title: str = "",
    events: Sequence[Event] = (),
    size: tuple[int, int] = SIZE,
) -> Path:
    """Draw curves in one frame, told apart by colour and line style; labels carry units; return the PNG's path."""
    with style.drawing():
        figure, axes = frame(x_label, y_label, title=title, size=size)
        draw_curves(axes, curves)
        draw_events(axes, events)
        legend_below(figure, axes)
        return finish(figure, path)


def legend_below(figure: Figure, axes: Axes) -> None:
    """Put the legend, if there is anything to name, below the axes, where it hides no curve, no zero and no title."""
    old = axes.get_legend()
    if old is not None:
        old.remove()
    if any(axes.get_legend_handles_labels()[1]):
        figure.legend(loc="outside lower center", ncols=2)


def frame(x_label: str, y_label: str, *, title: str, size: tuple[int, int]) -> tuple[Figure, Axes]:
    """Return a figure of a size in pixels with one pair of axes; use it within `style.drawing`."""
    from matplotlib.figure import Figure

    dpi = size[0] / 8.0
    figure = Figure(figsize=(size[0] / dpi, size[1] / dpi), dpi=dpi, layout="constrained")
    axes = figure.add_subplot()
    axes.set(xlabel=x_label, ylabel=y_label)
    fit_title(axes.set_title(title), room=TITLE_ROOM * size[0])
    axes.grid(visible=True)
    axes.set_axisbelow(True)
    return figure, axes


def draw_curves(axes: Axes, curves: Sequence[Curve]) -> None:
    """Add curves to axes, with a legend when they have names."""
    for number, curve in enumerate(curves):
        colour = style.SERIES[number % len(style.SERIES)]
        if curve.band is not None:
            axes.fill_between(curve.x, curve.band[:, 0], curve.band[:, 1], color=colour, alpha=0.2, linewidth=0)
        line = "none" if curve.dots else style.DASHES[number % len(style.DASHES)]
        marker = "o" if curve.dots else "none"
        axes.plot(
            curve.x,
            curve.y,
            color=colour,
            linestyle=line,
            marker=marker,
            markersize=4,
            linewidth=1.8,
            label=curve.label,
        )
    _legend(axes)


def draw_events(axes: Axes, events: Sequence[Event]) -> None:
    """Mark events by thin upright lines, named along them."""
    for event in events:
        axes.axvline(event.x, color=style.QUIET, linewidth=1.0, linestyle=style.DASHES[3])
        axes.annotate(
            event.label,
            (event.x, 0.98),
            xycoords=("data", "axes fraction"),
            xytext=(-3, 0),
            textcoords="offset points",
            rotation=90,
            ha="right",
            va="top",
            fontsize=8.5,
            color=style.QUIET,
        )


def _legend(axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    named = [(handle, label) for handle, label in zip(handles, labels, strict=True) if label]
    if named:
        axes.legend(*zip(*named, strict=True), loc="upper left")
