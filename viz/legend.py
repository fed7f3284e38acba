"""The parts that all maps share: sheet, markers of the loops, legend of states, colour bar, caption."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from etextile.files import replacing
from etextile.types import Array, IntArray
from viz import style
from viz.scene import Scene
from wires.trust import as_provisional


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure
    from matplotlib.text import Text

_WIDTH_INCH = 10.0
TITLE_POINTS = (9.0, 14.0)
"""Sizes of a sheet's title: the smallest for long ones, the usual."""
TWO_LINES = 0.75
"""Size of a title in two lines over that of one, at most."""
_SMALLEST_MARKER = 5.0


def sheet(size: tuple[int, int], title: str) -> Figure:
    """Return an empty figure of a size in pixels, with a title; text keeps its size relative to the picture."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    dpi = size[0] / _WIDTH_INCH
    figure = Figure(figsize=(size[0] / dpi, size[1] / dpi), dpi=dpi)
    FigureCanvasAgg(figure)
    fit_title(
        figure.text(0.02, 0.965, title, fontsize=TITLE_POINTS[1], fontweight="bold", va="top"), room=0.96 * size[0]
    )
    return figure


def fit_title(text: Text, *, room: float) -> None:
    """Make a title fit into `room` pixels: in one line, else in two smaller ones, of which the second ends in dots."""
    whole, wide = text.get_text(), text.get_window_extent().width
    smallest, usual = TITLE_POINTS[0], float(text.get_fontsize())
    if wide <= room:
        return
    size = max(smallest, min(TWO_LINES * usual, 1.9 * usual * room / wide))
    text.set_fontsize(size)

    def fits(words: str) -> bool:
        text.set_text(words)
        return bool(text.get_window_extent().width <= room)

    upper = _longest(whole, fits)
    lower = whole[len(upper) :].lstrip()
    if not fits(lower):
        lower = _longest(lower, lambda words: fits(f"{words}…")).rstrip() + "…"
    text.set(text=f"{upper.rstrip()}\n{lower}", linespacing=1.15)


def _longest(words: str, fits: Callable[[str], bool]) -> str:
    """Return the longest beginning that fits, up to a space where there is one."""
    low, high = 1, len(words)
    while low < high:
        middle = (low + high + 1) // 2
        low, high = (middle, high) if fits(words[:middle]) else (low, middle - 1)
    space = words.rfind(" ", 0, low + 1)
    return words[: space if low < len(words) and space > 0 else low]


def loop_markers(axes: Axes, places: Array, state: IntArray, *, size: float, hollow: bool = False) -> None:
    """Draw loops (L, 2) with the marker and colour of their state, the worse on top of the better.

    `state` as `Loops.shown`: one more than the states there are is undetermined.
    """
    for number, look in enumerate((*style.STATES, style.FOLDED)):
        chosen = state == number
        axes.plot(
            *places[chosen].T,
            linestyle="none",
            marker=look.marker,
            markersize=size * look.scale,
            markerfacecolor="none" if hollow else look.colour,
            markeredgecolor=style.outline(look),
            markeredgewidth=min(0.1 * size, 0.9),
            zorder=9 if look is style.FOLDED else 10 + number,
            clip_on=False,
        )


def marker_size(pixels: Array, *, dpi: float, largest: float) -> float:
    """Return a marker size in points that keeps markers at these pixels (L, 2) apart if it can, at most `largest`."""
    from scipy.spatial import cKDTree

    if len(pixels) < 2:
        return largest
    gap = np.median(cKDTree(pixels).query(pixels, k=2)[0][:, 1])
    return float(min(max(0.7 * gap * 72.0 / dpi, _SMALLEST_MARKER), largest))


def state_legend(figure: Figure, state: IntArray, *, place: tuple[float, float]) -> None:
    """List the states with their markers and how many loops are in each, then what the lines mean."""
    from matplotlib.lines import Line2D

    entries: list[Line2D] = [
        Line2D(
            [],
            [],
            linestyle="none",
            marker=look.marker,
            markersize=9.0 * look.scale,
            markerfacecolor=look.colour,
            markeredgecolor=style.outline(look),
            markeredgewidth=0.9,
            label=f"{look.label.partition(':')[0]} ({np.count_nonzero(state == number)})",
        )
        for number, look in enumerate((*style.STATES, style.FOLDED))
        if number < len(style.STATES) or (state == number).any()
    ]
    legend = figure.legend(
        handles=entries,
        loc="upper left",
        bbox_to_anchor=place,
        title=f"State of the loops ({len(state)})",
        alignment="left",
        handletextpad=0.5,
        labelspacing=0.7,
        borderaxespad=0.0,
    )
    legend.get_title().set_fontweight("bold")


def titled(what: str, title: str, *, provisional: bool = False) -> str:
    """Return the heading of a map: what it shows, whether that is provisional, and of which case."""
    what = as_provisional(what, passed=provisional)
    return f"{what}: {title}" if title else what


def line_legend(
    figure: Figure,
    *,
    place: tuple[float, float],
    by_state: bool,
    body: bool,
    clamps: bool,
    wires: bool = True,
    worn: bool = False,
) -> None:
    """Say what the lines of a deformed map mean."""
    from matplotlib.lines import Line2D

    look = (style.SOUND_WIRE, "wire, by its state") if by_state else (style.WIRE, "wire")
    entries = [Line2D([], [], color=look[0], linewidth=2.5, label=look[1])] if wires else []
    if body:
        entries.append(
            Line2D(
                [],
                [],
                color=style.EDGE,
                linewidth=0.9,
                linestyle=(0, (4, 3)),
                label="limb" if worn else "body underneath",
            )
        )
    if clamps:
        entries.append(Line2D([], [], color=style.CLAMP, linewidth=5.0, label="held end" if worn else "clamp"))
    figure.legend(handles=entries, loc="upper left", bbox_to_anchor=place, borderaxespad=0.0, labelspacing=0.6)


def colour_bar(figure: Figure, scale: Normalize, label: str, *, place: tuple[float, float, float, float]) -> Axes:
    """Draw the colour scale with its unit."""
    from matplotlib.cm import ScalarMappable

    axes = figure.add_axes(place)
    figure.colorbar(ScalarMappable(scale, style.strain_colours()), cax=axes)
    axes.set_title(label, fontsize=10, pad=8)
    axes.tick_params(length=3)
    return axes


def flat_legend(
    figure: Figure, *, place: tuple[float, float], touched: bool, clamps: bool, folded: bool = False, worn: bool = False
) -> None:
    """Say what lines and areas of a flat map mean."""
    from matplotlib.artist import Artist
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    entries: list[Artist] = [Line2D([], [], color=style.SOUND_WIRE, linewidth=1.4, label="wire, by its state")]
    if touched:
        entries.append(
            Patch(
                facecolor=style.CONTACT,
                edgecolor=style.QUIET,
                linewidth=0.5,
                label="touches the skin" if worn else "touches the body",
            )
        )
    if folded:
        entries.append(Patch(facecolor="white", edgecolor=style.QUIET, hatch="....", label="in folds: undetermined"))
    if clamps:
        entries.append(
            Patch(facecolor="white", edgecolor=style.CLAMP, hatch="//////", label="held end" if worn else "clamp")
        )
    figure.legend(handles=entries, loc="upper left", bbox_to_anchor=place, borderaxespad=0.0, labelspacing=0.6)


def caption(figure: Figure, scene: Scene, *, largest: str = "") -> None:
    """Say at the foot which moment is shown, the largest value, and that a model was mirrored."""
    colouring = scene.colouring
    parts = [
        scene.moment,
        largest or f"Largest {colouring.label} {colouring.peak:.3g} {colouring.unit}.",
    ]
    if scene.mirrored:
        parts.append(f"A {scene.portion} was modelled and is mirrored here.")
    figure.text(0.02, 0.03, "  ".join(parts), fontsize=9.5, color=style.QUIET, va="bottom", wrap=True)


def finish(figure: Figure, path: Path) -> Path:
    """Write the PNG without anything that changes from run to run, and return its path."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    with style.drawing(), replacing(path) as part:
        figure.savefig(part, format="png", metadata={"Software": "etextile"}, pil_kwargs={"compress_level": 3})
    return path
