"""What would be read of a measured file or a mesh, before anything is done with it.

The readers of `identify`, `diagnose` and `body: {type: mesh}` are run as they are; what is shown here is what they
returned, put beside what stands in the file. A file that is refused is shown as far as it could be taken apart.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from etextile.contact.mesh import prepared
from etextile.contact.mesh_file import FORMATS, read_triangles
from etextile.diagnose.data.bent import read_moment_curvature
from etextile.diagnose.data.cyclic import read_cyclic_force
from etextile.diagnose.data.inflated import read_displacement_field, read_joint_moment, read_pressure_height
from etextile.diagnose.data.measured import (
    read_clamp_line,
    read_free_edge,
    read_mark_slip,
    read_strain_field,
    read_wires,
)
from etextile.diagnose.data.punched import read_punch_force, read_punch_unloading
from etextile.errors import BadInput, Problem
from etextile.identify.curves import KINDS, CouponSize, read_curve
from etextile.identify.segments import split
from etextile.importers.columns import find_columns, offers
from etextile.importers.labels import split_name
from etextile.importers.numerals import value_of
from etextile.importers.options import PLAIN, Options
from etextile.importers.sheet import Sheet, read_sheet
from etextile.importers.table import FileTable, table_of
from etextile.types import Array, IntArray


FIELD = ("warp0_mm", "weft0_mm", "warp_mm", "weft_mm", "height_mm")
COLUMNS: dict[str, tuple[tuple[str, ...], ...]] = {
    "wires": (("displacement_mm", "wire", "warp0_mm", "state"), ("angle_deg", "wire", "warp0_mm", "state")),
    "displacement_field": (("displacement_mm", *FIELD), ("pressure_bar", *FIELD)),
    "strain_field": (("displacement_mm", "warp0_mm", "weft0_mm", "strain_warp", "strain_weft"),),
    "free_edge": (("displacement_mm", "warp0_mm", "warp_mm", "weft_mm", "height_mm"),),
    "mark_slip": (("angle_deg", "warp0_mm", "weft0_mm", "slip_mm"),),
    "clamp_line": (("displacement_mm", "weft0_mm", "slip_mm"),),
    "pressure_height": (("pressure_bar", "height_mm"),),
    "joint_moment": (("angle_deg", "moment_Nmm"),),
    "moment_curvature": (("curvature_1_per_m", "moment_Nm_per_m"),),
    "tensile": KINDS,
    "punch_force": (("displacement_mm", "force_N"),),
    "punch_unloading": (("displacement_mm", "force_N"),),
    "cyclic_force": (("displacement_mm", "force_N"),),
}
"""Channels of measured.yaml and the columns they need, those with the most first."""
READERS: dict[str, Callable[..., Any]] = {
    "wires": read_wires,
    "displacement_field": read_displacement_field,
    "strain_field": read_strain_field,
    "free_edge": read_free_edge,
    "clamp_line": read_clamp_line,
    "pressure_height": read_pressure_height,
    "joint_moment": read_joint_moment,
    "moment_curvature": read_moment_curvature,
    "mark_slip": read_mark_slip,
    "punch_force": read_punch_force,
    "punch_unloading": read_punch_unloading,
    "cyclic_force": read_cyclic_force,
}
TEXTS = {"wires": ("state",)}


@dataclass(frozen=True)
class FileColumn:
    """One column: number from 1, name and unit in the file, smallest and largest number of the rows.

    `quantity` is what it is read as, '' for a column that is not read; then a value read is
    `sign * (factor * cell - zero)`, in the unit that the quantity's name ends with.
    """

    number: int
    name: str
    unit: str | None
    low: float | None
    high: float | None
    quantity: str = ""
    factor: float = 1.0
    sign: int = 1
    zero: float = 0.0


@dataclass(frozen=True)
class LeftOut:
    """Rows that are not used: lines of the file (n,) and why."""

    lines: IntArray
    why: str


@dataclass(frozen=True)
class Inspection:
    """What was found in a measured file: `found` in one line, columns, rows, what is left out, what stands in the way.

    `rows` are rows of the table, `used` lines (n,) of those that count; `values` the numbers of all rows with a reading
    by quantity, beside their `lines`, for the picture. `problems`: why it would be refused, empty when it is read.
    """

    file: str
    channel: str
    found: str
    columns: tuple[FileColumn, ...]
    rows: int
    used: IntArray
    left_out: tuple[LeftOut, ...]
    notes: tuple[str, ...]
    problems: tuple[Problem, ...]
    lines: IntArray = field(repr=False, default_factory=lambda: np.zeros(0, dtype=np.int64))
    values: dict[str, Array] = field(repr=False, default_factory=dict)


@dataclass(frozen=True)
class InspectedMesh:
    """A mesh: vertices (v, 3) mm and triangles (f, 3) after repair, notes on it, problems that make it unusable."""

    file: str
    vertices: Array = field(repr=False)
    faces: IntArray = field(repr=False)
    notes: tuple[str, ...]
    problems: tuple[Problem, ...]

    @property
    def box(self) -> Array:
        """Return the lowest and highest coordinates (2, 3), mm."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @property
    def highest(self) -> Array:
        """Return the highest point (3,), mm."""
        return np.asarray(self.vertices[int(np.argmax(self.vertices[:, 2]))])


