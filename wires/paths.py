"""Wires as designers draw them: named straight wires and lines of vertices, with loops where they are, to a layout.

A path is given for the whole specimen in fabric coordinates (warp, weft; origin in the centre). A half or quarter keeps
the part with x >= 0 (and y >= 0); there the drawing must be its own mirror image. Everything that is wrong is raised at
once, each problem at the place it was written: key of the case, line of a table or entity of a drawing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from etextile.errors import BadInput, Problem
from etextile.results.layout import NAME_BYTES
from etextile.results.wire_layout import LAID, WireLayout
from etextile.visible import visible
from wires.drawn import Centred, LoopSpec, PathSpec
from wires.layout import Portion
from wires.lines import overlap_mm, self_crossing, snap
from wires.portion import Kept, keep


MOST_VERTICES = 5000
"""Vertices of one wire beyond which a drawing is refused: a curve in finer pieces says nothing more."""
SNAP_MM = 0.5
"""A loop or part may be drawn this far beside its wire."""
MOST_SLACK = 1.0
"""Slack beyond which a number is taken for per cent: a wire twice as long as what it spans is no loop but a coil."""
_TINY_MM = 1e-6
_BACK = -1.0 + 1e-9
"""Cosine between two pieces of a line below which the second lies on the first."""


def lay_paths(
    specs: Sequence[PathSpec], *, length_mm: float, width_mm: float, portion: Portion = "whole"
) -> tuple[WireLayout, tuple[int, ...]]:
    """Return the layout of the modelled portion, and for each of its wires which of `specs` it is.

    Raises BadInput with everything that is wrong in the drawing.
    """
    problems = [problem for spec in specs for problem in _shape_problems(spec, length_mm, width_mm)]
    problems += _name_problems(specs)
    if not problems:
        problems += _doubled(specs)
    loops: list[tuple[Centred, ...]] = []
    for spec in specs if not problems else ():
        centred, found = _centred(spec)
        loops.append(centred)
        problems += found
    if problems:
        raise BadInput(problems)
    kept = keep(specs, loops, portion)
    return _layout(specs, kept), tuple(item.number for item in kept)


def _shape_problems(spec: PathSpec, length: float, width: float) -> list[Problem]:
    """Return what is wrong with the line of one wire."""
    points = spec.line
    say = spec.origin.problem
    if len(points) < 2:
        return [say(f"wire {spec.name!r} has {len(points)} vertex, a line needs two or more")]
    if len(points) > MOST_VERTICES:
        return [say(f"wire {spec.name!r} has {len(points)} vertices, at most {MOST_VERTICES} are taken")]
    if not np.isfinite(points).all():
        return [say(f"wire {spec.name!r} has coordinates that are no numbers")]
    out = np.flatnonzero((np.abs(points) > np.array([length, width]) / 2 + _TINY_MM).any(axis=1))
    if len(out):
        x, y = points[out[0]]
        return [
            say(
                f"wire {spec.name!r} leaves the piece at ({x:g}, {y:g}) mm, "
                f"which ends at +-{length / 2:g}, +-{width / 2:g} mm"
            )
        ]
    step = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if step.sum() < 0.1:
        return [say(f"wire {spec.name!r} has no length ({step.sum():g} mm)")]
    if step.min() < _TINY_MM:
        place = points[int(step.argmin())]
        return [say(f"wire {spec.name!r} has two vertices in one place, ({place[0]:g}, {place[1]:g}) mm")]
    way = np.diff(points, axis=0) / step[:, None]
    back = np.flatnonzero((way[1:] * way[:-1]).sum(axis=1) < _BACK)
    if len(back):
        x, y = points[back[0] + 1]
        return [say(f"wire {spec.name!r} turns at ({x:g}, {y:g}) mm and runs back over itself, draw the way once")]
    if spec.kind == LAID and (cross := self_crossing(points)) is not None:
        return [say(f"wire {spec.name!r} crosses itself at ({cross[0]:g}, {cross[1]:g}) mm, which would short it")]
    return []


def unwritable(name: str) -> str:
    """Return what keeps a name of a wire or part from being written, '' for nothing."""
    if len(name.encode("utf-8", "replace")) > NAME_BYTES:
        return f"takes more than {NAME_BYTES} bytes (got {name[:20]!r}...), shorten it"
    return f"holds characters that do not show (got {visible(name)!r}), leave them out" if visible(name) != name else ""


def _name_problems(specs: Sequence[PathSpec]) -> list[Problem]:
    """Return wires of one name, and names that no file or picture can show."""
    seen: dict[str, PathSpec] = {}
    problems = []
    for spec in specs:
        if wrong := unwritable(spec.name):
            problems.append(spec.origin.problem(f"the name of a wire {wrong}"))
        if spec.name in seen:
            problems.append(spec.origin.problem(f"a second wire named {spec.name!r}, names must differ"))
        seen.setdefault(spec.name, spec)
    return problems


def _doubled(specs: Sequence[PathSpec]) -> list[Problem]:
    """Return wires that lie on each other."""
    problems = []
    low, high = (np.array([end(spec.line, axis=0) for spec in specs]).reshape(-1, 2) for end in (np.min, np.max))
    for a, first in enumerate(specs):
        near = (low[a + 1 :] <= high[a] + _TINY_MM) & (high[a + 1 :] >= low[a] - _TINY_MM)
        for second in (specs[a + 1 + int(b)] for b in np.flatnonzero(near.all(axis=1))):
            common = overlap_mm(first.line, second.line)
            if common > 0.1:
                message = f"wire {second.name!r} lies on wire {first.name!r} over {common:.4g} mm, draw it once"
                problems.append(second.origin.problem(message))
    return problems


def _centred(spec: PathSpec) -> tuple[tuple[Centred, ...], list[Problem]]:
    """Return the loops of a wire by coordinate along it, in order, and what is wrong with them."""
    points, along = spec.line, spec.along
    order = np.argsort(along)
    points, along = points[order], along[order]
    centred: list[Centred] = []
    problems = []
    for loop in spec.loops:
        say = loop.origin.problem
        if isinstance(loop.at, tuple):
            place, off = snap(points, along, loop.at)
            if off > SNAP_MM:
                problems.append(say(f"the loop lies {off:.3g} mm beside wire {spec.name!r}, put it on the wire"))
                continue
        else:
            place = loop.at
        if found := _impossible(loop):
            problems.append(say(f"a loop of wire {spec.name!r} has {found}"))
            continue
        low, high = place - loop.length_mm / 2, place + loop.length_mm / 2
        corners = along[(along > low + _TINY_MM) & (along < high - _TINY_MM)]
        if low < along[0] - _TINY_MM or high > along[-1] + _TINY_MM:
            text = (
                f"the loop at {place:g} mm leaves wire {spec.name!r}, which goes from {along[0]:g} to {along[-1]:g} mm"
            )
            problems.append(say(text))
        elif len(corners):
            problems.append(
                say(f"the loop at {place:g} mm of wire {spec.name!r} goes round a corner, move or shorten it")
            )
        if loop.rigid_mm >= loop.length_mm:
            text = f"the part of {loop.rigid_mm:g} mm fills its loop of {loop.length_mm:g} mm, wire {spec.name!r}"
            problems.append(say(text))
        centred.append(Centred(float(place), loop))
    centred.sort(key=lambda item: item.along)
    for before, after in pairwise(centred):
        if after.along - before.along < (before.spec.length_mm + after.spec.length_mm) / 2 - _TINY_MM:
            text = f"loops at {before.along:g} and {after.along:g} mm of wire {spec.name!r} overlap"
            problems.append(after.spec.origin.problem(text))
    return tuple(centred), problems


def _impossible(loop: LoopSpec) -> str:
    """Return which number of a loop no loop can have, '' for none."""
    if not (np.isfinite(loop.length_mm) and loop.length_mm > 0.0):
        return f"a length of {loop.length_mm:g} mm, which must be above 0"
    if not 0.0 <= loop.slack <= MOST_SLACK:
        return f"a slack of {loop.slack:g}, a share of its length from 0 to {MOST_SLACK:g}"
    return "" if loop.rigid_mm >= 0.0 else f"a part of {loop.rigid_mm:g} mm in it, which must not be below 0"


def _layout(specs: Sequence[PathSpec], kept: Sequence[Kept]) -> WireLayout:
    """Return the arrays of the wires that are modelled."""
    count = len(kept)
    loops = [(wire, number, loop) for wire, item in enumerate(kept) for number, loop in enumerate(item.loops)]
    centre = np.array([loop.along for _, _, loop in loops])
    half = np.array([loop.spec.length_mm / 2 for _, _, loop in loops])
    owner = np.array([wire for wire, _, _ in loops], dtype=np.int64)
    along = [item.along for item in kept]
    points = np.concatenate([item.points for item in kept] or [np.zeros((0, 2))])
    start, end = (np.array([line[k] for line in along]) for k in (0, -1))
    layout = WireLayout(
        weft_mm=np.zeros(count),
        start_mm=start,
        end_mm=end,
        share=np.array([item.share for item in kept]),
        loop_wire=owner,
        loop_index=np.array([number for _, number, _ in loops], dtype=np.int64),
        loop_warp_mm=centre,
        loop_exit_mm=centre - half,
        loop_entry_mm=centre + half,
        loop_slack=np.array([loop.spec.slack for _, _, loop in loops]),
        loop_halved=np.array([loop.halved for _, _, loop in loops], dtype=bool),
        loop_copies=np.array([loop.copies for _, _, loop in loops], dtype=np.int64),
        wire_copies=np.array([item.copies for item in kept], dtype=np.int64),
        symmetric=True,
        kind=np.array([specs[item.number].kind for item in kept], dtype=np.int64),
        loop_rigid_mm=np.array([loop.spec.rigid_mm for _, _, loop in loops]),
        vertex_wire=np.repeat(np.arange(count), [len(line) for line in along]),
        vertex_along_mm=np.concatenate(along or [np.zeros(0)]),
        vertex_warp_mm=points[:, 0],
        vertex_weft_mm=points[:, 1],
        names=tuple(specs[item.number].name for item in kept),
    )
    return _with_places(layout)


def _with_places(layout: WireLayout) -> WireLayout:
    """Return the layout with warp coordinates of the loops and weft coordinates of the wires' middles."""
    wires = np.arange(layout.n_wires)
    middle = layout.places(wires, 0.5 * (layout.start_mm + layout.end_mm))
    warp = layout.places(layout.loop_wire, layout.loop_warp_mm)[:, 0]
    return replace(layout, weft_mm=middle[:, 1], loop_warp_mm=warp)
