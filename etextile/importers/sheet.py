"""A column file taken apart: block before the table, names, units, rows of cells, and what was found in one line."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path

from etextile.errors import BadInput
from etextile.importers.again import without_names
from etextile.importers.cell_units import units_of, without_units
from etextile.importers.dialect import Dialect, FileLines, FileRow, find_dialect, lines_of, split_rows
from etextile.importers.encoding import Text, read_text
from etextile.importers.labels import Label, bare, is_unit, label_of
from etextile.importers.numerals import is_number
from etextile.importers.options import PLAIN, Options


LONGER = 10
"""So many times as long as all others must a table be to be taken for the one that is meant."""


COUNTS = frozenset(("segments", "cycles", "count", "counts", "points", "steps", "no", "nr", "#", "zyklen"))
"""Words in a row of units for what is counted."""
UNIT_WORD = re.compile(r"unit|einheit|unité|unidad|单位|単位", re.IGNORECASE)


@dataclass(frozen=True)
class Sheet:
    """A file as rows of cells: `head` (empty when there is none) and its line, `units_line`, what stands above.

    `block`: the rows above the names, `after`: those below the table, `repeats`: those within that repeat the names
    or hold words alone. `cut`: the file ends within its last line, which is left out.
    `dialect` says how numbers are written, `text` how letters are. `wrong_units`: by column the line and what is wrong
    with the units in its cells.
    """

    file: str
    text: Text
    dialect: Dialect
    head: tuple[Label, ...]
    head_line: int
    units_line: int | None
    block: tuple[FileRow, ...]
    after: tuple[FileRow, ...]
    body: tuple[FileRow, ...]
    options: Options
    repeats: tuple[FileRow, ...] = ()
    cut: bool = False
    in_cells: bool = False
    wrong_units: Mapping[int, tuple[int, str]] = field(default_factory=dict)

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self.head) if self.head else len(self.body[0].cells)

    @property
    def plain(self) -> bool:
        """Tell whether the file is what the manual describes, so that nothing need be said of how it was read."""
        usual = self.text.encoding in ("utf-8", "utf-8-sig") and self.dialect.delimiter == ","
        return (
            usual
            and self.dialect.decimal == "."
            and self.units_line is None
            and not self.in_cells
            and not any((self.block, self.after, self.repeats, self.cut))
        )

    @property
    def found(self) -> str:
        """What was found, in one line."""
        parts = [self.text.shown, self.dialect.words]
        if self.block:
            parts.append(f"{_lines(self.block)} before the table passed over")
        if self.after:
            parts.append(f"{_lines(self.after)} after the table passed over")
        if self.units_line:
            parts.append(f"units in line {self.units_line}")
        if self.repeats:
            parts.append(f"words within the table in {_listed(self.repeats)} passed over")
        if self.cut:
            parts.append("the last line, in which the file ends, left out")
        if self.in_cells:
            parts.append("units taken from the cells")
        if not self.head:
            parts.append("no names of columns")
        return ", ".join(parts) + (f" ({self.text.note})" if self.text.note else "")


def read_sheet(path: Path, options: Options = PLAIN) -> Sheet:
    """Take a file apart; raises BadInput for what is no table, and where two readings are possible."""
    file = str(path)
    text = read_text(path, options.encoding)
    lines = lines_of(text.text, skip=options.skip_rows or 0, file=file)
    bare = without_units(lines)
    dialect = find_dialect(bare, options, file)
    rows = _without_trailing(split_rows(bare, dialect, file))
    start = _longest_table(rows, _first_of_data(rows, dialect.decimal), dialect.decimal)
    end = _end_of_data(rows, start, dialect.decimal)
    above, after = rows[:start], rows[end:]
    cut = end == len(rows) and _is_cut(rows[start:], text.text)
    body, repeats = without_names(rows[start : end - cut], above, dialect.decimal, file)
    head, head_line, units_line, block = _names(above, lines, dialect, len(body[0].cells) if body else 0)
    sheet = Sheet(
        file, text, dialect, head, head_line, units_line, tuple(block), tuple(after), tuple(body), options,
        tuple(repeats), cut,
    )  # fmt: skip
    return sheet if bare is lines or not body else _with_units(sheet, lines)


def _with_units(sheet: Sheet, lines: FileLines) -> Sheet:
    """Return the sheet with the units that stood in its cells, made of lines that hold them."""
    found = units_of(lines, sheet.body, sheet.dialect, sheet.head, sheet.file)
    head = [
        replace(label, unit=found.units[i]) if i in found.units and label.unit is None else label
        for i, label in enumerate(sheet.head)
    ]
    return replace(sheet, head=tuple(head), in_cells=True, wrong_units=found.wrong)


def _without_trailing(rows: list[FileRow]) -> list[FileRow]:
    """Drop an empty last column that comes of a mark at the end of every line."""
    if all(len(row.cells) > 1 and not row.cells[-1] for row in rows):
        return [FileRow(row.line, row.cells[:-1]) for row in rows]
    width = Counter(len(row.cells) for row in rows).most_common(1)[0][0]
    wide = [row for row in rows if len(row.cells) == width]
    names = any(len(row.cells) == width - 1 for row in rows)
    if names and width > 2 and all(not row.cells[-1] for row in wide):
        return [FileRow(row.line, row.cells[:-1]) if len(row.cells) == width else row for row in rows]
    return rows


def _lines(rows: Sequence[FileRow]) -> str:
    """Return the lines of some rows in words."""
    first, last = rows[0].line, rows[-1].line
    return f"lines {first} to {last}" if last > first else f"line {first}"


def _listed(rows: Sequence[FileRow]) -> str:
    """Return the lines of rows that stand apart, the first five of them."""
    first = ", ".join(str(row.line) for row in rows[:5])
    return f"line {first}" + (f" and {len(rows) - 5} more" if len(rows) > 5 else "")


def _is_cut(rows: Sequence[FileRow], text: str) -> bool:
    """Tell whether a file ends within its last line: without an end of line, and with fewer cells than the others."""
    if len(rows) < 3 or text.endswith(("\n", "\r")):
        return False
    return len(rows[-1].cells) < min(len(row.cells) for row in rows[-3:-1])


def _end_of_data(rows: Sequence[FileRow], start: int, decimal: str) -> int:
    """Return the index behind the last row of the table: below it all rows have words where the table has numbers.

    The first of them has another width or no number, or it is a row of the table with a fault.
    """
    if start >= len(rows):
        return len(rows)
    width = Counter(len(row.cells) for row in rows[start:]).most_common(1)[0][0]
    usual = [row.cells for row in rows[start:] if len(row.cells) == width]
    numeric = [2 * sum(is_number(cells[j], decimal) for cells in usual) > len(usual) for j in range(width)]
    end = at = len(rows)
    while at > start + 1:
        cells = rows[at - 1].cells
        numbers = [is_number(cell, decimal) for cell in cells]
        words = [bool(cell) and not flag for cell, flag in zip(cells, numbers, strict=True)]
        as_wide = len(cells) == width
        if not any(word and (not as_wide or numeric[j]) for j, word in enumerate(words)):
            break
        at -= 1
        if not as_wide or not any(numbers):
            end = at
    return end


def _first_of_data(rows: Sequence[FileRow], decimal: str) -> int:
    """Return the index of the first row of numbers: as wide as most rows, with more numbers than words where they have.

    A row right above it that holds a number too is a row of data with a fault, not a head.
    """
    numbers = [[is_number(cell, decimal) for cell in row.cells] for row in rows]
    other = "," if decimal == "." else "."

    def is_data(cells: Sequence[str], least: int) -> bool:
        return 2 * sum(is_number(cell, decimal) or is_number(cell, other) for cell in cells) >= least

    some = [i for i, flags in enumerate(numbers) if any(flags)]
    if not some:
        return len(rows)
    width = Counter(len(rows[i].cells) for i in some).most_common(1)[0][0]
    usual = [i for i in some if len(rows[i].cells) == width]
    count = [sum(numbers[i][j] for i in usual) for j in range(width)]
    columns = [j for j in range(width) if 2 * count[j] >= len(usual)]
    for i in usual:
        filled = [numbers[i][j] or not rows[i].cells[j] for j in columns]
        if columns and all(filled) and any(numbers[i][j] for j in columns):
            start = i
            while start > 0 and len(rows[start - 1].cells) == width and is_data(rows[start - 1].cells, len(columns)):
                start -= 1
            return start
    return usual[0]


def _longest_table(rows: Sequence[FileRow], start: int, decimal: str) -> int:
    """Return the first row of the only long table where short ones, such as a table of results, stand before it.

    Tables are told apart by a row of names as wide as the numbers below it.
    """
    worded = [i for i in range(start, len(rows)) if not any(is_number(cell, decimal) for cell in rows[i].cells)]
    edges = [start - 1, *worded, len(rows)]
    tables = [(before + 1, after - before - 1) for before, after in pairwise(edges) if after > before + 1]
    if len(tables) < 2:
        return start
    first, length = max(tables, key=lambda table: table[1])
    rest = sum(other for _, other in tables) - length
    named = len(rows[first - 1].cells) == len(rows[first].cells) > 1 and all(rows[first - 1].cells)
    return first if named and length >= LONGER * rest else start


def _names(
    above: list[FileRow], lines: FileLines, dialect: Dialect, width: int
) -> tuple[tuple[Label, ...], int, int | None, list[FileRow]]:
    """Return names, their line, the line of units if there is one, and the rows before them.

    Without a row of names the last comment before the numbers is tried, as numpy writes it.
    """
    if not above:
        if lines.comment is not None:
            cells = split_rows(FileLines([lines.comment[0]], [lines.comment[1]]), dialect, "")[0].cells
            if len(cells) == width and not any(is_number(cell, dialect.decimal) for cell in cells):
                return tuple(label_of(cell) for cell in cells), lines.comment[0], None, []
        return (), 0, None, []
    last = above[-1]
    two = len(above) > 1 and len(above[-2].cells) == len(last.cells)
    if two and _are_units(last.cells):
        names = above[-2]
        head = [label_of(cell, unit) for cell, unit in zip(names.cells, last.cells, strict=True)]
        return tuple(head), names.line, last.line, above[:-2]
    head = [label_of(cell) for cell in last.cells]
    row = _row_of_units(above[:-1], len(head))
    if row is not None and not any(label.unit for label in head):
        named = [label_of(cell, unit) for cell, unit in zip(last.cells, row.cells, strict=False)]
        return (*named, *head[len(named) :]), last.line, row.line, above[:-1]
    return tuple(head), last.line, None, above[:-1]


def _row_of_units(block: Sequence[FileRow], width: int) -> FileRow | None:
    """Return the row of a header block that says it holds units, one over each column, as LabVIEW writes it."""
    for row in reversed(block):
        rest = [bare(cell) for cell in row.cells[1:] if bare(cell)]
        if len(row.cells) <= width and rest and UNIT_WORD.search(row.cells[0]) and all(is_unit(unit) for unit in rest):
            return row
    return None


def _are_units(cells: Sequence[str]) -> bool:
    """Tell whether a row holds units and nothing else, counts beside them."""
    filled = [bare(cell) for cell in cells if bare(cell) and bare(cell).lower() not in COUNTS]
    return bool(filled) and all(is_unit(text) for text in filled)


def bad(sheet: Sheet, message: str, *, line: int | None = None, key: str = "") -> BadInput:
    """Return the error for a line of the file."""
    return BadInput.of(message, file=sheet.file, line=line, key=key)
