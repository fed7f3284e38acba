"""What of a drawing a half or a quarter of the specimen models, and for how much of the whole each part stands.

The planes x = 0 (half, quarter) and y = 0 (quarter, side) mirror the model, so the drawing must be its own mirror
image. With G the mirror images of the specimen, S those that map a wire onto itself and P those that leave a loop's
centre alone, a kept wire stands for |G| / |S| wires and a kept loop for |S| / |P| loops of its wire.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.errors import BadInput, Problem
from etextile.results.wire_layout import LAID, WireLayout
from etextile.types import Array
from wires.drawn import Centred, LoopSpec, PathSpec
from wires.layout import Portion
from wires.lines import Lines, snap


_TINY_MM = 1e-6
REMEDY = "draw its mirror image too, or set fabric.portion to whole"
AXES = {"half": (0,), "quarter": (0, 1), "side": (1,)}
"""Coordinates of which a portion keeps what is not negative."""
MIRRORS = {
    "whole": (),
    "half": ((-1.0, 1.0),),
    "quarter": ((-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)),
    "side": ((1.0, -1.0),),
}
"""Mirror images of the specimen beside itself, as factors on warp and weft."""


@dataclass(frozen=True)
class KeptLoop:
    """A loop of the modelled part: centre along the wire, its numbers, and how many loops of its wire it stands for."""

    along: float
    spec: LoopSpec
    halved: bool
    copies: int


@dataclass(frozen=True)
class Kept:
    """A wire of the modelled part: number in the drawing, vertices (n, 2) and coordinates (n,) along it, loops."""

    number: int
    points: Array
    along: Array
    share: float
    copies: int
    loops: tuple[KeptLoop, ...]


def keep(specs: Sequence[PathSpec], loops: Sequence[Sequence[Centred]], portion: Portion) -> list[Kept]:
    """Return what a portion models of wires and loops; raises BadInput for a drawing that is not symmetric."""
    problems: list[Problem] = []
    kept: list[Kept] = []
    lines = Lines([spec.line for spec in specs])
    for number, spec in enumerate(specs):
        found = _kept(number, specs, lines, loops, portion)
        if isinstance(found, str):
            problems.append(spec.origin.problem(f"a {portion} mirrors this: wire {spec.name!r} {found}; {REMEDY}"))
        elif found is not None:
            kept.append(found)
    if problems:
        raise BadInput(problems)
    return kept


@dataclass(frozen=True)
class Image:
    """A modelled wire (number in the layout) as it lies on a wire of the whole specimen: at sign * along + offset."""

    wire: int
    sign: float = 1.0
    offset: float = 0.0

    def onto(self, along: Array | float) -> Array:
        """Return coordinates along the wire of the whole specimen, from those along the modelled one."""
        return np.asarray(self.sign * np.asarray(along) + self.offset)


def mirrored_names(specs: Sequence[PathSpec], mirror: tuple[float, float]) -> dict[str, str]:
    """Return by name the wire that is each wire's mirror image; '' where there is none."""
    lines = Lines([spec.line for spec in specs])
    found = {spec.name: lines.same(spec.line * np.array(mirror)) for spec in specs}
    return {name: specs[same[0]].name if same else "" for name, same in found.items()}


def images(specs: Sequence[PathSpec], layout: WireLayout, portion: Portion) -> dict[str, tuple[Image, ...]]:
    """Return by name what each wire of the whole specimen is made of: the modelled part of a wire and its images."""
    by_name = {spec.name: spec for spec in specs}
    found: dict[str, list[Image]] = {spec.name: [] for spec in specs}
    lines = Lines([spec.line for spec in specs])
    for wire, name in enumerate(layout.names):
        ends = np.array([layout.start_mm[wire], layout.end_mm[wire]])
        places = layout.places(np.array([wire, wire]), ends)
        for mirror in ((1.0, 1.0), *MIRRORS[portion]):
            line = by_name[name].line * np.array(mirror)
            for spec in (specs[number] for number in lines.same(line)):
                low, high = (snap(spec.line, spec.along, tuple(place * np.array(mirror)))[0] for place in places)
                sign = float(np.sign(high - low))
                image = Image(wire, sign, round(low - sign * ends[0], 9) + 0.0)
                if image not in found[spec.name]:
                    found[spec.name].append(image)
    return {name: tuple(parts) for name, parts in found.items()}