def inspect(
    path: str | Path, picture: str | Path | None = None, *, channel: str | None = None,
    options: Options = PLAIN, size: CouponSize | None = None, scale: float = 1.0,
) -> Inspection | InspectedMesh:  # fmt: skip
    """Return what would be read of a measured file or of a mesh (by its ending), and draw it as `picture` (PNG).

    `channel`: a channel of measured.yaml, found by the columns when None; `options` and `size` as for `identify`,
    `scale` as in `body`. Raises BadInput where not even rows and columns, or triangles, can be told.
    """
    path = Path(path)
    if channel is not None and channel not in COLUMNS:
        raise BadInput.of(f"unknown channel (got {channel!r}), must be one of {', '.join(COLUMNS)}", key="--channel")
    if path.is_dir():
        raise BadInput.of("this is a folder: et.inspect_folder takes it, or name one file in it", file=str(path))
    target = None if picture is None else Path(picture)
    if target is not None and target.suffix.lower() != ".png":
        raise BadInput.of("the picture is a PNG: name it so, as in -o look.png", file=str(target))
    mesh = path.suffix.lower() in FORMATS
    found = _mesh(path, scale) if mesh else inspect_table(path, channel=channel, options=options, size=size)
    if target is not None:
        _draw(found, target)
    return found


def inspect_table(
    path: Path, *, channel: str | None = None, options: Options = PLAIN, size: CouponSize | None = None
) -> Inspection:
    """Return what would be read of a measured file; raises BadInput where rows and columns cannot be told."""
    return _table(read_sheet(path, options), path, channel, options, size)


def _draw(found: Inspection | InspectedMesh, path: Path) -> None:
    from viz.inspect_plots import save_mesh, save_rows

    name = Path(found.file).name
    if isinstance(found, InspectedMesh):
        save_mesh(path, found.vertices, found.faces, title=name)
    elif found.values:
        save_rows(path, found.values, np.isin(found.lines, found.used), title=name, subtitle=found.channel)


def _mesh(path: Path, scale: float) -> InspectedMesh:
    """Return a mesh as `body` would take it, or as it stands in the file when it would be refused."""
    try:
        vertices, faces, notes = prepared(path, scale=scale)
        return InspectedMesh(str(path), vertices, faces, notes, ())
    except BadInput as error:
        vertices, faces, notes = read_triangles(path)
        return InspectedMesh(str(path), scale * vertices, faces, notes, error.problems)


