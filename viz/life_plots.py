"""The probability plot of lives: share failed over cycles, on axes where a Weibull distribution is a straight line."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle as in_turn
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from etextile.files import replacing
from etextile.life.curve import SurvivalCurve
from etextile.life.fit import WEIBULL, LifeFit
from etextile.life.lives import Lives
from etextile.types import Array
from viz.style import DASHES, FAINT, QUIET, SERIES, drawing, plain_decades
from wires.wording import cycles


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 150
SHARES = np.array([0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.14, 0.2, 0.28, 0.38, 0.5, 0.632, 0.75, 0.85, 0.93, 0.97, 0.99])
TICKS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 0.9, 0.99)
MARKERS = "os^DvP"


def save_lives(
    fits: Mapping[str, LifeFit | None],
    curves: Mapping[str, SurvivalCurve | str],
    lives: Mapping[str, Lives],
    *,
    required: float | None,
    confidence: float,
    path: Path,
) -> Path:
    """Write the figure as PNG and return its path; all mappings go by area."""
    with drawing(), replacing(path) as part:
        life_figure(fits, curves, lives, required=required, confidence=confidence).savefig(part, dpi=DPI)
    return path


def life_figure(
    fits: Mapping[str, LifeFit | None],
    curves: Mapping[str, SurvivalCurve | str],
    lives: Mapping[str, Lives],
    *,
    required: float | None,
    confidence: float,
) -> Figure:
    """Draw per area the fit as a line with its bounds, the curve without a distribution as points, B10 as a bar."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.6, 5.2), layout="constrained")
    axes = figure.add_subplot()
    for (area, found), colour, dash, marker in zip(
        fits.items(), in_turn(SERIES), in_turn(DASHES), in_turn(MARKERS), strict=False
    ):
        if found is not None:
            _line(axes, found, confidence, area=area, colour=colour, dash=dash)
        _points(axes, curves[area], lives[area], label=area if found is None else None, colour=colour, marker=marker)
    _frame(axes, required)
    figure.suptitle(
        f"Share failed over cycles; bands and bars: {100 * confidence:g} % by the likelihood ratio",
        x=0.01, ha="left", fontsize=11, fontweight="bold",
    )  # fmt: skip
    return figure


def straight(share: Array) -> Array:
    """Return ln(-ln(1 - F)), over which ln t is a straight line for a Weibull distribution."""
    return np.asarray(np.log(-np.log1p(-share)))


def _line(axes: Axes, found: LifeFit, confidence: float, *, area: str, colour: str, dash: object) -> None:
    middle = np.array([found.quantile(float(share)) for share in SHARES])
    axes.plot(middle, straight(SHARES), color=colour, linestyle=dash, label=f"{area}: {_words(found)}")
    bounds = [found.quantile_bounds(float(share), confidence) for share in SHARES]
    low, high = (np.array([getattr(item, end) for item in bounds]) for end in ("low", "high"))
    sound = np.isfinite(high) & (low > 0.0)
    axes.fill_betweenx(straight(SHARES)[sound], low[sound], high[sound], color=colour, alpha=0.12, linewidth=0)
    tenth = bounds[int(np.argmin(np.abs(SHARES - 0.1)))]
    if np.isfinite(tenth.high):
        axes.plot([tenth.low, tenth.high], straight(np.array([0.1, 0.1])), color=colour, linewidth=3, alpha=0.7)


def _words(found: LifeFit) -> str:
    b10 = f"B10 {cycles(found.quantile(0.1))}"
    if found.family is WEIBULL:
        return f"Weibull, shape {1.0 / found.sigma:.2f}, {b10}"
    return f"lognormal, sigma {found.sigma:.2f}, {b10}"


def _points(
    axes: Axes, curve: SurvivalCurve | str, lives: Lives, *, label: str | None, colour: str, marker: str
) -> None:
    """Draw the shares failed at the cycles of failures; lives that go on as ticks at the lower edge."""
    if not isinstance(curve, str):
        failed = 1.0 - curve.survival
        steps = np.diff(np.concatenate([[0.0], failed])) > 0.0
        # the middle of a step, as probability plots are read; the last one of a complete sample lies at 1 otherwise
        middle = failed - 0.5 * np.diff(np.concatenate([[0.0], failed]))
        shown = steps & (middle > 0.0) & (middle < 1.0)
        axes.plot(
            curve.cycles[shown], straight(middle[shown]), marker, color=colour, markersize=5,
            markerfacecolor="none", label=label if label is None else f"{label}: no fit",
        )  # fmt: skip
    going = lives.low[~lives.failed]
    going = going[going > 0.0]
    axes.plot(going, np.full(len(going), 0.015), "|", color=colour, transform=axes.get_xaxis_transform(), markersize=9)


def _frame(axes: Axes, required: float | None) -> None:
    axes.set_xscale("log")
    plain_decades(axes.xaxis)
    if required is not None:
        axes.axvline(required, color=QUIET, linestyle=":", linewidth=1.4, label=f"required: {cycles(required)}")
    axes.set_ylim(*straight(np.array([0.008, 0.993])).tolist())
    axes.set_yticks(straight(np.array(TICKS)), [f"{100 * share:g} %" for share in TICKS])
    axes.set_xlabel("cycles (ticks at the lower edge: lives that go on)")
    axes.set_ylabel("share failed")
    axes.grid(visible=True, which="both", color=FAINT, linewidth=0.6)
    axes.set_axisbelow(True)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper left", fontsize=8.5, frameon=True, framealpha=0.9, edgecolor=FAINT)
