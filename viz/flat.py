"""Flat maps: the undeformed specimen as it lies on the table, with what will happen to it. They need no OpenGL."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from etextile.types import Array, IntArray
from viz import style, surface
from viz.legend import caption, colour_bar, finish, flat_legend, loop_markers, marker_size, sheet, state_legend, titled
from viz.scene import Scene, wire_states


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

SIZE = (1500, 1200)
PLOT = (0.075, 0.115, 0.64, 0.79)
"""Place of the specimen's axes on a sheet, as parts of it."""
MANY_PARTS = 40
EDGE_ROOM = 0.06
"""Wires that end so near to the edge, as a share of the piece, have their names beyond it."""
LEAST_NAME = 6.0
"""Size of names, points, that nothing makes smaller."""
_CLAMP_DEPTH = 0.025
"""Depth of the hatched clamps as a part of the longer side."""


def flat_failure_map(scene: Scene, path: Path, *, size: tuple[int, int] = SIZE) -> Path:
    """Draw every wire as a line and every loop by its state on the undeformed specimen; return the path of the PNG."""
    return finish(flat_failure_figure(scene, size=size), path)


def flat_failure_figure(scene: Scene, *, size: tuple[int, int] = SIZE) -> Figure:
    """Return the flat failure map as a figure whose first axes are in millimetres on the specimen."""
    with style.drawing():
        figure = sheet(size, _titled("Failure map", scene))
        axes = figure.add_axes(PLOT)
        touched = _touched(scene)
        _fill(axes, scene, scene.quads[touched], style.CONTACT)
        _hatch_folds(axes, scene)
        _wires_by_state(axes, scene)
        outline(axes, scene)
        draw_parts(axes, scene)
        _loops(axes, scene, largest=10.0)
        state_legend(figure, scene.loops.shown, place=(0.785, 0.905))
        flat_legend(
            figure,
            place=(0.785, 0.70),
            touched=bool(touched.any()),
            clamps=bool(scene.clamped.any()),
            folded=bool(scene.folded.any()),
            worn=scene.worn,
        )
        caption(figure, scene, largest=_largest_span(scene))
        return figure


def wire_strain_map(scene: Scene, path: Path, *, onset: float | None = None, size: tuple[int, int] = SIZE) -> Path:
    """Draw the strain of the wires, embedded parts thin and loops thick, in per cent; return the path of the PNG.

    `onset` marks the strain at which filaments break on the colour scale.
    """
    loops = scene.loops
    scale = style.strain_scale(100.0 * np.concatenate([scene.wires.strain, loops.wire_strain, [0.0]]))
    ends = np.stack([loops.flat - loops.half_span, loops.flat + loops.half_span], axis=1)
    with style.drawing():
        figure = sheet(size, _titled("Wire strain", scene))
        axes = figure.add_axes(PLOT)
        _lines(axes, scene.flat[scene.wires.segments, :2], scene.wires.strain, scale, width=3.0, edge=1.0)
        _lines(axes, ends, loops.wire_strain, scale, width=8.0, edge=1.6)
        outline(axes, scene)
        draw_parts(axes, scene)
        bar = colour_bar(figure, scale, "wire strain [%]", place=(0.80, 0.16, 0.018, 0.6))
        if onset is not None and 100.0 * onset <= float(scale.vmax or 0.0):
            bar.axhline(100.0 * onset, color=style.STATES[2].colour, linewidth=2.0)
            bar.text(
                -0.4, 100.0 * onset, "onset", ha="right", va="center", fontsize=9, transform=bar.get_yaxis_transform()
            )
        note = (
            "Thin: wire in the weave,\nafter its crimp is taken up.\n"
            "Thick: free wire in a loop,\nafter its slack is taken up."
        )
        figure.text(0.785, 0.905, note, fontsize=9.5, va="top", linespacing=1.5)
        caption(figure, scene, largest=_largest_wire(scene))
        return finish(figure, path)


def _titled(what: str, scene: Scene) -> str:
    return titled(f"{what}, {_laid(scene)}", scene.title, provisional=scene.provisional)


def _laid(scene: Scene) -> str:
    """Say how the specimen lies."""
    return "cut open and laid flat, seam at top and bottom" if scene.closed else "undeformed specimen"