def _table(sheet: Sheet, path: Path, channel: str | None, options: Options, size: CouponSize | None) -> Inspection:
    """Return what the channel's reader makes of a file that was taken apart."""
    channel = channel or _channel(sheet, size)
    needed = next((names for names in COLUMNS[channel] if all(offers(sheet, name) for name in names)), ())
    columns, out = _columns(sheet, (), channel), _outside(sheet)
    base = Inspection(sheet.file, channel, sheet.found, columns, len(sheet.body), _none(), out, (), ())
    try:
        table = table_of(sheet, needed or COLUMNS[channel][0], texts=TEXTS.get(channel, ()))
    except BadInput as error:
        return replace(base, problems=error.problems)
    columns = _columns(sheet, tuple(table.numbers) + tuple(table.texts), channel, table)
    base = replace(base, columns=columns, notes=table.notes, lines=table.lines, values=table.numbers)
    gaps = _unread(sheet, table)
    try:
        used, more, notes = _read(table, path, channel, options, size)
    except BadInput as error:
        return replace(base, left_out=base.left_out + gaps, problems=error.problems)
    return replace(base, used=used, left_out=(*base.left_out, *gaps, *more), notes=notes)


def _channel(sheet: Sheet, size: CouponSize | None) -> str:
    """Return the channel whose columns the file has; force over displacement is a coupon when its size is given."""
    whole = [
        channel
        for channel, kinds in COLUMNS.items()
        if any(all(offers(sheet, name) for name in kind) for kind in kinds)
    ]
    if whole[:2] == ["tensile", "punch_force"] and size is None and not _has_strain(sheet):
        return "punch_force"
    if whole:
        return whole[0]
    shares = {
        channel: max(sum(offers(sheet, name) for name in kind) / len(kind) for kind in kinds)
        for channel, kinds in COLUMNS.items()
    }
    return max(shares, key=lambda name: (shares[name], name == "punch_force"))


def _has_strain(sheet: Sheet) -> bool:
    return offers(sheet, "strain") and offers(sheet, "stress_MPa")


def _read(
    table: FileTable, path: Path, channel: str, options: Options, size: CouponSize | None
) -> tuple[IntArray, tuple[LeftOut, ...], tuple[str, ...]]:
    """Return lines used, rows left out and the notes of the channel's own reader."""
    if channel == "tensile":
        parts = split(read_curve(path, size=size, options=options))
        out = tuple(LeftOut(lines, why) for why, lines in parts.left_out)
        dropped = np.concatenate([_none(), *(item.lines for item in out)])
        return np.setdiff1d(table.lines, dropped), out, parts.notes
    item = READERS[channel](path, options=options)
    used = np.asarray(item.lines, dtype=np.int64)
    rest = table.where(~np.isin(table.lines, used))
    if not len(rest):
        return used, (), item.notes
    along = next(iter(table.numbers))
    kept = table.numbers[along][np.isin(table.lines, used)]
    repeats = np.isin(rest.numbers[along], kept) & (rest.lines > used.min()) & (rest.lines < used.max())
    out = (
        LeftOut(rest.lines[repeats], f"{along} repeats: averaged with the row of the same reading"),
        LeftOut(rest.lines[~repeats], "no way back" if channel == "punch_unloading" else "unloading and reloading"),
    )
    return used, tuple(part for part in out if len(part.lines)), item.notes


def _outside(sheet: Sheet) -> tuple[LeftOut, ...]:
    """Return what stands above and below the table."""
    parts = (
        ([row.line for row in sheet.block], "before the table"),
        ([row.line for row in sheet.after], "after the table"),
        ([row.line for row in sheet.repeats], "words within the table"),
    )
    return tuple(LeftOut(np.array(lines, dtype=np.int64), why) for lines, why in parts if lines)


