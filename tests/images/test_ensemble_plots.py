"""Pictures of ensembles: probabilities at the right places in the right colours, mirrored to the whole specimen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from etextile.lattice.piece import divide, weave_piece
from etextile.lattice.weave import Weave
from viz import ensemble_plots as plots
from viz import style
from viz.plots import Curve
from viz.scene import Scene
from wires.layout import WireLayout, lay_out


LATTICE = weave_piece(
    (WEAVE := Weave(0.2849, 0.1603, 0.35, 0.0155, warp_density=11.0, weft_density=8.9)),
    divide(WEAVE, (100.0, 100.0), 39.0, "quarter"),
)


@pytest.fixture(scope="module")
def layout() -> WireLayout:
    return lay_out(
        length_mm=100.0, width_mm=100.0, portion="quarter", wire_spacing_mm=20.0, loop_spacing_mm=20.0,
        loop_length_mm=4.0, loop_slack=0.02,
    )  # fmt: skip


@pytest.fixture(scope="module")
def specimen(layout: WireLayout) -> Scene:
    return plots.specimen_scene(LATTICE, layout, LATTICE.edges["x_max"], portion="quarter")


def test_every_loop_has_the_colour_of_its_probability_on_all_four_quarters(specimen: Scene, layout: WireLayout) -> None:
    probability = np.linspace(0.0, 1.0, layout.n_loops)
    figure = plots.probability_figure(specimen, probability, np.full(layout.n_wires, 0.5), what="", remark="")
    canvas = figure.canvas
    assert isinstance(canvas, FigureCanvasAgg)
    canvas.draw()
    image = np.asarray(canvas.buffer_rgba())[:, :, :3] / 255.0
    transform = figure.axes[0].transData
    for loop, value in enumerate(probability):
        wanted = style.probability_colours()(value)[:3]
        for x in {1.0, -1.0}:
            for y in {1.0, -1.0}:
                place = (x * layout.loop_warp_mm[loop], y * layout.loop_weft_mm[loop])
                column, row = np.round(transform.transform(place)).astype(int)
                assert image[image.shape[0] - 1 - row, column] == pytest.approx(wanted, abs=0.02)


def test_probability_rises_evenly_from_light_to_dark() -> None:
    ramp = style.probability_colours()(np.linspace(0.0, 1.0, 21))[:, :3]
    lightness = np.array([style.luminance(tuple(colour)) for colour in ramp])
    assert (np.diff(lightness) < 0.0).all()
    assert np.diff(lightness) == pytest.approx(np.mean(np.diff(lightness)), rel=0.5)


def test_curves_bars_and_rows_are_drawn(tmp_path: Path) -> None:
    x = np.linspace(0.0, 10.0, 6)
    rise = np.linspace(0.0, 1.0, 6)
    band = np.column_stack([0.9 * rise, np.minimum(1.1 * rise, 1.0)])
    bars = [plots.Bar("strength", 0.8, 0.7, 0.9), plots.Bar("slack", 0.0, -0.2, 0.2)]
    paths = [
        plots.fragility([Curve(x, rise, "some wire", band)], tmp_path / "a.png", x_label="displacement [mm]"),
        plots.wire_fragility(x, np.array([0.0]), rise[:, None], tmp_path / "b.png", x_label="displacement [mm]"),
        plots.wire_fragility(
            x, np.arange(60.0), np.outer(rise, np.ones(60)), tmp_path / "c.png", x_label="displacement [mm]"
        ),
        plots.ranking([("broken", bars), ("first break", bars[:1])], tmp_path / "d.png"),
    ]
    for path in paths:
        with Image.open(path) as picture:
            assert min(picture.size) > 300
            assert len(np.unique(np.asarray(picture.convert("L")))) > 20
