"""Check plot of a calibration: what was measured and what the calibrated case says, and what is left between the two.

A motion of many points is shown by its height, mean over the points of a load, with the range of the points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from etextile.files import replacing
from etextile.types import Array, IntArray
from viz.style import EDGE, FAINT, QUIET, SERIES, drawing


if TYPE_CHECKING:
    from matplotlib.axes import Axes

DPI = 150
LABELS = {
    "punch_force": "force, N",
    "clamp_force": "force, N",
    "pressure_height": "height, mm",
    "joint_moment": "moment, N mm",
    "cyclic_force": "force, N",
    "moment_curvature": "bending moment per width, N m/m",
    "mark_slip": "slip along the skin, mm",
    "displacement_field": "mean height of the points, mm",
}
UNITS = {
    "punch_force": "mm", "clamp_force": "mm", "pressure_height": "bar", "joint_moment": "deg", "mark_slip": "deg",
    "moment_curvature": "1/m", "cyclic_force": "path",
}  # fmt: skip
"""Unit of the load of channels that have but one."""
LOADS = {
    "bar": "pressure, bar", "mm": "displacement, mm", "deg": "angle, deg", "1/m": "curvature, 1/m",
    "g/m**2": "mass per area, g/m2", "path": "way travelled there and back, mm",
}  # fmt: skip
Reading = tuple[Array, Array, Array, IntArray]
"""Load, measured, predicted and number of the specimen, (n,) each; three components in turn for a field."""


def save_check(
    path: Path, *, title: str, load_unit: str, readings: Mapping[str, Reading], specimens: Sequence[str],
    computed: str = "calibrated",
) -> None:  # fmt: skip
    """Write the check plot: a column per channel, values above and what is left below; `computed` names the lines."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with drawing():
        figure = Figure(figsize=(4.6 * len(readings) + 0.4, 5.4), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.subplots(2, len(readings), squeeze=False, sharex="col", height_ratios=[2.0, 1.0])
        for column, (channel, reading) in enumerate(readings.items()):
            _panel(grid[0, column], grid[1, column], channel, reading, specimens=specimens, computed=computed)
            grid[1, column].set_xlabel(LOADS[UNITS.get(channel, load_unit)])
        figure.suptitle(title, fontsize=11, fontweight="bold", x=0.01, ha="left")
        with replacing(path) as part:
            figure.savefig(part, dpi=DPI)


def _panel(
    above: Axes, below: Axes, channel: str, reading: Reading, *, specimens: Sequence[str], computed: str
) -> None:
    """Draw one channel."""
    load, measured, predicted, number = reading
    if channel == "displacement_field":
        load, measured, predicted, number = load[2::3], measured[2::3], predicted[2::3], number[2::3]
    for which in np.unique(number):
        own = number == which
        at = np.unique(load[own])
        rows = [own & (load == value) for value in at]
        colour = SERIES[int(which) % len(SERIES)]
        seen, said = (np.array([values[row].mean() for row in rows]) for values in (measured, predicted))
        above.plot(at, seen, "o", markersize=3.5, color=colour, label=specimens[int(which)])
        above.plot(at, said, color=EDGE, linewidth=1.0)
        left = np.array([(predicted - measured)[row].mean() for row in rows])
        ends = np.array([np.quantile((predicted - measured)[row], (0.1, 0.9)) for row in rows])
        below.plot(at, left, color=colour, linewidth=1.2, marker="o", markersize=2.5)
        if channel == "displacement_field":
            below.fill_between(at, ends[:, 0], ends[:, 1], color=colour, alpha=0.12, linewidth=0.0)
    above.plot([], [], color=EDGE, linewidth=1.0, label=computed)
    above.set_ylabel(LABELS[channel])
    above.legend(fontsize=8)
    below.axhline(0.0, color=QUIET, linewidth=0.8)
    below.set_ylabel("computed - measured")
    for axes in (above, below):
        axes.grid(color=FAINT, linewidth=0.6)
