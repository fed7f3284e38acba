"""Figures of virtual coupons: departures from single elements by cause, the bias test, a prediction and its error."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from support.departure import RATIOS, Departure
from support.prediction import Prediction

from viz.style import DASHES, EDGE, FAINT, QUIET, SERIES


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BIAS_LINES: dict[str, tuple[str, str, Any]] = {
    "coupon, yarns held": ("coupon, yarns keep their length", SERIES[0], "-"),
    "coupon 0": ("coupon, compression 0", SERIES[1], "--"),
    "coupon 0.001": ("coupon, compression 0.001", SERIES[4], "-."),
    "coupon 0.1": ("coupon, compression 0.1", SERIES[3], (0, (6, 1, 1, 1, 1, 1))),
    "unit cell 0.1": ("unit cell, compression 0.1", SERIES[2], ":"),
}


def yarn_departures(departures: Mapping[str, Departure]) -> Figure:
    """Draw the departures of coupons along warp and weft by cause, one panel each, in % of the single element."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.4 * len(departures) + 0.4, 4.3), layout="constrained")
    for number, (name, found) in enumerate(departures.items()):
        axes = figure.add_subplot(1, len(departures), number + 1)
        percent = 100.0 * found.strain
        for ratio, colour in zip(RATIOS, SERIES, strict=False):
            clamped, sliding = found.coupons[f"clamped {ratio:g}"], found.coupons[f"sliding {ratio:g}"]
            axes.plot(percent, 100.0 * clamped, color=colour, label=f"compression {ratio:g}, clamped")
            axes.plot(percent, 100.0 * sliding, color=colour, linestyle="--", label="  ends slide across")
        axes.plot(percent, 100.0 * found.coupons["width held"], color=EDGE, linestyle=":", label="width held (bound)")
        none = found.coupons["clamped without diagonals"]
        axes.plot(percent, 100.0 * none, color=QUIET, linewidth=0.9, label="no diagonals")
        _finish(axes, name, "nominal strain [%]", "coupon over single element - 1 [%]" if number == 0 else "")
        axes.set_xlim(0.0)
    figure.axes[-1].legend(loc="upper left", fontsize=8.5)
    top = max(axes.get_ylim()[1] for axes in figure.axes)
    for axes in figure.axes:
        axes.set_ylim(-0.2, top)
    _head(figure, "Full coupons against single elements", "difference of dashed and full: what the clamps add")
    return figure


def bias_departure(found: Departure) -> Figure:
    """Draw stress of coupons and unit cell in bias, and their departure from a single diagonal in per cent."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.4, 4.3), layout="constrained")
    left, right = figure.add_subplot(1, 2, 1), figure.add_subplot(1, 2, 2)
    percent = 100.0 * found.strain
    left.plot(percent, found.single, color=EDGE, linewidth=2.6, alpha=0.3, label="single diagonal (direct use)")
    for name, (label, colour, dash) in _BIAS_LINES.items():
        style: dict[str, Any] = {
            "color": colour,
            "linestyle": dash,
            "linewidth": 1.8 if name == "coupon, yarns held" else 1.2,
        }
        left.plot(percent, found.single * (1.0 + found.coupons[name]), label=label, **style)
        right.plot(percent, 100.0 * found.coupons[name], label=label, **style)
    right.axhline(0.0, color=EDGE, linewidth=0.8)
    right.axvline(28.0, color=QUIET, linewidth=0.9, linestyle="--")
    right.annotate("28 %: the paper's curves part", (28.0, -45.0), (-4.0, 0.0), textcoords="offset points", ha="right",
                   fontsize=8.5, color=QUIET)  # fmt: skip
    right.set_ylim(-50.0, 80.0)
    _finish(left, "Bias coupon", "nominal strain [%]", "fabric engineering stress [MPa]")
    _finish(right, "Departure from a single diagonal", "nominal strain [%]", "[%]")
    left.legend(loc="upper left", fontsize=8.5)
    for axes in (left, right):
        axes.set_xlim(0.0)
    return figure


def prediction_figure(predictions: Mapping[int, Prediction], *, predicted: tuple[int, ...]) -> Figure:
    """Draw measured (dots) and simulated curves by angle, and the relative errors; `predicted` angles stand out."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.4, 4.4), layout="constrained")
    left, right = figure.add_subplot(1, 2, 1), figure.add_subplot(1, 2, 2)
    right.axhline(0.0, color=EDGE, linewidth=0.8)
    for (angle, item), colour, dash in zip(predictions.items(), SERIES, DASHES, strict=False):
        strong = angle in predicted
        percent = 100.0 * item.strain
        left.plot(percent, item.measured, "o", color=colour, markersize=2.6, markeredgewidth=0.0, alpha=0.7)
        label = f"{angle} deg, {'predicted' if strong else 'identified from'}"
        style: dict[str, Any] = {
            "color": colour,
            "linestyle": dash,
            "linewidth": 2.2 if strong else 1.1,
            "label": label,
        }
        left.plot(percent, item.predicted, **style)
        late = item.strain > 0.005
        right.plot(percent[late], 100.0 * item.relative_error[late], **style)
    reach = max(
        12.0, *(float(np.abs(100.0 * p.relative_error[p.strain > 0.005]).max()) * 1.1 for p in predictions.values())
    )
    right.set_ylim(-reach, reach)
    _finish(left, "Woven nylon", "nominal strain [%]", "engineering stress [MPa]")
    _finish(right, "Simulated over measured - 1", "nominal strain [%]", "[%]")
    left.text(0.98, 0.03, "dots: measured", transform=left.transAxes, ha="right", fontsize=9, color=QUIET)
    left.legend(loc="upper left", fontsize=9)
    return figure


def _head(figure: Figure, title: str, remark: str) -> None:
    figure.suptitle(title, x=0.01, ha="left", fontsize=11.5, fontweight="bold")
    figure.text(0.99, 0.985, remark, ha="right", va="top", fontsize=9, color=QUIET)


def _finish(axes: Axes, title: str, x: str, y: str) -> None:
    axes.set_title(title, fontsize=10.5)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(color=FAINT, linewidth=0.6)
    axes.set_axisbelow(True)
