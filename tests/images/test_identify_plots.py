"""Check plots of identification by their meaning: what is drawn where, and that every figure is written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from etextile.identify.coupon import pull
from etextile.identify.curves import TensileCurve
from etextile.identify.fit import NamedLaw
from etextile.identify.result import IdentifiedFabric, identify_fabric
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from viz.identify_plots import FIGURES, fitted_curves, hardening_fit, measured_curves, modulus_fit, save_figures
from viz.style import EDGE


WEAVE = Weave(0.2849, 0.1603, 0.35, 0.0155, 11.0, 8.9)
LAW = PowerLaw(3000.0, 0.2, 9960.0, 1.5)


@pytest.fixture(scope="module")
def fabric() -> IdentifiedFabric:
    rng = np.random.default_rng(5)
    strain, stress = pull(LAW, 0.12, area_ratio=0.0561 / 0.0155)
    gains = {"good_1": 1.0, "good_2": 1.01, "slipped": 0.8, "good_3": 0.99}
    warp = [
        TensileCurve.of(name, strain, gain * stress + rng.normal(0.0, 0.2, len(stress))) for name, gain in gains.items()
    ]
    weft = [TensileCurve.of("loading", strain[:101], stress[:101])]
    named = {"weft": NamedLaw("estimated_mid", LAW, 0.0997 / 0.0155, 0.12)}
    return identify_fabric({"warp": warp, "weft": weft}, WEAVE, named=named)


def test_all_figures_are_written_and_not_blank(fabric: IdentifiedFabric, tmp_path: Path) -> None:
    paths = save_figures(fabric, tmp_path / "plots", prefix="a_")
    assert [path.name for path in paths] == [f"a_{name}.png" for name in FIGURES]
    for path in paths:
        assert (imread(path)[..., :3] < 0.5).any(axis=2).mean() > 0.005


def test_the_outlier_is_named_in_the_figure_of_measured_curves(fabric: IdentifiedFabric) -> None:
    (axes,) = measured_curves(fabric).axes
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert "slipped: outlier" in labels
    assert "warp (4 specimens)" in labels


def test_the_modulus_line_has_the_identified_slope_and_unidentified_is_said(fabric: IdentifiedFabric) -> None:
    warp, weft = modulus_fit(fabric).axes
    lines = [line for line in warp.lines if line.get_color() == EDGE]
    assert len(lines) == 3
    slopes = [float(np.diff(line.get_ydata())[0] / np.diff(line.get_xdata())[0]) for line in lines]
    assert np.mean(slopes) == pytest.approx(fabric.families["warp"].law.E, rel=0.02)
    assert "unidentified" in weft.texts[0].get_text()


def test_hardening_is_a_straight_line_in_the_log_log_diagram(fabric: IdentifiedFabric) -> None:
    (axes,) = hardening_fit(fabric).axes
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    line = next(line for line in axes.lines if "warp" in str(line.get_label()))
    x, y = (np.log(values[-50:]) for values in (line.get_xdata(), line.get_ydata()))
    assert np.polyfit(x, y, 1)[0] == pytest.approx(fabric.families["warp"].law.n, rel=0.02)


def test_the_band_holds_the_fit_and_the_difference_is_small(fabric: IdentifiedFabric) -> None:
    axes = fitted_curves(fabric).axes
    assert len(axes) == 4
    labels = axes[0].get_legend_handles_labels()[1]
    assert {"fit", "measured", "95 % of the fit", "95 % of further specimens"} <= set(labels)
    differences = [line.get_ydata() for line in axes[1].lines[1:]]
    assert len(differences) == 3
    assert max(float(np.abs(values).max()) for values in differences) < 5.0
