"""Check plots of an identification, one function per figure: the figures 4, 10, 11 and 12 of Beex et al.

They answer what a number cannot: was the unloading taken where it is straight, is the hardening a power law, does the
fitted fabric return the measured curves. Measured points are coloured dots, fits are black lines.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from etextile.files import replacing
from etextile.identify.coupon import loading_curve, true_stress, unloading_line
from etextile.identify.result import DIRECTION_OF, NORMAL_95, IdentifiedFabric, IdentifiedFamily
from etextile.identify.specimen import SpecimenFit
from etextile.types import Array
from viz.style import DASHES, EDGE, FAINT, QUIET, SERIES, drawing, plain_decades


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DPI = 150
_COLOUR = {family: SERIES[i] for i, family in enumerate(DIRECTION_OF)}
_MARKER = dict(zip(DIRECTION_OF, "os^", strict=True))
_DASH = {family: DASHES[i] for i, family in enumerate(DIRECTION_OF)}
_NAME = {"warp": "warp", "weft": "weft", "diagonal": "bias (diagonal trusses)"}


def measured_curves(fabric: IdentifiedFabric) -> Figure:
    """Draw all measured curves (figure 4): engineering stress over engineering strain, unloading included."""
    figure = _figure(6.6, 4.4)
    axes = figure.add_subplot()
    for family, item in fabric.families.items():
        for part, out in zip(item.fit.measured, item.fit.scatter.outlier, strict=True):
            colour = QUIET if out else _COLOUR[family]
            label = f"{part.name}: outlier" if out else _label(family, item, axes)
            style: dict[str, Any] = {"color": colour, "linewidth": 0.9, "marker": _MARKER[family], "markersize": 3.5}
            axes.plot(part.strain, part.stress, **style, markevery=0.08, label=label)
            axes.plot(part.unloading_strain, part.unloading_stress, **style, markevery=0.08)
            if part.failed:
                mark = None if "start of failure" in _labels(axes) else "start of failure"
                axes.plot(part.strain[-1], part.stress[-1], "x", color=colour, markersize=7, label=mark)
    _finish(axes, "Measured tensile curves", "engineering strain [-]", "fabric engineering stress [MPa]")
    axes.legend(loc="best")
    return figure


def modulus_fit(fabric: IdentifiedFabric) -> Figure:
    """Draw true stress over Hencky strain with the line through the top 40 % of unloading (figure 10)."""
    figure = _figure(3.7 * max(len(fabric.families), 1) + 0.6, 3.9)
    for axes, (family, item) in zip(_panels(figure, fabric), fabric.families.items(), strict=True):
        for fit in item.fit.specimens:
            _draw_true_stress(axes, fit, colour=_COLOUR[family])
        _finish(axes, _NAME[family], "Hencky strain [-]", "true stress of the truss [MPa]", small=True)
        axes.text(0.04, 0.96, _modulus_text(item), transform=axes.transAxes, va="top", fontsize=9)
    _head(figure, "Modulus from unloading", "black: line through the top 40 % of unloading, one per specimen")
    return figure


def hardening_fit(fabric: IdentifiedFabric) -> Figure:
    """Draw true stress over plastic strain in a log-log diagram with the fitted hardening law (figure 11)."""
    figure = _figure(6.6, 4.6)
    axes = figure.add_subplot()
    lowest, left = np.inf, np.inf
    for family, item in fabric.families.items():
        law = item.law
        for fit in item.fit.specimens:
            plastic, stress = _plastic_curve(fit)
            shown = (plastic > 0.0) & (stress > 0.02 * stress.max())
            lowest, left = min(lowest, float(stress[shown].min())), min(left, float(plastic[shown].min()))
            axes.plot(plastic[shown], stress[shown], **_dots(_COLOUR[family]))
        strain = np.geomspace(1e-5, max(_plastic_curve(fit)[0].max() for fit in item.fit.specimens), 400)
        yield_stress = law.sigma_y0 * strain / (strain + law.e0) + law.H * strain**law.n
        label = f"{_NAME[family]}: H = {_digits(law.H)} MPa, n = {law.n:.3g}"
        axes.plot(strain, yield_stress, color=EDGE, linestyle=_DASH[family], linewidth=1.3, label=label)
        axes.plot(strain[-1], yield_stress[-1], color=_COLOUR[family], marker=_MARKER[family], markersize=6)
    axes.set_xscale("log")
    axes.set_yscale("log")
    plain_decades(axes.xaxis)
    plain_decades(axes.yaxis)
    axes.set_ylim(bottom=0.7 * lowest)
    axes.set_xlim(left=0.7 * left)
    _finish(axes, "Hardening", "plastic Hencky strain [-]", "true stress of the truss [MPa]")
    axes.set_title(
        "dots: measured, above 2 % of the peak; lines: fit", loc="right", fontsize=9, color=QUIET, weight="normal"
    )
    figure.legend(loc="outside lower center")
    return figure


def fitted_curves(fabric: IdentifiedFabric) -> Figure:
    """Draw measured against fitted curves with 95 % bands, and their difference below (figure 12)."""
    count = max(len(fabric.families), 1)
    figure = _figure(3.7 * count + 0.6, 5.0)
    grid = figure.add_gridspec(2, count, height_ratios=(3.0, 1.0))
    for column, (family, item) in enumerate(fabric.families.items()):
        above = figure.add_subplot(grid[0, column])
        below = figure.add_subplot(grid[1, column], sharex=above)
        _draw_fit(above, family, item)
        _draw_difference(below, family, item)
        above.tick_params(labelbottom=False)
        _finish(above, _NAME[family], "", "fabric engineering stress [MPa]" if column == 0 else "", small=True)
        _finish(below, "", "engineering strain [-]", "measured - fit\n[% of peak]" if column == 0 else "")
        above.legend(loc="upper left", fontsize=8.5)
    _head(figure, "Measured and fitted curves", "")
    return figure


FIGURES: dict[str, Callable[[IdentifiedFabric], Figure]] = {
    "measured_curves": measured_curves,
    "modulus_fit": modulus_fit,
    "hardening_fit": hardening_fit,
    "fitted_curves": fitted_curves,
}
"""Figure by the stem of its file."""


def save_figures(fabric: IdentifiedFabric, folder: Path, *, prefix: str = "") -> tuple[Path, ...]:
    """Write all figures as PNG into a folder, which is made when missing, and return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, draw in FIGURES.items():
        path = folder / f"{prefix}{name}.png"
        with drawing(), replacing(path) as part:
            draw(fabric).savefig(part, dpi=DPI)
        paths.append(path)
    return tuple(paths)


