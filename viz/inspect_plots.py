"""What was read of a measured file or a mesh, drawn: rows that count in colour, rows left out in grey."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from etextile.files import replacing
from etextile.types import Array, BoolArray, IntArray
from viz.style import BODY, FAINT, QUIET, SERIES, STRAIN_RAMP, drawing


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 150
MOST_TRIANGLES = 60_000
"""Triangles that are drawn at most: beyond, every n-th one."""
LIGHT = np.array([-0.35, -0.45, 0.82])
_NAMES = {"mm": "mm", "N": "N", "MPa": "MPa", "bar": "bar"}


def save_rows(path: Path, values: Mapping[str, Array], used: BoolArray, *, title: str, subtitle: str) -> None:
    """Write a picture of a table: load over path for a curve, places coloured by the last quantity for a field.

    values: quantity with unit to numbers (n,); used (n,): rows that count.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with drawing():
        figure = Figure(figsize=(6.6, 4.4), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        across, up = _axes_of(values)
        if across.endswith("0_mm") and up.endswith("0_mm"):
            _field(figure, axes, values, used, across, up)
        else:
            _curve(axes, values, used, across, up)
        axes.set_xlabel(label(across))
        axes.set_ylabel(label(up))
        axes.grid(color=FAINT, linewidth=0.6)
        axes.set_axisbelow(True)
        axes.set_title(title)
        axes.set_title(subtitle.replace("_", " "), loc="right", fontsize=9, color=QUIET, weight="normal")
        with replacing(path) as part:
            figure.savefig(part, dpi=DPI)


def label(name: str) -> str:
    """Return a quantity for people: `force_N` is `force, N`, `warp0_mm` is `warp (undeformed), mm`."""
    stem, mark, unit = name.rpartition("_")
    if not mark or unit not in _NAMES:
        stem, unit = name, ""
    stem = stem.replace("0", " (undeformed)").replace("_", " ")
    return f"{stem}, {unit}" if unit else stem


def _axes_of(values: Mapping[str, Array]) -> tuple[str, str]:
    """Return what is drawn across and upwards: two places, or the first quantity and the last."""
    names = list(values)
    places = [name for name in names if name.endswith("0_mm")]
    return (places[0], places[1]) if len(places) == 2 else (names[0], names[-1])


def _curve(axes: Axes, values: Mapping[str, Array], used: BoolArray, across: str, up: str) -> None:
    x, y = values[across], values[up]
    size = 3.0 if len(x) < 2000 else 1.4
    if not used.all():
        grey = f"{int((~used).sum())} rows " + ("left out" if used.any() else "of a file that is refused")
        axes.plot(x[~used], y[~used], "o", color=BODY, markersize=size, markeredgewidth=0.0, label=grey)
    if used.any():
        axes.plot(x[used], y[used], "o", color=SERIES[0], markersize=size, markeredgewidth=0.0,
                  label=f"{int(used.sum())} rows read")  # fmt: skip
    axes.legend(loc="best", markerscale=2.0)


def _field(figure: Figure, axes: Axes, values: Mapping[str, Array], used: BoolArray, across: str, up: str) -> None:
    """Draw the places of the last load, coloured by the last quantity."""
    from matplotlib.colors import LinearSegmentedColormap

    names = list(values)
    last = used & (values[names[0]] == values[names[0]].max())
    shown = last if last.any() else used | ~used
    colours = LinearSegmentedColormap.from_list("inspect", STRAIN_RAMP[1:])
    drawn = axes.scatter(values[across][shown], values[up][shown], c=values[names[-1]][shown], cmap=colours, s=16,
                         linewidths=0)  # fmt: skip
    axes.set_aspect("equal")
    load, _, unit = label(names[0]).partition(", ")
    at = values[names[0]][shown].max()
    figure.colorbar(drawn, ax=axes, label=f"{label(names[-1])}; at a {load} of {at:.4g} {unit}")


def save_mesh(path: Path, vertices: Array, faces: IntArray, *, title: str) -> None:
    """Write a picture of a mesh from above and from the side (the punch's way is up), mm; a cross marks the top."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with drawing():
        figure = Figure(figsize=(8.4, 4.4), layout="constrained")
        FigureCanvasAgg(figure)
        top = vertices[int(np.argmax(vertices[:, 2]))]
        step = -(-len(faces) // MOST_TRIANGLES)
        for number, (across, up, away, name) in enumerate(((0, 1, 2, "from above"), (0, 2, 1, "from the side"))):
            axes = figure.add_subplot(1, 2, number + 1)
            _triangles(axes, vertices[faces[::step]], across, up, away)
            axes.plot(top[across], top[up], "x", color=SERIES[1], markersize=9, markeredgewidth=1.8)
            axes.set_xlabel(f"{'xyz'[across]}, mm")
            axes.set_ylabel(f"{'xyz'[up]}, mm")
            axes.set_title(name, fontsize=10)
        figure.suptitle(f"{title}; cross: highest point", x=0.01, ha="left", fontsize=11.5, fontweight="bold")
        with replacing(path) as part:
            figure.savefig(part, dpi=DPI)


def _triangles(axes: Axes, corners: Array, across: int, up: int, away: int) -> None:
    """Draw triangles (f, 3, 3) from the far ones to the near ones, shaded by their normal."""
    from matplotlib.collections import PolyCollection

    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    shade = np.abs(normal @ LIGHT) / np.where(length > 0.0, length, 1.0) / np.linalg.norm(LIGHT)
    toward = 1.0 if away == 2 else -1.0
    order = np.argsort(toward * corners[:, :, away].mean(axis=1))
    grey = 0.35 + 0.6 * shade[order]
    colours = np.stack([grey, grey, np.minimum(grey + 0.03, 1.0)], axis=1)
    axes.add_collection(PolyCollection(list(corners[order][:, :, [across, up]]), facecolors=colours, edgecolors=colours,
                                       linewidths=0.2))  # fmt: skip
    axes.set_aspect("equal")
    axes.autoscale_view()
