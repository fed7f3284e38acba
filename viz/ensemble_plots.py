"""What an ensemble says, drawn: fragility curves, which input matters, and where on the specimen wires fail.

Probability runs through the colours of the four states, from cloth white over yellow and red to near black, so that it
rises from light to dark in grey print.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from etextile.ensemble.statistics import crossing
from etextile.lattice.piece import Lattice
from etextile.types import Array, BoolArray
from viz import style
from viz.flat import PLOT, SIZE, outline
from viz.legend import finish, marker_size, sheet, titled
from viz.mirror import whole
from viz.plots import Curve, draw_curves, frame
from viz.scene import Colouring, Scene, SceneLoops, SceneWires
from wires.layout import WireLayout


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEVELS = (0.05, 0.5, 0.95)
"""Probabilities that are marked in the rows of the wires."""
MOST_LABELS = 28
"""Wires whose places are written beside an axis."""


@dataclass(frozen=True)
class Bar:
    """One input: its name, rank correlation and 95 % interval; those whose interval holds zero are drawn pale."""

    label: str
    value: float
    low: float
    high: float


def fragility(curves: Sequence[Curve], path: Path, *, x_label: str, title: str = "") -> Path:
    """Draw probabilities (S,) over displacement with their 95 % bands; return the path of the PNG."""
    with style.drawing():
        figure, axes = frame(x_label, "probability, share of the wires", title=title or "Fragility", size=(1200, 800))
        draw_curves(axes, curves)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.13), ncol=2)
        axes.set(ylim=(-0.02, 1.02), xlim=(0.0, max(float(curve.x.max()) for curve in curves)))
        return finish(figure, path)


def wire_fragility(
    displacement_mm: Array,
    weft_mm: Array,
    probability: Array,
    path: Path,
    *,
    x_label: str,
    title: str = "",
    names: Sequence[str] = (),
) -> Path:
    """Draw the probability (S, W) that wires at weft_mm (W,) have lost a filament, over displacement (S,).

    Wires that do not lie side by side get rows of equal height in their order.
    """
    size = (1200, 800)
    beside = bool((np.diff(weft_mm) > 0.0).all())
    rows = weft_mm if beside else np.arange(len(weft_mm), dtype=float)
    y_label = "place of the wire, y [mm]" if beside else "wire"
    with style.drawing():
        figure, axes = frame(x_label, y_label, title=title or "Fragility of the wires", size=size)
        axes.grid(visible=False)
        edges_x, edges_y = _edges(displacement_mm), _edges(rows)
        mesh = axes.pcolormesh(edges_x, edges_y, probability.T, cmap=style.probability_colours(), vmin=0.0, vmax=1.0)
        every = -(-len(weft_mm) // MOST_LABELS)
        axes.set(xlim=(displacement_mm[0], displacement_mm[-1]), yticks=rows[::every])
        called = names or [str(number) for number in range(len(weft_mm))]
        labels = [f"{name}   {place:.1f}" if beside else name for name, place in zip(called, weft_mm, strict=True)]
        axes.set_yticklabels(labels[::every], fontsize=8)
        _marks(axes, displacement_mm, edges_y, probability)
        figure.colorbar(mesh, ax=axes, label="P(at least one filament of the wire is broken)")
        return finish(figure, path)


def ranking(
    bars: Sequence[tuple[str, Sequence[Bar]]], path: Path, *, title: str = "", provisional: bool = False
) -> Path:
    """Draw rank correlations with their 95 % intervals, one panel per output (heading, bars); strongest on top."""
    rows = max(len(items) for _, items in bars)
    height = 240 + 46 * rows
    with style.drawing():
        figure = sheet((1500, height), titled("Which input matters", title, provisional=provisional))
        width = 0.96 / len(bars)
        for number, (heading, items) in enumerate(bars):
            place = (0.02 + width * (number + 0.44), 120 / height, 0.52 * width, 46 * rows / height)
            axes = figure.add_axes(place)
            _draw_bars(axes, items, rows=rows)
            axes.set_title(heading, fontsize=10)
        remark = "Spearman's rank correlation with 95 % interval; pale: the interval holds zero."
        figure.text(0.02, 16 / height, remark, fontsize=9, color=style.QUIET)
        return finish(figure, path)


def probability_map(
    specimen: Scene, loop: Array, wire: Array, path: Path, *, what: str, remark: str, title: str = "",
    provisional: bool = False,
) -> Path:  # fmt: skip
    """Draw the probabilities of loops (L,) and wires (W,), as modelled, on the whole undeformed specimen.

    `specimen` as from `specimen_scene`; `what` names the event, `remark` stands at the foot. Returns the PNG's path.
    """
    return finish(
        probability_figure(specimen, loop, wire, what=what, remark=remark, title=title, provisional=provisional), path
    )


def probability_figure(
    specimen: Scene, loop: Array, wire: Array, *, what: str, remark: str, title: str = "", provisional: bool = False
) -> Figure:
    """Return the probability map as a figure whose first axes are in millimetres on the specimen."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    scene, scale = whole(specimen), Normalize(0.0, 1.0)
    with style.drawing():
        figure = sheet(SIZE, titled("Failure probability, undeformed specimen", title, provisional=provisional))
        axes = figure.add_axes(PLOT)
        _draw_wires(axes, scene, wire)
        outline(axes, scene)
        size = marker_size(axes.transData.transform(scene.loops.flat), dpi=figure.dpi, largest=12.0)
        # a mirrored loop has the place of its image and the number of its original in `span_strain`
        values = loop[scene.loops.span_strain.astype(np.int64)]
        x, y = scene.loops.flat.T
        axes.scatter(
            x, y, c=values, s=size**2, cmap=style.probability_colours(), norm=scale, edgecolor=style.EDGE,
            linewidth=0.9,
            zorder=10, clip_on=False,
        )  # fmt: skip
        bar = figure.add_axes((0.80, 0.30, 0.02, 0.5))
        figure.colorbar(ScalarMappable(scale, style.probability_colours()), cax=bar)
        figure.text(0.785, 0.905, f"Probability that\n{what}", fontsize=10, va="top", linespacing=1.5)
        figure.text(0.785, 0.23, "Circles: loops.\nLines: wires, any of\ntheir loops.", fontsize=9.5, va="top")
        figure.text(0.02, 0.03, remark, fontsize=9.5, color=style.QUIET, va="bottom")
        return figure


