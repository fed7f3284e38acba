"""A measured field of motion beside the computed one: profiles through the middle, and what is left of the height."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from etextile.files import replacing
from etextile.types import Array
from viz.style import EDGE, FAINT, SERIES, drawing


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import PathCollection

DPI = 150
LOADS = (0.0, 0.5, 1.0)
"""Places among the loads of which profiles are drawn."""
STRIP = 0.06
"""Half width of the strip whose points make a profile, as a share of the extent."""
MOST = 4


@dataclass(frozen=True)
class DrawnField:
    """One specimen: name, load (n,), places (n, 2) mm from the centre, measured and computed motion (n, 3) mm."""

    name: str
    load: Array
    places: Array
    measured: Array
    computed: Array


def save_fields(path: Path, fields: Sequence[DrawnField], *, title: str, load_unit: str) -> None:
    """Write a picture with a column per specimen (the first few): profiles along the warp above, what is left below."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    shown = fields[:MOST]
    with drawing():
        figure = Figure(figsize=(3.6 * len(shown) + 0.8, 6.4), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.subplots(2, len(shown), squeeze=False, height_ratios=[1.0, 1.25])
        largest = max(float(np.abs(_left(item)[1]).max()) for item in shown)
        for column, item in enumerate(shown):
            _profiles(grid[0, column], item, load_unit)
            drawn = _map(grid[1, column], item, largest)
        label = "height computed - measured, mm"
        figure.colorbar(drawn, ax=grid[1, :].tolist(), label=label, shrink=0.8)
        grid[0, 0].set_ylabel("height, mm")
        grid[1, 0].set_ylabel("weft, mm")
        figure.suptitle(title, fontsize=11, fontweight="bold", x=0.01, ha="left")
        with replacing(path) as part:
            figure.savefig(part, dpi=DPI)


def _profiles(axes: Axes, item: DrawnField, load_unit: str) -> None:
    """Draw heights along the warp through the middle at a few loads, measured as dots."""
    loads = np.unique(item.load)
    middle = np.abs(item.places[:, 1]) < STRIP * float(np.ptp(item.places[:, 1]))
    for number, share in enumerate(LOADS):
        load = loads[round(share * (len(loads) - 1))]
        own = np.flatnonzero(middle & (item.load == load))
        own = own[np.argsort(item.places[own, 0])]
        colour = SERIES[number % len(SERIES)]
        axes.plot(item.places[own, 0], item.measured[own, 2], "o", markersize=3, color=colour,
                  label=f"{load:.3g} {load_unit}")  # fmt: skip
        axes.plot(item.places[own, 0], item.computed[own, 2], color=EDGE, linewidth=1.0)
    axes.set_title(item.name, fontsize=10)
    axes.grid(color=FAINT, linewidth=0.6)
    axes.legend(fontsize=7, loc="lower center")


def _left(item: DrawnField) -> tuple[Array, Array]:
    """Return places (m, 2) and computed less measured height (m,) at the last load."""
    own = item.load == item.load.max()
    return item.places[own], (item.computed - item.measured)[own, 2]


def _map(axes: Axes, item: DrawnField, largest: float) -> PathCollection:
    """Draw what is left of the height over the piece."""
    places, left = _left(item)
    axes.set_aspect("equal")
    axes.set_xlabel("warp, mm")
    return axes.scatter(
        places[:, 0], places[:, 1], c=left, cmap="PuOr", vmin=-largest, vmax=largest, s=16, marker="s", linewidths=0
    )