def _hatch_folds(axes: Axes, scene: Scene) -> None:
    """Dot the cells that stand in folds."""
    from matplotlib.collections import PolyCollection

    folds: Any = scene.flat[scene.quads[scene.folded], :2]
    cells = PolyCollection(folds, facecolor="none", edgecolor=style.QUIET, linewidth=0.0, hatch="....")
    axes.add_collection(cells)


def _touched(scene: Scene) -> IntArray:
    """Return the numbers of the cells that touch the body with all corners."""
    return np.flatnonzero(np.all(scene.touched[scene.quads], axis=1))


def _largest_span(scene: Scene) -> str:
    if not len(scene.loops.state):
        return "No loops."
    return f"Largest strain of the fabric at a loop {100.0 * scene.loops.span_strain.max():.3g} %."


def _loops(axes: Axes, scene: Scene, *, largest: float) -> None:
    """Draw the loops' markers, small enough not to run into each other."""
    places = axes.transData.transform(scene.loops.flat)
    size = marker_size(places, dpi=axes.figure.dpi, largest=largest)
    loop_markers(axes, scene.loops.flat, scene.loops.shown, size=size)


def _largest_wire(scene: Scene) -> str:
    if not len(scene.wires.strain):
        return "No wires."
    worst = 100.0 * float(max(scene.wires.strain.max(), scene.loops.wire_strain.max(initial=0.0)))
    return f"Largest wire strain {worst:.3g} %."


def _fill(axes: Axes, scene: Scene, quads: IntArray, colour: str) -> None:
    from matplotlib.collections import PolyCollection

    axes.add_collection(PolyCollection(list(scene.flat[quads, :2]), facecolor=colour, edgecolor=colour, linewidth=0.6))


def _wires_by_state(axes: Axes, scene: Scene) -> None:
    """Draw each wire in the colour of its worst loop, the worse the thicker."""
    from matplotlib.collections import LineCollection

    states = wire_states(scene)
    state = np.array([states.get(int(wire), 0) for wire in scene.wires.wire], dtype=np.int64)
    for number in range(len(style.STATES)):
        lines = np.round(scene.flat[scene.wires.segments[state == number], :2], 9)  # ends snap to pixels alike
        axes.add_collection(
            LineCollection(list(lines), color=style.wire_colour(number), linewidth=1.4, zorder=3, capstyle="butt")
        )


def _lines(axes: Axes, ends: Array, strain: Array, scale: Normalize, *, width: float, edge: float) -> None:
    """Draw lines (k, 2, 2) coloured by strain (k,), on a darker, slightly wider line."""
    from matplotlib.collections import LineCollection

    axes.add_collection(LineCollection(list(ends), color=style.EDGE, linewidth=width + edge, zorder=3, capstyle="butt"))
    colour = style.strain_colours()(scale(100.0 * strain))
    axes.add_collection(LineCollection(list(ends), color=colour, linewidth=width, zorder=4, capstyle="butt"))


def outline(axes: Axes, scene: Scene) -> None:
    """Outline the specimen, hatch the clamps, number the wires and put millimetres on the axes."""
    from matplotlib.patches import Rectangle

    low, high = scene.flat[:, :2].min(axis=0), scene.flat[:, :2].max(axis=0)
    depth = _CLAMP_DEPTH * float(np.max(high - low))
    corner, extent = (low[0], low[1]), high - low
    axes.add_patch(Rectangle(corner, *extent, facecolor=style.FABRIC, zorder=0))
    axes.add_patch(Rectangle(corner, *extent, fill=False, edgecolor=style.EDGE, linewidth=1.0, zorder=5))
    for side, (start, end) in surface.clamped_sides(scene.flat, scene.quads, scene.clamped).items():
        axes.add_patch(
            Rectangle(
                *_clamp(side, low, high, start, end, depth),
                facecolor="white",
                edgecolor=style.CLAMP,
                hatch="//////",
                linewidth=1.0,
                clip_on=False,
            )
        )
    room = 1.6 * depth
    axes.set(xlim=(low[0] - room, high[0] + room), ylim=(low[1] - room, high[1] + room))
    axes.set_aspect("equal", anchor="W")
    axes.set(xlabel="x, along the specimen [mm]", ylabel="y, across [mm]")
    axes.spines[["left", "bottom"]].set_visible(False)
    axes.tick_params(length=3)
    _number_wires(axes, scene, high[0] + 1.2 * depth)