def _kept(
    number: int, specs: Sequence[PathSpec], lines: Lines, loops: Sequence[Sequence[Centred]], portion: Portion
) -> Kept | str | None:
    """Return the modelled part of a wire, None when its image is modelled instead, or what is wrong with it."""
    spec = specs[number]
    points, along = spec.line, spec.along
    if along[0] > along[-1]:
        points, along = points[::-1], along[::-1]
    mirrors = MIRRORS[portion]
    own = []
    for mirror in mirrors:
        image = points * np.array(mirror)
        partner = next(iter(lines.same(image)), None)
        if partner is None:
            return "has none"
        if not _same_loops(loops[number], (points, along), loops[partner], specs[partner], mirror):
            return "has loops that its image does not have"
        if partner == number:
            own.append(np.array(mirror))
    inside = _inside(points, along, AXES[portion]) if mirrors else (points, along)
    if isinstance(inside, str) or inside is None:
        return inside
    if spec.kind != LAID:
        inside = (inside[0], inside[0][:, spec.kind])
    if inside[1][-1] - inside[1][0] < along[-1] - along[0] - _TINY_MM and not own:
        return "crosses a symmetry plane and is not its own mirror image"
    still = [mirror for mirror in own if np.allclose(points * mirror, points, atol=_TINY_MM)]
    parts = []
    for loop in loops[number]:
        if not inside[1][0] - _TINY_MM <= loop.along <= inside[1][-1] + _TINY_MM:
            continue
        place = _place(points, along, loop.along)
        fixed = 1 + sum(bool(np.allclose(place * mirror, place, atol=_TINY_MM)) for mirror in own)
        half = loop.spec.length_mm / 2
        cut = loop.along - half < inside[1][0] - _TINY_MM or loop.along + half > inside[1][-1] + _TINY_MM
        if cut and fixed == 1 + len(still):
            return f"has a loop at {loop.along:g} mm that the symmetry plane cuts beside its centre"
        parts.append(KeptLoop(loop.along, loop.spec, bool(cut), (1 + len(own)) // fixed))
    copies = (1 + len(mirrors)) // (1 + len(own))
    return Kept(number, inside[0], inside[1], 1.0 / (1 + len(still)), copies, tuple(parts))


def _place(points: Array, along: Array, at: float) -> Array:
    """Return the place (2,) at a coordinate along a line."""
    return np.array([np.interp(at, along, points[:, axis]) for axis in (0, 1)])


def _same_loops(
    loops: Sequence[Centred],
    line: tuple[Array, Array],
    others: Sequence[Centred],
    other: PathSpec,
    mirror: tuple[float, float],
) -> bool:
    """Tell whether the mirror images of a wire's loops are the loops of its image."""
    if len(loops) != len(others):
        return False
    points, along = other.line, other.along
    if along[0] > along[-1]:
        points, along = points[::-1], along[::-1]
    places = [(_place(points, along, item.along), item.spec) for item in others]
    for item in loops:
        image = _place(*line, item.along) * np.array(mirror)
        same = [
            np.allclose(image, place, atol=_TINY_MM)
            and (spec.length_mm, spec.slack, spec.rigid_mm)
            == (item.spec.length_mm, item.spec.slack, item.spec.rigid_mm)
            for place, spec in places
        ]
        if not any(same):
            return False
    return True


def _inside(points: Array, along: Array, axes: tuple[int, ...]) -> tuple[Array, Array] | str | None:
    """Return the part of a line with coordinates `axes` >= 0, None when there is none, or what is wrong with it."""
    stops = [along]
    for axis in axes:
        a, b = points[:-1, axis], points[1:, axis]
        crossing = a * b < 0.0
        share = a[crossing] / (a[crossing] - b[crossing])
        stops.append(along[:-1][crossing] + share * np.diff(along)[crossing])
    every = np.unique(np.concatenate(stops))
    every = every[np.concatenate([[True], np.diff(every) > _TINY_MM])]
    places = np.stack([np.interp(every, along, points[:, axis]) for axis in (0, 1)], axis=1)
    places[np.abs(places) < _TINY_MM] = 0.0
    middle = 0.5 * (places[:-1] + places[1:])
    good = np.flatnonzero((middle[:, list(axes)] >= -_TINY_MM).all(axis=1))
    if not len(good):
        return None
    if np.any(np.diff(good) > 1):
        return "crosses a symmetry plane more than once"
    first, last = good[0], good[-1] + 1
    return places[first : last + 1], every[first : last + 1]
