"""Drawings as DXF: the layer of a line names a wire, that of a point or closed outline a part, circles are loops.

Lines, polylines, arcs, ellipses and splines of a layer are chained to one wire, curves as chords within 0.02 mm. A
circle on the layer of a wire is a loop as long as its diameter. Texts, dimensions and layers that begin with `_` are
left out. What DXF has no word for (slack, parts in loops, what a part connects, that a straight wire is laid) stands in
extended data under the name ETEXTILE, which `etextile layout` writes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from etextile.errors import BadInput, Problem
from etextile.files import read_bounded, replacing
from etextile.results.wire_layout import LAID
from etextile.types import Array
from wires.drawing import DEFAULT_LAND_MM, UNITS, Drawing, kind_of, shown
from wires.drawing_csv import place_of
from wires.drawn import LoopSpec, Origin, PathSpec
from wires.parts import PartSpec


APP = "ETEXTILE"
MOST_BYTES = 50_000_000
INSUNITS = {1: "in", 4: "mm", 5: "cm", 6: "m", 13: "um"}
LINES = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "ELLIPSE", "SPLINE")
SILENT = ("TEXT", "MTEXT", "DIMENSION", "LEADER", "MULTILEADER", "ATTDEF", "HATCH", "VIEWPORT")
FORBIDDEN = '<>/\\":;?*=|`'
"""Characters that names of layers cannot have."""
LOOSE = 0
"""Number in the extended data of a part that does not hold the fabric under it."""
CHORD_MM = 0.02
GAP_MM = 0.01
"""Ends of lines this close to each other are one place."""


def read_dxf(path: Path, *, units: str | None, slack: float) -> Drawing:
    """Return the wires and parts of a DXF file; raises BadInput with everything that is wrong in it."""
    document = _opened(path)
    scale = UNITS[_unit(document, path, units)]
    problems: list[Problem] = []
    layers: dict[str, list[Any]] = {}
    for entity in document.modelspace():
        layer = str(entity.dxf.layer)
        if entity.dxftype() in SILENT or layer.startswith("_") or layer.lower() == "defpoints":
            continue
        if entity.dxftype() not in (*LINES, "POINT", "CIRCLE"):
            text = f"cannot be read, draw wires with {', '.join(LINES[:3])} (or explode the block)"
            problems.append(_origin(path, entity).problem(text))
            continue
        layers.setdefault(layer, []).append(entity)
    wires, parts = [], []
    for layer, entities in layers.items():
        if any(entity.dxftype() == "POINT" for entity in entities) or all(_closed(entity) for entity in entities):
            part, found = _part(layer, entities, path, scale)
            parts += [part] if part is not None else []
        else:
            wire, found = _wire(layer, entities, path, scale, slack)
            wires += [wire] if wire is not None else []
        problems += found
    if problems:
        raise BadInput(problems)
    return Drawing(tuple(wires), tuple(parts))


def _opened(path: Path) -> Any:
    """Return the document of a DXF file."""
    from ezdxf.filemanagement import readfile
    from ezdxf.lldxf.const import DXFError

    read_bounded(path, MOST_BYTES)
    try:
        return readfile(path)
    except (DXFError, OSError, UnicodeError, ValueError, IndexError, KeyError) as error:
        raise BadInput.of(f"not a DXF file that can be read: {str(error)[:120]}", file=str(path)) from None


def _unit(document: Any, path: Path, units: str | None) -> str:
    """Return the unit of a drawing: its own, else that of the case; raises BadInput when nobody says it."""
    code = int(document.header.get("$INSUNITS", 0))
    if code == 0:
        if units is None:
            text = "the drawing does not say its unit ($INSUNITS is 0), set it in the CAD program"
            raise BadInput.of(f"{text} or give wires.layout_units", file=str(path))
        return units
    if code not in INSUNITS:
        raise BadInput.of(f"the drawing is in unit {code} ($INSUNITS), known are {', '.join(UNITS)}", file=str(path))
    if units is not None and units != INSUNITS[code]:
        text = f"the drawing is in {INSUNITS[code]} ($INSUNITS), but wires.layout_units says {units}"
        raise BadInput.of(text, file=str(path))
    return INSUNITS[code]


def _origin(path: Path, entity: Any) -> Origin:
    return Origin(str(path), key=f"{entity.dxftype()} #{entity.dxf.handle} on layer {entity.dxf.layer}")


def _closed(entity: Any) -> bool:
    """Tell whether an entity is a closed outline."""
    return entity.dxftype() in ("LWPOLYLINE", "POLYLINE") and bool(entity.is_closed)


def _noted(entity: Any) -> list[Any]:
    """Return what stands in our extended data."""
    return [tag.value for tag in entity.get_xdata(APP)][1:] if entity.has_xdata(APP) else []


def _points(entity: Any, scale: float) -> Array:
    """Return the vertices (n, 2) of a line in mm: as they were written where no piece is an arc."""
    from ezdxf.path import make_path

    kind = entity.dxftype()
    if kind == "LINE":
        return np.array([(end.x, end.y) for end in (entity.dxf.start, entity.dxf.end)]) * scale
    if kind == "LWPOLYLINE" and not entity.has_arc and tuple(entity.dxf.extrusion) == (0.0, 0.0, 1.0):
        own = np.array(list(entity.get_points("xy"))) * scale
        return np.concatenate([own, own[:1]]) if entity.is_closed else own
    chain = np.array([(point.x, point.y) for point in make_path(entity).flattening(CHORD_MM / scale)]) * scale
    return np.round(chain, 9)


def _part(layer: str, entities: Sequence[Any], path: Path, scale: float) -> tuple[PartSpec | None, list[Problem]]:
    """Return the part that a layer names, and what is wrong with it."""
    points = [entity for entity in entities if entity.dxftype() == "POINT"]
    outlines = [entity for entity in entities if entity.dxftype() != "POINT"]
    if len(points) > 1:
        text = f"a second part named {layer!r}, each part has a layer of its own"
        return None, [_origin(path, points[1]).problem(text)]
    if len(outlines) > 1 or any(not _closed(entity) for entity in outlines):
        text = f"layer {layer!r} holds a point and open lines: is it a part or a wire?"
        return None, [_origin(path, outlines[-1]).problem(text)]
    size, connects, rigid = DEFAULT_LAND_MM, None, True
    box = _points(outlines[0], scale) if outlines else None
    if box is not None:
        size = (float(np.ptp(box[:, 0])), float(np.ptp(box[:, 1])))
        at = 0.5 * (box.min(axis=0) + box.max(axis=0))
    origin = _origin(path, (points or outlines)[0])
    if points:
        place = points[0].dxf.location
        at = np.round(np.array([place.x, place.y]) * scale, 9)
        noted = _noted(points[0])
        connects = tuple(name for name in noted if isinstance(name, str)) or None
        rigid = LOOSE not in noted
    return PartSpec(layer, (float(at[0]), float(at[1])), size, connects, rigid, origin), []


def _wire(
    layer: str, entities: Sequence[Any], path: Path, scale: float, slack: float
) -> tuple[PathSpec | None, list[Problem]]:
    """Return the wire that a layer names, and what is wrong with it."""
    lines = [entity for entity in entities if entity.dxftype() in LINES]
    if not lines:
        text = f"layer {layer!r} holds loops (circles), but no line of a wire"
        return None, [_origin(path, entities[0]).problem(text)]
    short = [entity for entity in lines if np.linalg.norm(np.ptp(_points(entity, scale), axis=0)) < GAP_MM]
    if short:
        return None, [_origin(path, short[0]).problem(f"a line of wire {layer!r} has no length")]
    points, wrong = _chained([_points(entity, scale) for entity in lines])
    if points is None:
        return None, [_origin(path, lines[-1]).problem(f"wire {layer!r} {wrong}")]
    laid = any("laid" in _noted(entity) for entity in lines)
    kind, plain = kind_of(points, laid=laid)
    circles = [entity for entity in entities if entity.dxftype() == "CIRCLE"]
    loops = tuple(_loop(entity, path, scale, slack) for entity in circles)
    return PathSpec(layer, kind, plain, loops, _origin(path, lines[0])), []


def _loop(entity: Any, path: Path, scale: float, slack: float) -> LoopSpec:
    centre = np.round(np.array([entity.dxf.center.x, entity.dxf.center.y]) * scale, 9)
    noted = [float(value) for value in _noted(entity)]
    own_slack, rigid = noted if len(noted) == 2 else (slack, 0.0)
    length = round(2.0 * float(entity.dxf.radius) * scale, 9)
    return LoopSpec((float(centre[0]), float(centre[1])), length, own_slack, rigid, _origin(path, entity))


def _chained(lines: list[Array]) -> tuple[Array | None, str]:
    """Return the vertices of lines put end to end, or what keeps them apart."""
    chain, left = lines[0], list(lines[1:])
    while left:
        nearest, turned, at_start, best = 0, False, False, np.inf
        for index, line in enumerate(left):
            for turn in (False, True):
                way = line[::-1] if turn else line
                for start in (False, True):
                    gap = float(np.linalg.norm(way[-1] - chain[0] if start else way[0] - chain[-1]))
                    if gap < best:
                        nearest, turned, at_start, best = index, turn, start, gap
        if best > GAP_MM:
            end = chain[0] if at_start else chain[-1]
            return None, f"has open ends: a gap of {best:.3g} mm at {shown(end)}, one layer is one unbroken line"
        way = left.pop(nearest)
        way = way[::-1] if turned else way
        chain = np.concatenate([way[:-1], chain]) if at_start else np.concatenate([chain, way[1:]])
    return chain, ""


def write_dxf(drawing: Drawing, path: Path) -> None:
    """Write a drawing as DXF R2010 in mm."""
    from ezdxf.filemanagement import new

    _check_names([*drawing.wires, *drawing.parts], path)
    document = new("R2010", units=4)
    document.appids.new(APP)
    space = document.modelspace()
    for number, spec in enumerate(drawing.wires):
        layer = spec.name
        _add_layer(document, layer, color=1 + number % 6)
        line = space.add_lwpolyline(spec.points, dxfattribs={"layer": layer})
        if spec.kind == LAID and kind_of(spec.line)[0] != LAID:
            line.set_xdata(APP, [(1000, "etextile"), (1000, "laid")])
        for loop in spec.loops:
            circle = space.add_circle(place_of(spec, loop), loop.length_mm / 2, dxfattribs={"layer": layer})
            circle.set_xdata(APP, [(1000, "etextile"), (1040, loop.slack), (1040, loop.rigid_mm)])
    for part in drawing.parts:
        _add_layer(document, part.name, color=7)
        point = space.add_point(part.at, dxfattribs={"layer": part.name})
        more = [*((1000, name) for name in part.connects or ()), *(() if part.rigid else ((1070, LOOSE),))]
        if more:
            point.set_xdata(APP, [(1000, "etextile"), *more])
        space.add_lwpolyline(list(_corners(part)), close=True, dxfattribs={"layer": part.name})
        x, y = part.at
        space.add_text(part.name, height=1.5, dxfattribs={"layer": part.name}).set_placement(
            (x + part.size[0] / 2 + 0.5, y + part.size[1] / 2 + 0.5)
        )
    with replacing(path) as beside:
        document.saveas(beside)


def _check_names(items: Sequence[PathSpec | PartSpec], path: Path) -> None:
    """Raise BadInput for names that no layer can have, or that the reader would take for another or for a remark."""
    seen: dict[str, str] = {}
    problems = []
    for item in items:
        key = item.name.lower()
        if not set(item.name).isdisjoint(FORBIDDEN) or item.name.startswith("_") or key == "defpoints":
            text = f"a layer of a DXF file cannot be named {item.name!r}; rename it, or write a .csv file"
            problems.append(Problem(text, str(path)))
        elif key in seen:
            text = f"{seen[key]!r} and {item.name!r} would share a layer of the DXF file; rename one, or write a .csv"
            problems.append(Problem(f"{text} file", str(path)))
        seen.setdefault(key, item.name)
    if problems:
        raise BadInput(problems)


def _add_layer(document: Any, name: str, *, color: int) -> None:
    """Add a layer; the layer 0 is there already."""
    if document.layers.has_entry(name):
        document.layers.get(name).color = color
    else:
        document.layers.add(name, color=color)


def _corners(part: PartSpec) -> Iterator[tuple[float, float]]:
    x, y = part.at
    half = part.size[0] / 2, part.size[1] / 2
    for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
        yield x + a * half[0], y + b * half[1]
