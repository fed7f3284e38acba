"""Curves: what is drawn is what was given, and trouble is marked."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

from viz import plots, style


def holds(path: Path, colour: str) -> bool:
    wanted = np.round(255 * np.array(to_rgb(colour))).astype(np.int16)
    with Image.open(path) as picture:
        pixels = np.asarray(picture.convert("RGB"), dtype=np.int16)
    return bool(np.any(np.abs(pixels - wanted).max(axis=-1) <= 1))


@pytest.mark.parametrize("failed", [False, True])
def test_increments_that_did_not_converge_are_marked(tmp_path: Path, failed: bool) -> None:
    displacement = np.linspace(0.0, 50.0, 11)
    converged = np.ones(11, dtype=bool)
    converged[7] = not failed
    path = plots.force_displacement(displacement, displacement**2, tmp_path / "force.png", converged=converged)
    assert holds(path, style.SERIES[0])
    assert holds(path, style.STATES[2].colour) is failed


def test_loop_histories_end_in_the_marker_of_the_state_and_show_the_onset(tmp_path: Path) -> None:
    displacement, strain = np.array([0.0, 10.0]), np.array([[0.0, 0.0], [0.05, 0.15]])
    path = plots.loop_histories(
        displacement, strain, np.array([1, 3]), tmp_path / "loops.png", onset=0.07, labels=["wire 0", "wire 1"]
    )
    assert holds(path, style.STATES[1].colour)
    assert holds(path, style.STATES[3].colour)
    assert holds(path, style.STATES[2].colour)


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
