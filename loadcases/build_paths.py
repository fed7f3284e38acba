"""From drawn wires of a case (its paths, its drawing) to the layout of the modelled part, with parts and joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from etextile.errors import BadInput, Problem, nearest
from etextile.results.wire_layout import ALONG_WARP, ALONG_WEFT, LAID, WireLayout
from etextile.types import Array
from loadcases.schema_loops import Loops
from loadcases.schema_paths import Component, Net, WirePath
from loadcases.schema_wires import Wires
from wires.drawn import LoopSpec, Origin, PathSpec
from wires.lines import crossings, snap
from wires.parts import PartSpec, Terminal, terminals, unmirrored
from wires.paths import lay_paths
from wires.portion import MIRRORS, Image, images, mirrored_names


if TYPE_CHECKING:
    from loadcases.schema import Case
    from wires.drawing import Drawing


@dataclass(frozen=True)
class Construction:
    """What a wire is made of and how it is held."""

    material: str
    filaments: int
    filament_diameter: float
    crimp: float
    bond: object


@dataclass(frozen=True)
class WireJoint:
    """Two wires that are joined where they cross: their names, coordinates along each."""

    wires: tuple[str, str]
    along_mm: tuple[float, float]


@dataclass(frozen=True)
class Drawn:
    """Drawn wires: layout and construction of those modelled; of the whole specimen parts with terminals, and joints.

    images: by name what each wire of the whole specimen is made of.
    """

    layout: WireLayout
    constructions: tuple[Construction, ...]
    parts: tuple[PartSpec, ...]
    terminals: tuple[Terminal, ...]
    joints: tuple[WireJoint, ...]
    images: Mapping[str, tuple[Image, ...]]

    @property
    def held(self) -> Array:
        """Modelled wire and coordinate along it (n, 2) where it cannot slide: joints, and terminals of rigid lands."""
        number = {name: wire for wire, name in enumerate(self.layout.names)}
        places = [(item.wire, item.along_mm) for item in self.terminals if self.parts[item.part].rigid]
        for joint in self.joints:
            places += list(zip(joint.wires, joint.along_mm, strict=True))
        found = [(number[name], along) for name, along in places if name in number]
        return np.array(found, dtype=float).reshape(-1, 2)


def drawn_wires(case: Case) -> Drawn:
    """Return the drawn wires of a case; raises BadInput with everything that is wrong in case and drawing."""
    wires = case.wires
    if wires is None or not wires.drawn:
        raise ValueError("the case has no drawn wires")
    return _drawn(
        wires,
        case.pattern,
        "side" if case.worn and case.fabric.portion == "half" else case.fabric.portion,
        _stamp(wires),
    )


def _stamp(wires: Wires) -> int:
    """Return when the drawing was changed last, so that what is kept of it is what the file says now."""
    return Path(wires.layout).stat().st_mtime_ns if wires.layout and Path(wires.layout).is_file() else 0


@lru_cache(maxsize=8)
def _drawn(wires: Wires, size: tuple[float, float], portion: str, stamp: int) -> Drawn:
    """Return the drawn wires of a section for a piece of this size; `stamp` tells versions of the drawing apart."""
    length, width = size
    drawing = _drawing(wires)
    specs, problems = path_specs(wires, drawing, length, width)
    parts, found = part_specs(wires, drawing)
    problems += found
    if wires.first_offset != 0.0:
        specs = [shifted(spec, wires.first_offset, width) for spec in specs]
        parts = [replace(part, at=(part.at[0], part.at[1] + wires.first_offset)) for part in parts]
    layout = _laid(specs, problems, length, width, portion)
    if layout is None:  # there are no lines that parts could lie on
        raise BadInput(problems)
    found_terminals, more = terminals(parts, specs, length_mm=length, width_mm=width)
    problems += more
    problems += list(_joint_problems(wires, specs))
    by_name = {path.name: path for path in wires.paths}
    made = {spec.name: construction(wires, by_name.get(spec.name)) for spec in specs}
    if not problems:
        problems += unmirrored(parts, found_terminals, specs, portion)  # type: ignore[arg-type]
        problems += _unlike_images(wires, specs, made, portion)
    problems += list(_net_problems(wires, specs, parts, found_terminals))
    if problems:
        raise BadInput(problems)
    constructions = tuple(made[name] for name in layout.names)
    whole = images(specs, layout, portion)  # type: ignore[arg-type]
    return Drawn(layout, constructions, tuple(parts), found_terminals, _joints(wires, specs), whole)


def _unlike_images(
    wires: Wires, specs: list[PathSpec], made: Mapping[str, Construction], portion: str
) -> list[Problem]:
    """Return wires that are made otherwise than their mirror images, and joints that have none."""
    problems = []
    joined = {frozenset(pair) for pair in wires.joined}
    for mirror in MIRRORS[portion]:
        image = mirrored_names(specs, mirror)
        for spec in specs:
            other = image[spec.name]
            if made[other] != made[spec.name]:
                text = f"a {portion} mirrors this: wire {spec.name!r} is made otherwise than its image {other!r}"
                problems.append(spec.origin.problem(f"{text}; make them alike, or set fabric.portion to whole"))
        for index, pair in enumerate(wires.joined):
            first, second = (image[name] for name in pair)
            if frozenset((first, second)) not in joined:
                text = f"a {portion} mirrors this joint: {first!r} and {second!r} are not joined"
                remedy = "join them too, or set fabric.portion to whole"
                problems.append(Problem(f"{text}; {remedy}", key=f"wires.joined.{index}"))
    return list({problem.message: problem for problem in problems}.values())


def shifted(spec: PathSpec, by: float, width: float) -> PathSpec:
    """Return a wire shifted across by `by` mm; one along the weft ends at the edge of the piece at most."""

    def moved(place: tuple[float, float]) -> tuple[float, float]:
        y = place[1] + by
        return (place[0], min(max(y, -width / 2), width / 2) if spec.kind == ALONG_WEFT else y)

    def at(loop: LoopSpec) -> LoopSpec:
        if isinstance(loop.at, tuple):
            return replace(loop, at=(loop.at[0], loop.at[1] + by))
        return replace(loop, at=loop.at + by) if spec.kind == ALONG_WEFT else loop

    return replace(spec, points=tuple(map(moved, spec.points)), loops=tuple(map(at, spec.loops)))


def _laid(
    specs: list[PathSpec], problems: list[Problem], length: float, width: float, portion: str
) -> WireLayout | None:
    """Return the layout, or None after adding to the problems."""
    try:
        return lay_paths(specs, length_mm=length, width_mm=width, portion=portion)[0]  # type: ignore[arg-type]
    except BadInput as error:
        problems += error.problems
        return None


def _drawing(wires: Wires) -> Drawing | None:
    """Return what the drawing of a case holds."""
    if wires.layout is None:
        return None
    from wires.drawing_files import read_drawing

    return read_drawing(Path(wires.layout), units=wires.layout_units, slack=wires.loops.slack if wires.loops else 0.02)


def drawing_of(case: Case) -> Drawing:
    """Return the drawn wires and parts of a case for the whole specimen; raises BadInput as `drawn_wires`."""
    from wires.drawing import Drawing

    wires = case.wires
    if wires is None or not wires.drawn:
        raise ValueError("the case has no drawn wires")
    drawn_wires(case)
    drawing = _drawing(wires)
    specs, _ = path_specs(wires, drawing, *case.pattern)
    return Drawing(tuple(specs), tuple(part_specs(wires, drawing)[0]))


def path_specs(
    wires: Wires, drawing: Drawing | None, length: float, width: float
) -> tuple[list[PathSpec], list[Problem]]:
    """Return the wires of a case and its drawing as specifications, and what is wrong with their names."""
    named = {path.name: (index, path) for index, path in enumerate(wires.paths)}
    specs: list[PathSpec] = []
    problems: list[Problem] = []
    for spec in () if drawing is None else drawing.wires:
        index, path = named.get(spec.name, (0, None))
        own = None if path is None or path.loops is None else _loop_specs(path, f"wires.paths.{index}", spec.along)
        specs.append(spec if own is None else replace(spec, loops=own))
    known = [spec.name for spec in specs]
    for index, path in enumerate(wires.paths):
        origin = Origin(key=f"wires.paths.{index}")
        if path.along is None and path.path is None:
            if path.name not in known:
                text = f"the drawing has no wire of this name (got {path.name!r}){nearest(path.name, known)}"
                problems.append(origin.problem(text, key="name"))
            continue
        specs.append(_path_spec(path, origin, length, width))
    return specs, problems


def _path_spec(path: WirePath, origin: Origin, length: float, width: float) -> PathSpec:
    if path.path is not None:
        spec = PathSpec(path.name, LAID, tuple(path.path), (), origin)
    else:
        kind = ALONG_WARP if path.along == "warp" else ALONG_WEFT
        reach = (length if kind == ALONG_WARP else width) / 2
        start, end = path.extent
        start, end = -reach if start is None else start, reach if end is None else end
        at = float(path.at or 0.0)
        points = ((start, at), (end, at)) if kind == ALONG_WARP else ((at, start), (at, end))
        spec = PathSpec(path.name, kind, points, (), origin)
    if not path.loops:
        return spec
    along = spec.along if len(spec.points) > 1 else np.zeros(1)
    return PathSpec(spec.name, spec.kind, spec.points, _loop_specs(path, origin.key, along), origin)


def _loop_specs(path: WirePath, key: str, along: Array) -> tuple[LoopSpec, ...]:
    """Return the loops of a path: those it lists, or regular ones that keep half a loop from its ends."""
    if isinstance(path.loops, Loops):
        from wires.layout import comb

        item, reach = path.loops, float(np.abs(along).max())
        low, high = along.min() + item.length, along.max() - item.length
        spots = comb(item.offset, item.spacing, reach, key=f"{key}.loops.spacing")
        centres = [c for c in spots if low - 1e-9 <= c <= high + 1e-9]
        origin = Origin(key=f"{key}.loops")
        return tuple(LoopSpec(float(c), item.length, item.slack, item.component, origin) for c in centres)
    return tuple(
        LoopSpec(loop.at, loop.length, loop.slack, loop.component, Origin(key=f"{key}.loops.{number}"))
        for number, loop in enumerate(path.loops or ())
    )


def part_specs(wires: Wires, drawing: Drawing | None) -> tuple[list[PartSpec], list[Problem]]:
    """Return the parts of a case and its drawing, and what is wrong with their names."""
    named = {item.name: item for item in wires.components}
    parts: list[PartSpec] = []
    problems: list[Problem] = []
    for part in () if drawing is None else drawing.parts:
        own = named.get(part.name)
        parts.append(part if own is None else _part(own, own.at or part.at, part.origin))
    known = [part.name for part in parts]
    for index, item in enumerate(wires.components):
        origin = Origin(key=f"wires.components.{index}")
        if item.name in known:
            continue
        if item.at is None:
            hint = nearest(item.name, known)
            text = f"no place is given and no part {item.name!r} is drawn{hint}, write at: [warp, weft]"
            problems.append(origin.problem(text, key="at"))
            continue
        parts.append(_part(item, item.at, origin))
    return parts, problems


def _part(item: Component, at: tuple[float, float], origin: Origin) -> PartSpec:
    return PartSpec(item.name, at, item.interposer or item.size, item.connects or None, item.rigid, origin)


def construction(wires: Wires, path: WirePath | None) -> Construction:
    """Return what a wire is made of: its own keys, else those of the section."""

    def own(name: str) -> object:
        value = None if path is None else getattr(path, name)
        return getattr(wires, name) if value is None else value

    names = ("material", "filaments", "filament_diameter", "crimp", "bond")
    return Construction(*(own(name) for name in names))  # type: ignore[arg-type]


def _joint_problems(wires: Wires, specs: list[PathSpec]) -> Iterator[Problem]:
    lines = {spec.name: spec.line for spec in specs}
    for index, pair in enumerate(wires.joined):
        key = f"wires.joined.{index}"
        unknown = [name for name in pair if name not in lines]
        for name in unknown:
            yield Problem(f"no such wire (got {name!r}){nearest(name, lines)}", key=key)
        if not unknown and not len(crossings(lines[pair[0]], lines[pair[1]])):
            yield Problem(f"wires {pair[0]!r} and {pair[1]!r} do not cross, so they cannot be joined", key=key)


def _joints(wires: Wires, specs: list[PathSpec]) -> tuple[WireJoint, ...]:
    """Return every crossing of wires that are joined."""
    lines = {spec.name: spec for spec in specs}
    found = []
    for pair in wires.joined:
        both = [(lines[name].line, lines[name].along) for name in pair]
        for place in crossings(both[0][0], both[1][0]):
            at = [snap(*line, (float(place[0]), float(place[1])))[0] for line in both]
            found.append(WireJoint(pair, (at[0], at[1])))
    return tuple(found)


def _net_problems(
    wires: Wires, specs: list[PathSpec], parts: list[PartSpec], ends: tuple[Terminal, ...]
) -> Iterator[Problem]:
    """Yield names that nets get wrong, and parts that a net does not reach by its wires."""
    lines, names = [spec.name for spec in specs], [part.name for part in parts]
    for index, net in enumerate(wires.nets):
        wrong = False
        for key, given, known in (("wires", net.wires, lines), ("parts", net.parts, names)):
            for name in given:
                if name not in known:
                    wrong = True
                    what = f"no such {key[:-1]} (got {name!r}){nearest(name, known)}"
                    yield Problem(f"net {net.name!r}: {what}", key=f"wires.nets.{index}.{key}")
        touched = {parts[item.part].name for item in ends if item.wire in net.wires}
        for name in net.parts:
            if name in names and net.wires and name not in touched:
                wrong = True
                text = f"net {net.name!r} has no path to part {name!r}: none of its wires is connected to it"
                yield Problem(text, key=f"wires.nets.{index}.parts")
        apart = [] if wrong or not net.wires else _apart(net, wires.joined, parts, ends)
        if apart:
            first = next(name for name in net.wires if name not in apart)
            are = f"{' and '.join(map(repr, apart))} {'is' if len(apart) == 1 else 'are'}"
            text = (
                f"net {net.name!r}: {are} not connected with {first!r}; join them where they cross (wires.joined), add "
                "a wire that crosses both, or name a part of the net that both connect to"
            )
            yield Problem(text, key=f"wires.nets.{index}.wires")


def _apart(
    net: Net, joined: Sequence[tuple[str, str]], parts: Sequence[PartSpec], ends: Sequence[Terminal]
) -> list[str]:
    """Return the wires of a net that neither joints nor parts of the net connect with its first part."""
    at_part = {
        name: {item.wire for item in ends if parts[item.part].name == name and item.wire in net.wires}
        for name in net.parts
    }
    links = [group for group in (*at_part.values(), *map(set, joined)) if group <= set(net.wires)]
    reached = set(at_part[net.parts[0]])
    while any(group & reached and not group <= reached for group in links):
        reached |= set().union(*(group for group in links if group & reached))
    return [name for name in net.wires if name not in reached]
