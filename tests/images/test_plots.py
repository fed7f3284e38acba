"""Curves: what is drawn is what was given, and trouble is marked."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from viz import plots, style


def test_curves_of_a_plot_keep_their_data_and_names(tmp_path: Path) -> None:
    x = np.arange(4.0)
    with style.drawing():
        _, axes = plots.frame("x [mm]", "y [N]", title="t", size=(400, 300))
        band = np.column_stack([x - 1.0, x + 1.0])
        plots.draw_curves(axes, [plots.Curve(x, 2 * x, "model", band), plots.Curve(x, x, "test", dots=True)])
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), 2 * x)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["model", "test"]
    assert axes.get_xlabel() == "x [mm]"
    curves = [plots.Curve(x, x)]
    path = plots.line_plot(
        curves, tmp_path / "a.png", x_label="x", y_label="y", events=[plots.Event(1.0, "e")], size=(400, 300)
    )
    with Image.open(path) as picture:
        assert picture.size == (400, 300)


def test_drawing_leaves_the_settings_of_matplotlib_alone() -> None:
    import matplotlib as mpl

    before = mpl.rcParams["axes.spines.top"]
    with style.drawing():
        assert mpl.rcParams["axes.spines.top"] is False
    assert mpl.rcParams["axes.spines.top"] == before


@pytest.mark.parametrize(("value", "wanted"), [(0.0, 0.01), (0.31, 0.4), (1.0, 1.0), (37.1, 40.0), (101.0, 120.0)])
def test_scales_end_at_round_numbers(value: float, wanted: float) -> None:
    assert style.round_up(value) == pytest.approx(wanted)
