"""Strict reading of a column file (CSV): numbers or one message that says what is wrong in which line.

Measured files come from many hands; a value that is guessed or dropped in silence ends up in a material parameter. So
everything that is not a finite number in a named column is refused with file, line and column.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from etextile.errors import BadInput, nearest
from etextile.types import Array, IntArray


MAX_BYTES = 200_000_000


@dataclass(frozen=True)
class Table:
    """Columns of a file: `numbers` and `texts` by name, each (n,), and the line (from 1) each row stands in, (n,)."""

    file: str
    numbers: dict[str, Array]
    texts: dict[str, tuple[str, ...]]
    lines: IntArray

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.lines)

    def line(self, row: int) -> int:
        """Return the line of the file that holds `row`."""
        return int(self.lines[row])


@dataclass(frozen=True)
class _Row:
    """Cells of one row and the line it stands in."""

    line: int
    cells: list[str]


def read_table(
    path: Path, required: Sequence[str], *, texts: Collection[str] = (), headerless: Sequence[str] = ()
) -> Table:
    """Read the columns `required` of a comma-separated file; other columns are ignored.

    `texts`: those of them that hold words. `headerless`: the names of all columns of a file without a header line.
    Blank lines and lines starting with '#' are skipped. Raises BadInput (file and line) for a missing or double column,
    a row with another number of cells, text in numbers, NaN or infinity, and a file without rows.
    """
    file = str(path)
    rows = _rows(_text(path), file)
    if headerless:
        names, body = list(headerless), rows
        _check_no_header(rows[0], names, file)
    else:
        names, body = _header(rows[0], required, file), rows[1:]
    if not body:
        raise BadInput.of(f"no data: only the header {','.join(names)}", file=file, line=rows[0].line)
    _check_width(body, names, file)
    wanted = [name for name in required if name in names]
    numbers = {name: _numbers(body, names.index(name), name, file) for name in wanted if name not in texts}
    words = {name: tuple(row.cells[names.index(name)] for row in body) for name in wanted if name in texts}
    return Table(file, numbers, words, np.array([row.line for row in body], dtype=np.int64))


def header_of(path: Path) -> tuple[str, ...]:
    """Return the column names in the first line of a file."""
    return tuple(_rows(_text(path), str(path))[0].cells)


def _text(path: Path) -> str:
    """Return the text of a file, or say why it cannot be read."""
    file = str(path)
    try:
        if path.is_file() and path.stat().st_size > MAX_BYTES:
            raise BadInput.of(f"larger than {MAX_BYTES // 1_000_000} MB: not a measured curve", file=file)
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise BadInput.of(f"no such file{_sibling(path)}", file=file) from None
    except UnicodeDecodeError:
        raise BadInput.of("not a text file in UTF-8; export the curve as CSV text", file=file, line=1) from None
    except OSError as error:
        raise BadInput.of(f"cannot be read ({error.strerror})", file=file) from None


def _sibling(path: Path) -> str:
    """Name the file in the same folder that was probably meant."""
    return nearest(path.name, [other.name for other in path.parent.iterdir()]) if path.parent.is_dir() else ""


def _rows(text: str, file: str) -> list[_Row]:
    """Split the text into rows of stripped cells with their lines."""
    rows = []
    for line, content in enumerate(text.splitlines(), start=1):
        if content.strip() and not content.lstrip().startswith("#"):
            cells = next(csv.reader(io.StringIO(content)))
            rows.append(_Row(line, [cell.strip() for cell in cells]))
    if not rows:
        raise BadInput.of("empty file: a header line and rows of numbers are expected", file=file, line=1)
    return rows


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _header(row: _Row, required: Sequence[str], file: str) -> list[str]:
    """Check the header line against the columns required."""
    names, line = row.cells, row.line
    wanted = ",".join(required)
    if all(_is_number(cell) for cell in names):
        message = f"no header: the first line must name the columns {wanted}"
        remedy = "or say them: --columns displacement_mm,force_N, or columns: in measured.yaml"
        raise BadInput.of(f"{message} ({remedy})", file=file, line=line)
    if len(names) == 1 and any(separator in names[0] for separator in ";\t"):
        raise BadInput.of(
            f"columns must be separated by commas, as in {wanted} (got {names[0]!r})", file=file, line=line
        )
    twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    if twice:
        raise BadInput.of(f"column {twice[0]!r} is given twice", file=file, line=line)
    missing = [name for name in required if name not in names]
    if missing:
        plural = "columns" if len(missing) > 1 else "column"
        found = ",".join(names)
        near = nearest(missing[0], [name for name in names if name not in required]).rpartition("mean ")[2].strip("?")
        hint = f"; rename or convert {near}" if near else ""
        message = f"missing {plural} {', '.join(map(repr, missing))} (got {found}), expected {wanted}{hint}"
        raise BadInput.of(message, file=file, line=line)
    return names


def _check_no_header(row: _Row, names: list[str], file: str) -> None:
    """Refuse a header line in a file that was declared to have none."""
    if not any(_is_number(cell) for cell in row.cells):
        message = f"a header ({','.join(row.cells)}) in a file declared as header-less ({','.join(names)})"
        raise BadInput.of(f"{message}: leave the declaration of columns out", file=file, line=row.line)


def _check_width(body: list[_Row], names: list[str], file: str) -> None:
    """Every row has as many cells as there are columns."""
    wrong = [row for row in body if len(row.cells) != len(names)]
    if wrong:
        message = f"{len(wrong[0].cells)} values for the {len(names)} columns {','.join(names)}"
        raise BadInput.of(message + _more(len(wrong)), file=file, line=wrong[0].line)


def _numbers(body: list[_Row], column: int, name: str, file: str) -> Array:
    """Return one column as finite numbers."""
    values = np.empty(len(body))
    wrong: list[tuple[int, str]] = []
    for i, row in enumerate(body):
        cell = row.cells[column]
        values[i] = float(cell) if _is_number(cell) else math.nan
        if not math.isfinite(values[i]):
            wrong.append((row.line, cell))
    if wrong:
        line, cell = wrong[0]
        message = f"{_fault(cell)}, a finite number is needed{_more(len(wrong))}"
        raise BadInput.of(message, file=file, line=line, key=name)
    return values


def _fault(cell: str) -> str:
    """Say what is wrong with a cell that is not a finite number."""
    if not cell:
        return "empty cell"
    return f"not a finite number (got {cell})" if _is_number(cell) else f"text in a column of numbers (got {cell!r})"


def _more(count: int) -> str:
    """Say in how many further rows the same is wrong."""
    return f" (and {count - 1} more row{'s' if count > 2 else ''})" if count > 1 else ""
