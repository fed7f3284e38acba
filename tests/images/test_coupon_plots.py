"""Figures of coupons by their meaning: which curve is where, and a map in which cut cells and zones can be seen."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.coupon_plots import bias_departure, prediction_figure, yarn_departures
from support.departure import Departure
from support.prediction import Prediction, compare

from etextile.identify.curves import TensileCurve
from etextile.identify.refine import Refined, TargetCurve
from etextile.laws.powerlaw import PowerLaw
from viz.refine_plots import refinement_figure, save_refinement
from viz.style import drawing
from viz.surface import boundary, cell_values


STRAIN = np.linspace(0.01, 0.12, 12)


def departure(names: list[str]) -> Departure:
    return Departure(STRAIN, 300.0 * STRAIN, {name: 0.01 * (k + 1) * STRAIN for k, name in enumerate(names)})


def test_departures_are_drawn_in_per_cent_with_their_cause() -> None:
    names = [f"{ends} {ratio}" for ratio in ("0", "0.001", "0.1") for ends in ("clamped", "sliding")]
    found = departure([*names, "width held", "clamped without diagonals"])
    with drawing():
        figure = yarn_departures({"warp": found, "weft": found})
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["warp", "weft"]
    lines = {line.get_label(): line for line in figure.axes[1].get_lines()}
    assert lines["compression 0.001, clamped"].get_ydata()[-1] == pytest.approx(100.0 * 0.03 * 0.12)
    assert lines["width held (bound)"].get_xdata()[-1] == pytest.approx(12.0)
    assert figure.axes[0].get_ylim() == figure.axes[1].get_ylim()


def test_the_bias_figure_has_stress_and_departure_of_every_run() -> None:
    names = ["coupon, yarns held", "coupon 0", "coupon 0.001", "coupon 0.1", "unit cell 0.1"]
    with drawing():
        figure = bias_departure(departure(names))
    left, right = figure.axes
    assert len([line for line in left.get_lines() if not line.get_label().startswith("_")]) == 1 + len(names)
    held = next(line for line in right.get_lines() if line.get_label() == "coupon, yarns keep their length")
    assert held.get_ydata()[-1] == pytest.approx(100.0 * 0.01 * 0.12)


def test_a_prediction_stands_out_and_its_error_is_relative() -> None:
    item = Prediction(STRAIN, 100.0 * STRAIN, 107.0 * STRAIN, 0.0)
    assert item.mean_error == pytest.approx(0.07)
    assert item.rms == pytest.approx(0.07)
    with drawing():
        figure = prediction_figure({30: item, 45: item}, predicted=(30,))
    strong, weak = (line for line in figure.axes[1].get_lines() if line.get_label()[0].isdigit())
    assert strong.get_label() == "30 deg, predicted"
    assert strong.get_linewidth() > weak.get_linewidth()
    assert strong.get_ydata() == pytest.approx(7.0)


def test_a_prediction_is_shifted_by_the_datum_of_the_measured_curve() -> None:
    curve = TensileCurve.of("preloaded", STRAIN, 100.0 * (STRAIN + 0.002))
    line = np.linspace(0.0, 0.13, 14)[1:]
    shifted = compare(curve, line, 100.0 * line, datum=-np.log1p(0.002))
    assert np.abs(shifted.relative_error).max() < 0.002
    assert compare(curve, line, 100.0 * line, datum=0.0).mean_error < -0.01
    with pytest.raises(ValueError, match=r"the predicted curve ends at a strain of 0\.05"):
        compare(curve, line[line < 0.055], 100.0 * line[line < 0.055], datum=0.0)


def test_refinement_shows_direct_and_refined_over_strain(tmp_path: Path) -> None:
    target, whole = TargetCurve(STRAIN, 300.0 * STRAIN, 3.6), TargetCurve(1.5 * STRAIN, 450.0 * STRAIN, 3.6)
    law = PowerLaw(3000.0, 0.2, 9960.0, 1.5)
    refined = Refined({"warp": law}, {"warp": 0.05 + STRAIN}, {"warp": 0.1 * STRAIN}, 3, 0.01, True)
    with drawing():
        figure = refinement_figure({"warp": target}, refined, direct={"warp": (whole, 0.05 + STRAIN)})
    above, below = figure.axes
    lines = {line.get_label(): line for line in above.get_lines()}
    assert lines["coupon, direct laws"].get_ydata()[-1] == pytest.approx(whole.stress[-1] * 1.17)
    assert lines["coupon, refined laws"].get_xdata()[-1] == pytest.approx(0.12)
    assert len(below.get_lines()) == 3
    path = save_refinement({"warp": target}, refined, direct={"warp": (whole, STRAIN)}, path=tmp_path / "refined.png")
    assert path.stat().st_size > 10_000


def test_cells_show_the_longer_diagonal_and_cut_cells_borrow_from_around() -> None:
    """Two cells side by side: one whole with its diagonals, one a triangle without any truss of its own."""
    quads = np.array([[0, 1, 2, 3], [1, 4, 2, 2]])
    trusses = np.array([[0, 2], [1, 3]])
    values = np.array([0.3, -0.2])
    assert cell_values(quads, trusses, values, n_points=5)[0] == pytest.approx(0.05)
    shown = cell_values(quads, trusses, values, n_points=5, largest=True)
    assert shown[0] == pytest.approx(0.3)
    assert -0.2 < shown[1] < 0.3
    sides = {tuple(side) for side in boundary(quads).tolist()}
    assert sides == {(0, 1), (2, 3), (0, 3), (1, 4), (2, 4)}
