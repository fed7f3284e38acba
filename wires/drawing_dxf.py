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
from wires.drawing import DEFAULT_LAND_MM, UNITS, Drawing, kind_of
from wires.drawing_chain import GAP_MM, chained
from wires.drawing_csv import place_of
from wires.drawing_curves import NoCurve, place_of_circle, place_of_point, points_of
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
SOLIDS = ("AcDbPolyFaceMesh", "AcDbPolygonMesh")
"""Polylines that are surfaces."""


def read_dxf(path: Path, *, units: str | None, slack: float) -> Drawing:
    """Return the wires and parts of a DXF file; raises BadInput with everything that is wrong in it."""
    document = _opened(path)
    scale = UNITS[_unit(document, path, units)]
    layers, problems = _by_layer(document, path)
    wires, parts = [], []
    for layer, entities in layers.items():
        try:
            if any(entity.dxftype() == "POINT" for entity in entities) or all(_closed(entity) for entity in entities):
                parts.append(_part(layer, entities, path, scale))
            else:
                wires.append(_wire(layer, entities, path, scale, slack))
        except BadInput as error:
            problems += error.problems
    if problems:
        raise BadInput(problems)
    return Drawing(tuple(wires), tuple(parts))


def _by_layer(document: Any, path: Path) -> tuple[dict[str, list[Any]], list[Problem]]:
    """Return what is drawn by layer, whose name may be written with small letters or capitals, and what is no line."""
    problems: list[Problem] = []
    layers: dict[str, list[Any]] = {}
    names: dict[str, str] = {}
    for entity in document.modelspace():
        layer = str(entity.dxf.layer)
        if entity.dxftype() in SILENT or layer.startswith("_") or layer.lower() == "defpoints":
            continue
        surface = entity.dxftype() == "POLYLINE" and entity.get_mode() in SOLIDS
        if surface or entity.dxftype() not in (*LINES, "POINT", "CIRCLE"):
            text = f"cannot be read, draw wires with {', '.join(LINES[:3])} (or explode the block)"
            problems.append(_origin(path, entity).problem(text))
            continue
        layers.setdefault(names.setdefault(layer.lower(), layer), []).append(entity)
    return layers, problems


def _opened(path: Path) -> Any:
    """Return the document of a DXF file."""
    from ezdxf.filemanagement import readfile

    read_bounded(path, MOST_BYTES)
    try:
        return readfile(path)
    except Exception as error:  # the library meets a broken file with whatever its parts raise
        raise BadInput.of(f"not a DXF file that can be read: {str(error)[:120]}", file=str(path)) from None


def _unit(document: Any, path: Path, units: str | None) -> str:
    """Return the unit of a drawing: its own, else that of the case; raises BadInput when nobody says it."""
    try:
        code = int(document.header.get("$INSUNITS", 0))
    except (TypeError, ValueError):
        text = "the drawing's unit ($INSUNITS) is no number that can be read, set it in the CAD program"
        raise BadInput.of(text, file=str(path)) from None
    if code == 0:
        if units is None:
            text = "the drawing does not say its unit ($INSUNITS is 0), set it in the CAD program"
            raise BadInput.of(f"{text} or give wires.layout_units", file=str(path))
        return units
    if code not in INSUNITS:
        text = f"the drawing is in unit {code} ($INSUNITS, {_name_of_unit(code)}), known are {', '.join(UNITS)}"
        raise BadInput.of(f"{text}: set it in the CAD program", file=str(path))
    if units is not None and units != INSUNITS[code]:
        text = f"the drawing is in {INSUNITS[code]} ($INSUNITS), but wires.layout_units says {units}"
        raise BadInput.of(text, file=str(path))
    return INSUNITS[code]


def _name_of_unit(code: int) -> str:
    """Return the name of a unit of DXF."""
    from ezdxf.enums import InsertUnits

    return next((item.name.lower() for item in InsertUnits if item.value == code), "of no name")


def _origin(path: Path, entity: Any) -> Origin:
    return Origin(str(path), key=f"{entity.dxftype()} #{entity.dxf.handle} on layer {entity.dxf.layer}")