def _figure(width: float, height: float) -> Figure:
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained")


def _panels(figure: Figure, fabric: IdentifiedFabric) -> list[Axes]:
    count = len(fabric.families)
    return [figure.add_subplot(1, count, i + 1) for i in range(count)]


def _head(figure: Figure, title: str, remark: str) -> None:
    figure.suptitle(title, x=0.01, ha="left", fontsize=11.5, fontweight="bold")
    if remark:
        figure.text(0.99, 0.99, remark, ha="right", va="top", fontsize=9, color=QUIET)


def _digits(value: float) -> str:
    """Return a stress with three to four digits and no exponent."""
    return f"{float(f'{value:.4g}'):g}" if value < 1e4 else f"{float(f'{value:.3g}'):.0f}"


def _dots(colour: str) -> dict[str, Any]:
    """Return the style of measured points."""
    return {
        "color": colour,
        "linestyle": "none",
        "marker": "o",
        "markersize": 2.2,
        "markeredgewidth": 0.0,
        "alpha": 0.75,
    }


def _finish(axes: Axes, title: str, x: str, y: str, *, small: bool = False) -> None:
    if title:
        axes.set_title(title, fontsize=10.5 if small else 12.5)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.grid(color=FAINT, linewidth=0.6)
    axes.set_axisbelow(True)


def _labels(axes: Axes) -> list[str]:
    return list(axes.get_legend_handles_labels()[1])


def _label(family: str, item: IdentifiedFamily, axes: Axes) -> str | None:
    """Return the legend text of a direction for its first specimen."""
    count = len(item.fit.measured)
    text = f"{DIRECTION_OF[family]} ({count} specimen{'s' if count > 1 else ''})"
    return None if text in _labels(axes) else text


def _modulus_text(item: IdentifiedFamily) -> str:
    """Return the modulus with its interval, or that it is not identified."""
    estimate = item.estimates["E"]
    if estimate.std is None or estimate.low is None or estimate.high is None:
        return f"E = {_digits(item.law.E)} MPa\nunidentified: no unloading"
    return f"E = {_digits(estimate.value)} MPa\n95 %: {_digits(estimate.low)} to {_digits(estimate.high)}"


