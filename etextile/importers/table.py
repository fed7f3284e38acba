"""Strict reading of a column file: numbers in the units wanted, or one message that says what is wrong in which line.

Measured files come from many hands; a value that is guessed or dropped in silence ends up in a material parameter. So
what is not a number is refused with file, line and column, and rows without a reading are left out and counted.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from etextile.errors import BadInput
from etextile.importers.cell_units import REMEDY, carries_unit
from etextile.importers.columns import Column, find_columns
from etextile.importers.labels import split_name
from etextile.importers.numerals import column_of, fault, value_of, without_stand_ins
from etextile.importers.options import FIRST, PLAIN, Options
from etextile.importers.sheet import Sheet, read_sheet
from etextile.types import Array, BoolArray, IntArray


MOST_MISSING = 0.5
"""Share of rows without a reading beyond which a file is refused."""
REMARKS = ("comment", "comments", "remark", "remarks", "note", "notes", "kommentar", "bemerkung", "commentaire")
"""Names of a last column that rows without a remark leave out."""
CONFIDENCE = "sigma"
"""Column of image correlation with the confidence of a point in pixels, -1 where it was lost."""
CROSSHEAD = ("displacement_mm", "strain")


@dataclass(frozen=True)
class FileTable:
    """Columns of a file: `numbers` and `texts` by name, each (n,), and the line (from 1) each row stands in, (n,).

    `notes`: what was found and what was left out, one sentence each.
    """

    file: str
    numbers: dict[str, Array]
    texts: dict[str, tuple[str, ...]]
    lines: IntArray
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.lines)

    def line(self, row: int) -> int:
        """Return the line of the file that holds `row`."""
        return int(self.lines[row])

    def where(self, rows: BoolArray | IntArray, *notes: str) -> FileTable:
        """Return the table of some rows, in their order, with further notes."""
        texts = {name: tuple(words[i] for i in np.arange(len(self))[rows]) for name, words in self.texts.items()}
        numbers = {name: values[rows] for name, values in self.numbers.items()}
        return replace(self, numbers=numbers, texts=texts, lines=self.lines[rows], notes=(*self.notes, *notes))


def read_table(
    path: Path, required: Sequence[str], *, texts: Collection[str] = (), options: Options = PLAIN
) -> FileTable:
    """Read the columns `required` (quantities with their unit, `force_N`) of a file; other columns are ignored.

    `texts`: those of them that hold words. Raises BadInput (file and line) for a missing or unclear column, a row with
    another number of cells, text in numbers, infinity, more than half of the rows without a reading, and no rows.
    """
    return table_of(read_sheet(path, options), required, texts=texts)


def header_of(path: Path, options: Options = PLAIN) -> tuple[str, ...]:
    """Return the names of the columns of a file as they stand in it."""
    return tuple(label.text for label in read_sheet(path, options).head)


def table_of(sheet: Sheet, required: Sequence[str], *, texts: Collection[str] = ()) -> FileTable:
    """Return the columns `required` of a file that was taken apart."""
    if not sheet.body:
        names = ",".join(label.text for label in sheet.head)[:200]
        missing = [name for name in required if name not in [label.text for label in sheet.head]]
        if missing and not sheet.options.sources and not sheet.block:
            find_columns(sheet, required, texts=list(texts))
        if sheet.block:
            message = f"no row of numbers: line {sheet.head_line} holds {names[:80]!r}"
            raise BadInput.of(f"{message}; {REMEDY}", file=sheet.file, line=sheet.head_line)
        raise BadInput.of(f"no data: only the header {names}", file=sheet.file, line=sheet.head_line)
    columns = find_columns(sheet, required, texts=list(texts))
    _check_width(sheet)
    numbers = {column.name: _numbers(sheet, column) for column in columns if column.name not in texts}
    words = {
        column.name: tuple(row.cells[column.index] for row in sheet.body) for column in columns if column.name in texts
    }
    lines = np.array([row.line for row in sheet.body], dtype=np.int64)
    table = _measured(_correlated(sheet, FileTable(sheet.file, numbers, words, lines, _found(sheet, columns))))
    return _turned(_zeroed(table, sheet.options), sheet.options)


def _found(sheet: Sheet, columns: Sequence[Column]) -> tuple[str, ...]:
    """Say in one line how the file was read, nothing when it is as the manual describes."""
    words = "; ".join(column.words for column in columns if column.words)
    if sheet.plain and not words and not sheet.text.note:
        return ()
    return (f"read as {sheet.found}" + (f"; {words}" if words else ""),)


def _check_width(sheet: Sheet) -> None:
    """Every row has as many cells as there are columns."""
    width = sheet.width
    if sheet.head and sheet.head[-1].name.lower() in REMARKS and all(len(row.cells) == width - 1 for row in sheet.body):
        return
    wrong = [row for row in sheet.body if len(row.cells) != width]
    if len(wrong) == len(sheet.body) and sheet.head and {len(row.cells) for row in wrong} == {width + 1}:
        message = f"{width + 1} columns under {width} names: name the first column too, or say them all: --columns"
        raise BadInput.of(f"{message} (columns: in measured.yaml)", file=sheet.file, line=sheet.head_line)
    if wrong:
        names = ",".join(label.text for label in sheet.head)[:200]
        message = f"{len(wrong[0].cells)} values for the {width} columns {names}{more(len(wrong))}"
        if len(wrong[0].cells) == 2 * width and sheet.dialect.delimiter == "," and sheet.dialect.decimal == ".":
            message += "; decimal commas between commas? export with semicolons, tabs or quotes"
        raise BadInput.of(message, file=sheet.file, line=wrong[0].line)


def _numbers(sheet: Sheet, column: Column) -> Array:
    """Return one column in the unit wanted, NaN where nothing was measured."""
    if column.index in sheet.wrong_units:
        line, said = sheet.wrong_units[column.index]
        raise BadInput.of(said, file=sheet.file, line=line, key=column.name)
    cells = [row.cells[column.index] for row in sheet.body]
    values, wrong = column_of(cells, sheet.dialect.decimal)
    if wrong:
        cell = cells[wrong[0]]
        infinite = value_of(cell, sheet.dialect.decimal) is not None
        said = f"not a finite number (got {cell[:40]})" if infinite else fault(cell)
        if carries_unit(cell):
            message = f"a unit in the cell (got {cell[:40]!r}), most others have none{more(len(wrong))}; {REMEDY}"
            raise BadInput.of(message, file=sheet.file, line=sheet.body[wrong[0]].line, key=column.name)
        if not infinite and value_of(cell, "," if sheet.dialect.decimal == "." else ".") is not None:
            said = f"another decimal mark than in the rest of the file (got {cell!r})"
        message = f"{said}, a finite number is needed{more(len(wrong))}"
        raise BadInput.of(message, file=sheet.file, line=sheet.body[wrong[0]].line, key=column.name)
    values = without_stand_ins(values, cells)
    return values if column.factor == 1.0 else values * column.factor


def _correlated(sheet: Sheet, table: FileTable) -> FileTable:
    """Leave out the points that image correlation did not find: zeros beside a confidence (`sigma`) of -1."""
    index = next((i for i, label in enumerate(sheet.head) if label.name.lower() == CONFIDENCE), None)
    if index is None:
        return table
    lost = np.array([value_of(row.cells[index], sheet.dialect.decimal) == -1.0 for row in sheet.body], dtype=bool)
    if not lost.any():
        return table
    return table.where(~lost, f"{lost.sum()} of {len(lost)} points were not correlated (sigma -1): left out")


def _measured(table: FileTable) -> FileTable:
    """Leave out the rows in which a quantity was not measured, and say how many; refuse when they are most."""
    empty = {name: np.isnan(values) for name, values in table.numbers.items()}
    out = np.zeros(len(table), dtype=bool)
    for flags in empty.values():
        out |= flags
    count = int(out.sum())
    if not count:
        return table
    names = " and ".join(name for name, flags in empty.items() if flags.any())
    share = f"{count} of {len(table)} rows ({count / len(table):.1%}) have no reading of {names}"
    if count > MOST_MISSING * len(table):
        raise BadInput.of(f"{share}: too few are left", file=table.file, line=table.line(int(np.argmax(out))))
    return table.where(~out, f"{share}: left out")


def _zeroed(table: FileTable, options: Options) -> FileTable:
    """Take the zero a person stated off the quantities."""
    numbers = dict(table.numbers)
    for key, zero in options.zero.items():
        for name in numbers:
            if key in (name, split_name(name)[0]) or (key == "" and name in CROSSHEAD):
                off = float(numbers[name][0]) if zero == FIRST else float(zero)
                numbers[name] = numbers[name] - off
    return replace(table, numbers=numbers)


def _turned(table: FileTable, options: Options) -> FileTable:
    """Change signs as a person stated.

    A sign for all turns force and stress, and displacement and strain where they run to the negative side.
    """
    numbers, turned = dict(table.numbers), []
    for key, sign in options.sign.items():
        for name, values in numbers.items():
            quantity = split_name(name)[0]
            loads = quantity in ("force", "stress")
            runs_back = quantity in ("displacement", "strain") and bool(values[np.argmax(np.abs(values))] < 0.0)
            if key in (name, quantity) or (key == "" and (loads or runs_back)):
                numbers[name] = sign * values + 0.0
                turned += [name] * (sign < 0)
    note = (f"sign of {' and '.join(turned)} turned, as stated",) if turned else ()
    return replace(table, numbers=numbers, notes=(*table.notes, *note))


def more(count: int) -> str:
    """Say in how many further rows the same is wrong."""
    return f" (and {count - 1} more row{'s' if count > 2 else ''})" if count > 1 else ""