def _draw_wires(axes: Axes, scene: Scene, probability: Array) -> None:
    """Draw each wire in the colour of its probability (W,), on a line a little wider."""
    from matplotlib.collections import LineCollection

    lines = list(scene.flat[scene.wires.segments, :2])
    colour = style.probability_colours()(probability[scene.wires.wire])
    for look, width, order in ((style.SOUND_WIRE, 4.0, 2), (colour, 2.6, 3)):
        axes.add_collection(LineCollection(lines, color=look, linewidth=width, zorder=order, capstyle="butt"))


def specimen_scene(lattice: Lattice, layout: WireLayout, clamped: BoolArray, *, portion: str) -> Scene:
    """Return the undeformed specimen with its wires and loops; `clamped` (N,) marks nodes that are held.

    The loops' `span_strain` holds their numbers, so that values can be found again after mirroring.
    """
    nodes, count = len(lattice.points), len(layout.vertex_wire)
    vertices = np.stack([layout.vertex_warp_mm, layout.vertex_weft_mm, np.zeros(count)], axis=1)
    first = np.flatnonzero(np.diff(layout.vertex_wire) == 0)
    segments = nodes + np.stack([first, first + 1], axis=1)
    points = np.concatenate([lattice.points, vertices])
    loops = np.stack([layout.loop_warp_mm, layout.loop_weft_mm], axis=1)
    ends = [layout.places(layout.loop_wire, place) for place in (layout.loop_exit_mm, layout.loop_entry_mm)]
    numbers = np.arange(layout.n_loops, dtype=float)
    return Scene(
        title="",
        displacement_mm=0.0,
        force_N=0.0,
        portion=portion,
        flat=points,
        points=points,
        quads=lattice.quads,
        colouring=Colouring("none", "", np.zeros(len(lattice.quads)), 0.0),
        touched=np.zeros(len(points), dtype=bool),
        clamped=np.concatenate([clamped, np.zeros(count, dtype=bool)]),
        wires=SceneWires(segments, layout.vertex_wire[first], np.zeros(len(first)), layout.names),
        loops=SceneLoops(
            wire=layout.loop_wire,
            index=layout.loop_index,
            state=np.zeros(layout.n_loops, dtype=np.int64),
            span_strain=numbers,
            wire_strain=np.zeros(layout.n_loops),
            flat=loops,
            half_span=0.5 * (ends[1] - ends[0]),
            deformed=np.column_stack([loops, np.zeros(layout.n_loops)]),
        ),
        body=None,
        symmetry=lattice.symmetry,
        warp_angle_deg=lattice.warp_angle,
    )


def _edges(centres: Array) -> Array:
    """Return the edges (n + 1,) between centres (n,)."""
    if len(centres) == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middle = 0.5 * (centres[:-1] + centres[1:])
    return np.concatenate([[2 * centres[0] - middle[0]], middle, [2 * centres[-1] - middle[-1]]])


def _marks(axes: Axes, x: Array, edges: Array, probability: Array) -> None:
    """Mark in the row of each wire, between edges (W + 1,), where its probability (S, W) passes a few levels."""
    for level, dash, colour in zip(LEVELS, (":", "-", ":"), (style.EDGE, style.EDGE, "white"), strict=True):
        for wire, curve in enumerate(probability.T):
            place = crossing(x, curve, level)
            if place is not None:
                axes.vlines(place, edges[wire], edges[wire + 1], color=colour, linewidth=1.4, linestyle=dash)
    axes.text(
        1.0, -0.075, "marks at 5, 50 and 95 %", transform=axes.transAxes, ha="right", va="top", fontsize=8.5,
        color=style.QUIET,
    )  # fmt: skip


def _draw_bars(axes: Axes, items: Sequence[Bar], *, rows: int) -> None:
    """Draw one dot with its interval per input."""
    for row, item in enumerate(items):
        sure = item.low > 0.0 or item.high < 0.0
        colour = style.SERIES[0] if sure else style.SOUND_WIRE
        axes.plot([item.low, item.high], [row, row], color=colour, linewidth=2.2, solid_capstyle="butt")
        axes.plot(item.value, row, marker="o", markersize=7, color=colour)
    axes.axvline(0.0, color=style.QUIET, linewidth=1.0, zorder=0)
    axes.set(xlim=(-1.05, 1.05), ylim=(rows - 0.5, -0.5), yticks=range(len(items)))
    axes.set_yticklabels([item.label for item in items])
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=True, axis="x")
    axes.spines["left"].set_visible(False)