def _closed(entity: Any) -> bool:
    """Tell whether an entity is a closed outline."""
    return entity.dxftype() in ("LWPOLYLINE", "POLYLINE") and bool(entity.is_closed)


def _noted(entity: Any) -> list[Any]:
    """Return what stands in our extended data."""
    return [tag.value for tag in entity.get_xdata(APP)][1:] if entity.has_xdata(APP) else []


def _said(entity: Any, path: Path, text: str) -> BadInput:
    """Return the error about an entity."""
    return BadInput([_origin(path, entity).problem(text)])


def _points(entity: Any, path: Path, scale: float) -> Array:
    """Return the vertices (n, 2) of a line in mm; raises BadInput for what cannot be drawn."""
    try:
        return points_of(entity, scale)
    except NoCurve as error:
        raise _said(entity, path, f"the line on layer {entity.dxf.layer!r} {error}") from None


def _part(layer: str, entities: Sequence[Any], path: Path, scale: float) -> PartSpec:
    """Return the part that a layer names; raises BadInput with what is wrong with it."""
    points = [entity for entity in entities if entity.dxftype() == "POINT"]
    outlines = [entity for entity in entities if entity.dxftype() != "POINT"]
    if len(points) > 1:
        raise _said(points[1], path, f"a second part named {layer!r}, each part has a layer of its own")
    if len(outlines) > 1 or any(not _closed(entity) for entity in outlines):
        raise _said(outlines[-1], path, f"layer {layer!r} holds a point and open lines: is it a part or a wire?")
    size, connects, rigid = DEFAULT_LAND_MM, None, True
    at = (0.0, 0.0)
    if outlines:
        box = _points(outlines[0], path, scale)
        if not len(box):
            raise _said(outlines[0], path, f"the outline of part {layer!r} has no vertices")
        size = (float(np.ptp(box[:, 0])), float(np.ptp(box[:, 1])))
        middle = 0.5 * (box.min(axis=0) + box.max(axis=0))
        at = (float(middle[0]), float(middle[1]))
    if points:
        try:
            at = place_of_point(points[0], scale)
        except NoCurve as error:
            raise _said(points[0], path, f"part {layer!r} {error}") from None
        noted = _noted(points[0])
        connects = tuple(name for name in noted if isinstance(name, str)) or None
        rigid = LOOSE not in noted
    return PartSpec(layer, at, size, connects, rigid, _origin(path, (points or outlines)[0]))


def _wire(layer: str, entities: Sequence[Any], path: Path, scale: float, slack: float) -> PathSpec:
    """Return the wire that a layer names; raises BadInput with what is wrong with it."""
    lines = [entity for entity in entities if entity.dxftype() in LINES]
    if not lines:
        raise _said(entities[0], path, f"layer {layer!r} holds loops (circles), but no line of a wire")
    drawn = [_points(entity, path, scale) for entity in lines]
    for entity, points in zip(lines, drawn, strict=True):
        if len(points) < 2 or np.linalg.norm(np.ptp(points, axis=0)) < GAP_MM:
            raise _said(entity, path, f"a line of wire {layer!r} has no length")
    chain, wrong = chained(drawn)
    if chain is None:
        raise _said(lines[-1], path, f"wire {layer!r} {wrong}")
    laid = any("laid" in _noted(entity) for entity in lines)
    kind, plain = kind_of(chain, laid=laid)
    circles = [entity for entity in entities if entity.dxftype() == "CIRCLE"]
    loops = tuple(_loop(entity, path, scale, slack) for entity in circles)
    return PathSpec(layer, kind, plain, loops, _origin(path, lines[0]))


def _loop(entity: Any, path: Path, scale: float, slack: float) -> LoopSpec:
    """Return the loop that a circle stands for; raises BadInput for a circle of no place."""
    try:
        centre = place_of_circle(entity, scale)
    except NoCurve as error:
        raise _said(entity, path, f"the circle on layer {entity.dxf.layer!r} {error}") from None
    noted = [float(value) for value in _noted(entity)]
    own_slack, rigid = noted if len(noted) == 2 else (slack, 0.0)
    return LoopSpec(centre, round(2.0 * float(entity.dxf.radius) * scale, 9), own_slack, rigid, _origin(path, entity))


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
