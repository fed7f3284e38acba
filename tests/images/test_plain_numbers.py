"""Pictures read no formulas, so the numbers of their axes are plain text, and legends stand beside what they name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from viz import plots
from viz.style import drawing, plain_decades


@pytest.mark.parametrize("ends", [(3e-4, 0.2), (20.0, 90.0), (1e3, 5e6)])
def test_a_logarithmic_axis_has_plain_numbers(ends: tuple[float, float]) -> None:
    with drawing():
        figure = Figure()
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        axes.plot(ends, (1.0, 2.0))
        axes.set_xscale("log")
        plain_decades(axes.xaxis)
        figure.canvas.draw()
        axis = axes.xaxis
        shown = [
            text.get_text() for text in (*axis.get_ticklabels(), *axis.get_ticklabels(minor=True)) if text.get_text()
        ]
    assert shown
    assert not any("$" in text or "math" in text for text in shown)
    assert all(float(text.replace("\u2009", "").replace(" ", "")) > 0.0 for text in shown)


def test_a_legend_hides_no_curve_and_no_zero_line(tmp_path: Path) -> None:
    x = np.linspace(0.0, 50.0, 20)
    with drawing():
        figure, axes = plots.frame("x", "y", title="difference", size=(800, 600))
        FigureCanvasAgg(figure)
        plots.draw_curves(axes, [plots.Curve(x, -0.01 * x, "wires"), plots.Curve(x, 0.0 * x, "nothing")])
        plots.legend_below(figure, axes)
        figure.canvas.draw()
        assert axes.get_legend() is None
        (legend,) = figure.legends
        assert not legend.get_window_extent().overlaps(axes.get_window_extent())
        assert not legend.get_window_extent().overlaps(axes.title.get_window_extent())