def _clamp(
    side: str, low: Array, high: Array, start: float, end: float, depth: float
) -> tuple[tuple[float, float], float, float]:
    """Return corner, width and height of the clamp on a side, outside the specimen."""
    if side == "x_min":
        return (low[0] - depth, start), depth, end - start
    if side == "x_max":
        return (high[0], start), depth, end - start
    if side == "y_min":
        return (start, low[1] - depth), end - start, depth
    return (start, high[1]), end - start, depth


def draw_parts(axes: Axes, scene: Scene) -> None:
    """Outline the lands of parts and write their names beside them."""
    from matplotlib.collections import PolyCollection

    if scene.parts is None:
        return
    lands: Any = scene.parts.flat
    axes.add_collection(PolyCollection(lands, facecolor="none", edgecolor=style.EDGE, linewidth=1.0, zorder=6))
    size = 8.0 if len(lands) <= MANY_PARTS else 6.0
    middle = 0.5 * (lands[:, :, 1].min() + lands[:, :, 1].max())
    for name, land in zip(scene.parts.names, lands, strict=True):
        above = land[:, 1].mean() >= middle
        place = (land[:, 0].mean(), land[:, 1].max() if above else land[:, 1].min())
        _name(axes, name, place, off=(0, 4 if above else -4), size=size)


def _name(axes: Axes, name: str, place: tuple[float, float], *, off: tuple[int, int], size: float) -> None:
    """Write a name beside a place, on the side that `off` (points) points to."""
    sides = {1: ("left", "bottom"), 0: ("center", "center"), -1: ("right", "top")}
    axes.annotate(
        name,
        place,
        xytext=off,
        textcoords="offset points",
        fontsize=size,
        ha=sides[int(np.sign(off[0]))][0],
        va=sides[int(np.sign(off[1]))][1],
        color=style.EDGE,
        zorder=8,
        parse_math=False,
        annotation_clip=False,
        bbox={"facecolor": style.FABRIC, "edgecolor": "none", "pad": 0.5, "alpha": 0.8},
    )


def _name_wires(axes: Axes, scene: Scene) -> None:
    """Write the name of each wire at its end on the right, or on top; the closer they are the smaller."""
    wires = scene.wires
    ends: list[tuple[str, Array, bool]] = []
    for wire in dict.fromkeys(wires.wire.tolist()):
        segments = wires.segments[wires.wire == wire]
        number, count = np.unique(segments, return_counts=True)
        free = scene.flat[number[count == 1], :2]
        points = free if len(free) else scene.flat[number, :2]
        along = bool(np.ptp(scene.flat[number, 0]) >= np.ptp(scene.flat[number, 1]))
        ends.append((wires.name(wire), points[np.argmax(points[:, 0 if along else 1])], along))
    places = axes.transData.transform([end for _, end, _ in ends])
    size = max(LEAST_NAME, marker_size(places, dpi=axes.figure.dpi, largest=11.0) / 1.4)
    edge = scene.flat[:, :2].max(axis=0)
    room = EDGE_ROOM * np.ptp(scene.flat[:, :2], axis=0)
    for name, end, along in ends:
        axis = 0 if along else 1
        outside = edge[axis] + 1.2 * _CLAMP_DEPTH * float(np.ptp(scene.flat[:, :2], axis=0).max())
        place = end.copy()
        if edge[axis] - end[axis] < room[axis]:
            place[axis] = outside  # names would cover the clamp
        _name(axes, name, (place[0], place[1]), off=(5, 0) if along else (0, 5), size=size)


def _number_wires(axes: Axes, scene: Scene, x: float) -> None:
    """Write the number of each wire where it ends on the right."""
    if scene.wires.named:
        _name_wires(axes, scene)
        return
    ends = scene.flat[scene.wires.segments].max(axis=1)[:, 0] if len(scene.wires.wire) else np.zeros(0)
    right = scene.flat[:, 0].max() - 1e-6
    for segment, wire, end in zip(scene.wires.segments, scene.wires.wire, ends, strict=True):
        if end >= right:
            place = scene.flat[segment][np.argmax(scene.flat[segment, 0])]
            axes.text(x, place[1], str(wire), fontsize=8, color=style.QUIET, ha="left", va="center")
    if len(ends):
        axes.text(x, scene.flat[:, 1].max() + 1.2, "wire", fontsize=8, color=style.QUIET, ha="left", va="bottom")
