"""The figure of a refinement: what virtual coupons return with direct and with refined laws, and how far off it is."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from etextile.files import replacing
from etextile.identify.refine import Refined, TargetCurve
from etextile.identify.result import DIRECTION_OF
from etextile.types import Array
from viz.style import EDGE, FAINT, SERIES, drawing


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 150
Runs = tuple[tuple[TargetCurve, Array], tuple[TargetCurve, Array]]
_LINES = (("direct", SERIES[1], "--"), ("refined", SERIES[0], "-"))


def save_refinement(
    targets: Mapping[str, TargetCurve], refined: Refined, *, direct: Mapping[str, tuple[TargetCurve, Array]], path: Path
) -> Path:
    """Write the figure as PNG and return its path."""
    with drawing(), replacing(path) as part:
        refinement_figure(targets, refined, direct=direct).savefig(part, dpi=DPI)
    return path


def refinement_figure(
    targets: Mapping[str, TargetCurve], refined: Refined, *, direct: Mapping[str, tuple[TargetCurve, Array]]
) -> Figure:
    """Draw curves above and departures from the measured curve (%) below, one column per direction.

    `direct`: measured curve as fitted, and relative departure (n,) of the coupon with the laws identified directly.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(3.7 * max(len(targets), 1) + 0.6, 5.0), layout="constrained")
    grid = figure.add_gridspec(2, max(len(targets), 1), height_ratios=(3.0, 1.6))
    for column, (family, target) in enumerate(targets.items()):
        above = figure.add_subplot(grid[0, column])
        below = figure.add_subplot(grid[1, column], sharex=above)
        runs = (direct[family], (target, refined.after[family]))
        _draw_curves(above, runs)
        _draw_departure(below, runs)
        above.set_title(f"{DIRECTION_OF[family]} ({family} trusses)", fontsize=10.5)
        above.tick_params(labelbottom=False)
        below.set_xlabel("nominal strain [-]")
        if column == 0:
            above.set_ylabel("fabric engineering stress [MPa]")
            below.set_ylabel("simulated - measured\n[% of measured]")
            above.legend(loc="upper left", fontsize=8.5)
    figure.suptitle("Virtual coupons with direct and refined laws", x=0.01, ha="left", fontsize=11.5, fontweight="bold")
    return figure


def _draw_curves(axes: Axes, runs: Runs) -> None:
    """Draw the measured curve as fitted, and the stresses of the coupons over their nominal strain."""
    measured = runs[0][0]
    axes.plot(measured.strain, measured.stress, color=EDGE, linewidth=2.6, alpha=0.3, label="measured (as fitted)")
    for (label, colour, dash), (curve, off) in zip(_LINES, runs, strict=True):
        stress = curve.stress * (1.0 + off)
        axes.plot(curve.strain, stress, color=colour, linestyle=dash, linewidth=1.3, label=f"coupon, {label} laws")
    axes.grid(color=FAINT, linewidth=0.6)
    axes.set_axisbelow(True)


def _draw_departure(axes: Axes, runs: Runs) -> None:
    """Draw the departures of the coupons from the measured curve in per cent."""
    axes.axhline(0.0, color=EDGE, linewidth=0.8)
    reach = 2.0
    for (label, colour, dash), (curve, off) in zip(_LINES, runs, strict=True):
        axes.plot(curve.strain, 100.0 * off, color=colour, linestyle=dash, linewidth=1.3, label=label)
        late = curve.strain > 0.1 * curve.strain[-1]
        reach = max(reach, 115.0 * float(np.abs(off[late]).max()))
    axes.set_ylim(-reach, reach)
    axes.grid(color=FAINT, linewidth=0.6)
    axes.set_axisbelow(True)