def _draw_true_stress(axes: Axes, fit: SpecimenFit, *, colour: str) -> None:
    """Draw loading and unloading of one specimen in true stress, and the line through the top of unloading."""
    part, ratio = fit.segments, fit.area_ratio
    hencky = np.log1p(part.strain)
    axes.plot(hencky, true_stress(hencky, part.stress * ratio, E=fit.law.E), **_dots(colour))
    if fit.modulus is None:
        return
    modulus, stretch = fit.modulus, fit.modulus.plastic_stretch
    axes.plot(np.log1p(part.unloading_strain), part.unloading_stress * ratio * stretch, **_dots(colour))
    end = float(modulus.hencky.min())
    line = np.array([end, modulus.turning])
    stress = modulus.line[0] + modulus.line[1] * (line - modulus.turning)
    axes.plot(line, stress * stretch, color=EDGE, linewidth=1.4, solid_capstyle="butt")


def _plastic_curve(fit: SpecimenFit) -> tuple[Array, Array]:
    """Return plastic strain and true stress of the measured loading at the specimen's modulus."""
    hencky = fit.hardening.own_strain(np.log1p(fit.segments.strain))
    stress = true_stress(hencky, fit.segments.stress * fit.area_ratio, E=fit.law.E)
    return hencky - stress / fit.law.E, stress


def _draw_fit(axes: Axes, family: str, item: IdentifiedFamily) -> None:
    """Draw specimens, mean law, and the bands of the mean and of a further specimen."""
    top = item.fit.strain_range[1]
    strain = np.linspace(0.0, top, 200)
    curve = loading_curve(item.law, np.log1p(strain))
    stress = curve.stress / item.area_ratio
    mean = _reach(curve.slopes, item.fit.covariance) / item.area_ratio
    if item.fit.between is not None:
        single = np.hypot(mean, _reach(curve.slopes, item.fit.between) / item.area_ratio)
        label = "95 % of further specimens"
        axes.fill_between(strain, stress - single, stress + single, color=FAINT, linewidth=0, label=label)
    axes.fill_between(
        strain, stress - mean, stress + mean, color=_COLOUR[family], alpha=0.35, linewidth=0, label="95 % of the fit"
    )
    axes.plot(strain, stress, color=EDGE, linewidth=1.2, label="fit")
    for number, fit in enumerate(item.fit.specimens):
        part = fit.segments
        axes.plot(_shifted(fit), part.stress, **_dots(_COLOUR[family]), label=None if number else "measured")
        axes.plot(part.unloading_strain, part.unloading_stress, **_dots(_COLOUR[family]))
    if item.modulus_identified:
        turning = float(np.log1p(top))
        down = np.linspace(turning, float(loading_curve(item.law, np.array([turning])).plastic_strain[0]), 30)
        line = unloading_line(item.law, down, from_hencky=turning)[0] / item.area_ratio
        axes.plot(np.expm1(down), line, color=EDGE, linewidth=1.2, linestyle="--")


def _reach(slopes: Array, covariance: Array) -> Array:
    """Return half the width of the 95 % band of the truss stress (n,)."""
    variance = np.einsum("ni,ij,nj->n", slopes[:, :3], covariance, slopes[:, :3])
    return np.asarray(NORMAL_95 * np.sqrt(np.maximum(variance, 0.0)))


def _shifted(fit: SpecimenFit) -> Array:
    """Return the engineering strain of loading with slack or preload taken into account."""
    return np.asarray(np.expm1(fit.hardening.own_strain(np.log1p(fit.segments.strain))))


def _draw_difference(axes: Axes, family: str, item: IdentifiedFamily) -> None:
    """Draw measured minus fitted stress of every specimen, in per cent of its peak."""
    axes.axhline(0.0, color=EDGE, linewidth=0.8)
    for fit in item.fit.specimens:
        strain = _shifted(fit)
        fitted = loading_curve(item.law, np.log1p(strain)).stress / item.area_ratio
        difference = 100.0 * (fit.segments.stress - fitted) / fit.segments.stress.max()
        axes.plot(strain, difference, color=_COLOUR[family], linewidth=0.8)
