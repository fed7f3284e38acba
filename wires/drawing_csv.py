"""Drawings as tables: one row per vertex of a wire, loop or part, units in the names of the columns.

kind,name,x_mm,y_mm,length_mm,slack,rigid_mm,size_x_mm,size_y_mm,connects,held
wire,VCC,-60,-12,,,,,,,
wire,VCC,60,-12,,,,,,,
loop,VCC,0,-12,6,0.04,3,,,,
part,LED1,0,-12,,,,3,3,VCC;GND,

`held` is empty, `laid` for a straight wire that is stitched on instead of woven in, `loose` for a part that leaves the
fabric under it as it is.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from etextile.errors import BadInput, Problem, nearest
from etextile.files import read_bounded, write_table
from etextile.results.wire_layout import LAID
from wires.drawing import DEFAULT_LAND_MM, DEFAULT_LOOP_MM, UNITS, Drawing, kind_of
from wires.drawn import LoopSpec, Origin, PathSpec
from wires.parts import PartSpec


LENGTHS = ("x", "y", "length", "rigid", "size_x", "size_y")
OTHERS = ("kind", "name", "slack", "connects", "held")
COLUMNS = (
    "kind",
    "name",
    "x_mm",
    "y_mm",
    "length_mm",
    "slack",
    "rigid_mm",
    "size_x_mm",
    "size_y_mm",
    "connects",
    "held",
)
PLAIN = re.compile(r"[-+0-9.,eE]+")
"""Characters of a number: no digits of other scripts, no underscores, no words."""
MOST_ROWS = 200_000
MOST_LETTERS = 100_000
"""Characters of a line; the reader of tables takes no longer cells."""
MOST_BYTES = 50_000_000


class DrawingRows:
    """The rows of a file by column, with lengths in mm, and what is wrong in them."""

    def __init__(self, path: Path, units: str | None) -> None:
        """Read the text and the names of the columns; raises BadInput for what is no such table."""
        self.path = path
        try:
            text = read_bounded(path, MOST_BYTES).decode("utf-8-sig")
        except UnicodeDecodeError:
            raise BadInput.of("not UTF-8 text: save the table as CSV in UTF-8", file=str(path)) from None
        lines = list(enumerate(re.split(r"\r\n|\r|\n", text), start=1))
        lines = [(number, line) for number, line in lines if line.strip() and not line.lstrip().startswith("#")]
        if long := next((number for number, line in lines if len(line) > MOST_LETTERS), None):
            raise BadInput.of(f"a line of more than {MOST_LETTERS} characters is no row", file=str(path), line=long)
        if not lines:
            raise BadInput.of("the table is empty", file=str(path))
        if len(lines) > MOST_ROWS:
            raise BadInput.of(f"the table has {len(lines)} rows, at most {MOST_ROWS} are taken", file=str(path))
        head = lines[0][1]
        self.delimiter = max(",;\t", key=head.count)
        self.comma = self.delimiter != ","
        self.problems: list[Problem] = []
        self.scale: dict[str, float] = {}
        self.index: dict[str, int] = {}
        self._columns(next(csv.reader([head], delimiter=self.delimiter)), lines[0][0], units)
        self.lines = lines[1:]

    def _columns(self, names: list[str], line: int, units: str | None) -> None:
        """Find the columns and their units."""
        unsaid: list[str] = []
        names_in: list[str] = []
        for place, raw in enumerate(names):
            name = raw.strip().lower()
            base, _, unit = name.rpartition("_")
            names_in.append(base if base in LENGTHS and unit in UNITS else name)
            if name in OTHERS:
                self.index[name] = place
                continue
            if base in LENGTHS and unit in UNITS:
                self.index[base], self.scale[base] = place, UNITS[unit]
            elif name in LENGTHS:
                self.index[name] = place
                self.scale[name] = UNITS.get(units or "", np.nan)
                unsaid += [] if units else [name]
            else:
                known = COLUMNS
                text = f"unknown column (got {raw.strip()[:40]!r}), known are {', '.join(known)}{nearest(name, known)}"
                self.problems.append(Problem(text, str(self.path), line))
        if unsaid:
            names_of = ", ".join(unsaid)
            text = f"columns {names_of} do not say their unit: name them {unsaid[0]}_mm or give wires.layout_units"
            self.problems.append(Problem(text, str(self.path), line))
        again = [name for name in self.index if names_in.count(name) > 1]
        if again:
            text = f"column {again[0]} stands {names_in.count(again[0])} times, keep one"
            self.problems.append(Problem(text, str(self.path), line))
        missing = [name for name in ("kind", "name", "x", "y") if name not in self.index]
        if missing:
            text = f"columns {', '.join(missing)} are missing, a table begins with {','.join(COLUMNS[:4])}"
            self.problems.append(Problem(text, str(self.path), line))
        if self.problems:
            raise BadInput(self.problems)

    def rows(self) -> Iterator[tuple[int, dict[str, str]]]:
        """Yield line number and cells by column."""
        for number, line in self.lines:
            cells = next(csv.reader([line], delimiter=self.delimiter))
            yield number, {name: cells[k].strip() for name, k in self.index.items() if k < len(cells)}

    def number(self, line: int, cells: dict[str, str], name: str, default: float | None = None) -> float:
        """Return a number of a row, lengths in mm; what is wrong is noted and NaN returned."""
        text = cells.get(name, "")
        if not text and default is not None:
            return default
        try:
            value = float(text.replace(",", ".") if self.comma else text) if PLAIN.fullmatch(text) else np.nan
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            what = f"column {name} is no number (got {text[:40]!r})" if text else f"column {name} is empty"
            self.problems.append(Problem(what, str(self.path), line))
            return float("nan")
        return value * self.scale.get(name, 1.0)


def read_csv(path: Path, *, units: str | None, slack: float) -> Drawing:
    """Return the wires and parts of a table; raises BadInput with everything that is wrong in it."""
    table = DrawingRows(path, units)
    vertices: dict[str, list[tuple[float, float]]] = {}
    first: dict[str, tuple[int, bool]] = {}
    loops: dict[str, list[LoopSpec]] = {}
    parts: list[PartSpec] = []
    last = ""
    for line, cells in table.rows():
        kind, name = cells.get("kind", "").lower(), cells.get("name", "")
        origin = Origin(str(path), line)
        if kind not in ("wire", "loop", "part"):
            text = f"unknown kind of row (got {kind[:40]!r}), known are wire, loop and part"
            table.problems.append(origin.problem(text))
            continue
        if not name:
            table.problems.append(origin.problem(f"this {kind} has no name"))
            continue
        at = (table.number(line, cells, "x"), table.number(line, cells, "y"))
        if kind == "wire":
            if name in vertices and last != name:
                text = f"a second wire named {name!r} (the first is on line {first[name][0]}), names must differ"
                table.problems.append(origin.problem(text))
            first.setdefault(name, (line, cells.get("held", "").lower() == "laid"))
            vertices.setdefault(name, []).append(at)
            last = name
        elif kind == "loop":
            loops.setdefault(name, []).append(_loop(table, line, cells, at, slack))
        else:
            size = tuple(
                table.number(line, cells, key, default)
                for key, default in zip(("size_x", "size_y"), DEFAULT_LAND_MM, strict=True)
            )
            connects = tuple(item.strip() for item in cells.get("connects", "").split(";") if item.strip())
            rigid = cells.get("held", "").lower() != "loose"
            parts.append(PartSpec(name, at, (size[0], size[1]), connects or None, rigid, origin))
    for name, items in loops.items():
        if name not in vertices:
            text = f"a loop of no such wire (got {name!r}){nearest(name, vertices)}"
            table.problems.append(items[0].origin.problem(text))
    if table.problems:
        raise BadInput(table.problems)
    wires = []
    for name, points in vertices.items():
        line, laid = first[name]
        kind_number, plain = kind_of(np.array(points), laid=laid)
        wires.append(PathSpec(name, kind_number, plain, tuple(loops.get(name, ())), Origin(str(path), line)))
    return Drawing(tuple(wires), tuple(parts))


def _loop(table: DrawingRows, line: int, cells: dict[str, str], at: tuple[float, float], slack: float) -> LoopSpec:
    return LoopSpec(
        at,
        table.number(line, cells, "length", DEFAULT_LOOP_MM),
        table.number(line, cells, "slack", slack),
        table.number(line, cells, "rigid", 0.0),
        Origin(str(table.path), line),
    )


def write_csv(drawing: Drawing, path: Path) -> None:
    """Write a drawing as a table in mm, with as many digits as it takes to read the same numbers back."""
    rows: list[dict[str, object]] = []
    for spec in drawing.wires:
        _, straight = kind_of(spec.line)
        held = "laid" if spec.kind == LAID and len(straight) == 2 else ""
        rows += [{"kind": "wire", "name": spec.name, "x_mm": x, "y_mm": y, "held": held} for x, y in spec.points]
        for loop in spec.loops:
            x, y = place_of(spec, loop)
            rows.append(
                {"kind": "loop", "name": spec.name, "x_mm": x, "y_mm": y, "length_mm": loop.length_mm}
                | {"slack": loop.slack, "rigid_mm": loop.rigid_mm}
            )
    for part in drawing.parts:
        rows.append(
            {"kind": "part", "name": part.name, "x_mm": part.at[0], "y_mm": part.at[1], "size_x_mm": part.size[0]}
            | {"size_y_mm": part.size[1], "connects": ";".join(part.connects or ())}
            | {"held": "" if part.rigid else "loose"}
        )
    write_table(path, [COLUMNS, *([row.get(name, "") for name in COLUMNS] for row in rows)])


def place_of(spec: PathSpec, loop: LoopSpec) -> tuple[float, float]:
    """Return the place (warp, weft) of a loop's centre."""
    if isinstance(loop.at, tuple):
        return loop.at
    points, along = spec.line, spec.along
    order = np.argsort(along)
    x, y = (float(np.interp(loop.at, along[order], points[order, axis])) for axis in (0, 1))
    return x, y
