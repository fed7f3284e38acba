"""Parts on the fabric: where their lands lie, and where on which wires their terminals are."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from etextile.errors import Problem, nearest
from etextile.types import Array
from wires.drawn import Origin, PathSpec
from wires.layout import Portion
from wires.lines import snap
from wires.paths import SNAP_MM, unwritable
from wires.portion import MIRRORS, REMEDY, mirrored_names


@dataclass(frozen=True)
class PartSpec:
    """A part: name, centre (warp, weft) and extent of its land, mm, wires it connects (None: all that cross the land).

    `rigid` False leaves the fabric under it as it is: the part hangs in loops.
    """

    name: str
    at: tuple[float, float]
    size: tuple[float, float]
    connects: tuple[str, ...] | None = None
    rigid: bool = True
    origin: Origin = field(default_factory=Origin, compare=False)


@dataclass(frozen=True)
class Terminal:
    """Where a part is connected: number of the part, name of the wire, coordinate along it."""

    part: int
    wire: str
    along_mm: float


def terminals(
    parts: Sequence[PartSpec], specs: Sequence[PathSpec], *, length_mm: float, width_mm: float
) -> tuple[tuple[Terminal, ...], list[Problem]]:
    """Return where parts are connected to wires, and what is wrong with them."""
    problems: list[Problem] = []
    found: list[Terminal] = []
    lines = {spec.name: _line(spec) for spec in specs}
    seen: set[str] = set()
    for number, part in enumerate(parts):
        say = part.origin.problem
        if part.name in seen:
            problems.append(say(f"a second part named {part.name!r}, names must differ"))
            continue
        seen.add(part.name)
        if wrong := unwritable(part.name):
            problems.append(say(f"the name of a part {wrong}"))
            continue
        if not min(part.size) > 0.0:
            text = f"part {part.name!r} has a land of {part.size[0]:g} x {part.size[1]:g} mm, which must be above 0"
            problems.append(say(text))
            continue
        x, y = part.at
        if abs(x) + part.size[0] / 2 > length_mm / 2 + 1e-6 or abs(y) + part.size[1] / 2 > width_mm / 2 + 1e-6:
            problems.append(
                say(
                    f"part {part.name!r} at ({x:g}, {y:g}) mm leaves the piece, "
                    f"which ends at +-{length_mm / 2:g}, +-{width_mm / 2:g} mm"
                )
            )
            continue
        near = {name: _reach(line, part) for name, line in lines.items()}
        names = part.connects
        if names is None:
            names = tuple(name for name, (_, off) in near.items() if off <= 0.0)
        if not names:
            closest = min(near, key=lambda name: near[name][1], default=None)
            there = "" if closest is None else f", the nearest, {closest!r}, passes {near[closest][1]:.3g} mm beside it"
            problems.append(say(f"part {part.name!r} lies on no wire{there}"))
        for name in names:
            if name not in near:
                hint = (
                    ", separate names by ;" if near.keys() & set(re.split(r"[\s,|/+]+", name)) else nearest(name, near)
                )
                problems.append(say(f"part {part.name!r} connects no such wire (got {name!r}){hint}"))
            elif near[name][1] > SNAP_MM:
                text = f"part {part.name!r} does not touch wire {name!r}, which passes {near[name][1]:.3g} mm beside it"
                problems.append(say(text))
            else:
                found.append(Terminal(number, name, near[name][0]))
    return tuple(found), problems + _overlapping(parts)


def unmirrored(
    parts: Sequence[PartSpec], found: Sequence[Terminal], specs: Sequence[PathSpec], portion: Portion
) -> list[Problem]:
    """Return the parts whose mirror images a half or quarter would add to what is drawn."""
    wires = {number: {item.wire for item in found if item.part == number} for number in range(len(parts))}
    problems = []
    places = np.array([part.at for part in parts]).reshape(-1, 2)
    image = {mirror: mirrored_names(specs, mirror) for mirror in MIRRORS[portion]}
    for number, part in enumerate(parts):
        for mirror in MIRRORS[portion]:
            at = (part.at[0] * mirror[0], part.at[1] * mirror[1])
            there = np.flatnonzero(np.isclose(places, at, atol=1e-6).all(axis=1)).tolist()
            own = {image[mirror][name] for name in wires[number]}
            what = ""
            if not there:
                what = f"has none at ({at[0] + 0.0:g}, {at[1] + 0.0:g}) mm"
            elif not any(parts[k].size == part.size and parts[k].rigid == part.rigid for k in there):
                what = f"has another size than {parts[there[0]].name!r} in its place"
            elif not any(wires[k] == own for k in there):
                what = f"connects other wires than {parts[there[0]].name!r} in its place"
            if what:
                text = f"a {portion} mirrors this: part {part.name!r} {what}; {REMEDY}"
                problems.append(part.origin.problem(text))
                break
    return problems


def _overlapping(parts: Sequence[PartSpec]) -> list[Problem]:
    """Return rigid lands that lie on each other."""
    rigid = [part for part in parts if part.rigid]
    at, size = (np.array([getattr(part, name) for part in rigid]).reshape(-1, 2) for name in ("at", "size"))
    problems = []
    for number, first in enumerate(rigid):
        room = (size[number] + size[number + 1 :]) / 2 - np.abs(at[number] - at[number + 1 :])
        for k in np.flatnonzero((room > 1e-6).all(axis=1)):
            second = rigid[number + 1 + k]
            if first.name != second.name:
                text = f"part {second.name!r} overlaps part {first.name!r} by {room[k, 0]:.3g} x {room[k, 1]:.3g} mm"
                problems.append(second.origin.problem(text))
    return problems


def _line(spec: PathSpec) -> tuple[Array, Array]:
    points, along = spec.line, spec.along
    return (points[::-1], along[::-1]) if along[0] > along[-1] else (points, along)


def _reach(line: tuple[Array, Array], part: PartSpec) -> tuple[float, float]:
    """Return where along a line it comes nearest to a part's centre, and how far it stays off the land, mm."""
    along, _ = snap(*line, part.at)
    half = np.array(part.size) / 2
    points, coordinate = line
    low, high = coordinate[0], coordinate[-1]
    tries = np.unique(np.clip(along + np.linspace(-half.max(), half.max(), 41), low, high))
    places = np.stack([np.interp(tries, coordinate, points[:, axis]) for axis in (0, 1)], axis=1)
    off = np.linalg.norm(np.maximum(np.abs(places - np.array(part.at)) - half, 0.0), axis=1)
    return along, float(off.min())