def _unread(sheet: Sheet, table: FileTable) -> tuple[LeftOut, ...]:
    """Return the rows of the table in which a quantity has no reading."""
    lines = np.setdiff1d([row.line for row in sheet.body], table.lines)
    return (LeftOut(lines, "a quantity has no reading"),) if len(lines) else ()


def _columns(
    sheet: Sheet, names: Sequence[str], channel: str, table: FileTable | None = None
) -> tuple[FileColumn, ...]:
    """Return every column of the file, with what those called `names` are read as."""
    read = (
        {column.index: column for column in find_columns(sheet, names, texts=TEXTS.get(channel, ()))} if names else {}
    )
    found = []
    for index in range(sheet.width):
        label = sheet.head[index] if index < len(sheet.head) else None
        cells = [row.cells[index] if index < len(row.cells) else "" for row in sheet.body]
        numbers = np.array([_number(cell, sheet.dialect.decimal) for cell in cells], dtype=np.float64)
        finite = numbers[np.isfinite(numbers)]
        low, high = (float(finite.min()), float(finite.max())) if len(finite) else (None, None)
        column = FileColumn(index + 1, label.name if label else "", label.unit if label else None, low, high)
        taken = read.get(index)
        if taken is not None:
            sign, zero = _sign_and_zero(numbers * taken.factor, sheet, table, taken.name)
            unit = column.unit or split_name(taken.name)[1]
            column = replace(column, unit=unit, quantity=taken.name, factor=taken.factor, sign=sign, zero=zero)
        found.append(column)
    return tuple(found)


def _number(cell: str, decimal: str) -> float:
    value = value_of(cell, decimal)
    return np.nan if value is None else value


def _sign_and_zero(cells: Array, sheet: Sheet, table: FileTable | None, name: str) -> tuple[int, float]:
    """Return sign and zero that turned the cells (n,), in the wanted unit, into what was read."""
    if table is None or name not in table.numbers:
        return 1, 0.0
    raw = cells[np.isin([row.line for row in sheet.body], table.lines)]
    values = table.numbers[name]
    far = int(np.argmax(np.abs(raw - raw[0])))
    sign = -1 if (raw[far] - raw[0]) * (values[far] - values[0]) < 0.0 else 1
    zero = float(raw[0] - sign * values[0])
    return sign, 0.0 if abs(zero) <= 1e-12 * max(1.0, float(np.abs(raw).max())) else zero


def _none() -> IntArray:
    return np.zeros(0, dtype=np.int64)


def as_json(found: Inspection | InspectedMesh) -> dict[str, Any]:
    """Return an inspection in JSON types; lines that follow one another as [first, last]."""
    problems = [str(problem) for problem in found.problems]
    if isinstance(found, InspectedMesh):
        box, top = found.box, found.highest
        return {
            "file": found.file, "kind": "mesh", "vertices": len(found.vertices), "triangles": len(found.faces),
            "box_mm": box.tolist(), "highest_mm": top.tolist(), "notes": list(found.notes), "problems": problems,
        }  # fmt: skip
    columns = [
        {
            "column": item.number, "name": item.name, "unit": item.unit, "low": item.low, "high": item.high,
            "read_as": item.quantity or None, "factor": item.factor, "sign": item.sign, "zero": item.zero,
        }
        for item in found.columns
    ]  # fmt: skip
    left_out = [{"lines": runs(item.lines), "rows": len(item.lines), "why": item.why} for item in found.left_out]
    return {
        "file": found.file, "kind": found.channel, "found": found.found, "columns": columns, "rows": found.rows,
        "rows_used": len(found.used), "left_out": left_out, "notes": list(found.notes), "problems": problems,
    }  # fmt: skip


def runs(lines: IntArray) -> list[list[int]]:
    """Return lines (n,) as [first, last] of those that follow one another."""
    if not len(lines):
        return []
    cuts = np.flatnonzero(np.diff(lines) > 1) + 1
    return [[int(part[0]), int(part[-1])] for part in np.split(lines, cuts)]
