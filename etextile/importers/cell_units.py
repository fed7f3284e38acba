"""Units in the cells themselves (`0.5 mm`): taken out where a whole column has the same one, refused where not."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

from etextile.importers.dialect import Dialect, FileLines, FileRow, split_rows
from etextile.importers.labels import Label, factor, is_unit


USUAL = 0.5
"""Share of the lines from which on units in cells are how the file is written, and no fault of single cells."""
LOOKED_AT = 400
UNIT = r"[A-Za-zµμ°%][A-Za-z0-9µμ²³/%*^·]{0,11}"
CELL = re.compile(
    rf"(?P<number>(?:^|[,;\t|\"'])\s*[+\-\u2212]?[0-9](?:[0-9.,'’ \u00a0\u202f]*[0-9.])?(?:[eE][+-]?[0-9]+)?)"
    rf"[ \u00a0]?(?P<unit>{UNIT})(?=\s*[\"']?\s*(?:[,;\t|]|$))"
)
"""A cell that holds a number and a word behind it, as it stands in a line."""


@dataclass(frozen=True)
class CellUnits:
    """Units found in the cells: by column the one of all its cells, or what is wrong (line and message)."""

    units: dict[int, str]
    wrong: dict[int, tuple[int, str]]


def without_units(lines: FileLines) -> FileLines:
    """Return the lines with the units taken out of their cells; the lines themselves where cells have none."""
    step = max(1, len(lines.texts) // LOOKED_AT)
    some = lines.texts[::step]
    if sum(_carries(text) for text in some) < USUAL * len(some):
        return lines
    return replace(lines, texts=[CELL.sub(_number, text) for text in lines.texts])


def carries_unit(cell: str) -> bool:
    """Tell whether a cell is a number with its unit."""
    match = CELL.fullmatch(cell.strip())
    return match is not None and is_unit(match["unit"])


def units_of(
    lines: FileLines, body: Sequence[FileRow], dialect: Dialect, head: Sequence[Label], file: str
) -> CellUnits:
    """Return the units that stood in the cells of `body`, whose rows were made of lines without them."""
    first, last = body[0].line, body[-1].line
    rows = [row for row in split_rows(lines, dialect, file) if first <= row.line <= last]
    units, wrong = dict[int, str](), dict[int, tuple[int, str]]()
    for column in range(min(len(body[0].cells), min(len(row.cells) for row in rows))):
        found = [(row.line, _unit(row.cells[column])) for row in rows if row.cells[column]]
        counts = Counter(unit for _, unit in found)
        if set(counts) <= {""}:
            continue
        usual = counts.most_common(1)[0][0]
        other = next(((line, unit) for line, unit in found if unit != usual), None)
        own = head[column].unit if column < len(head) else None
        if other is not None:
            line, unit = other
            said = f"the unit in the cell is {unit!r}" if unit else "there is no unit in the cell"
            wrong[column] = (line, f"{said}, most others of the column have {usual or 'none'!r}; {REMEDY}")
        elif own is not None and own != usual and factor(own, usual) != 1.0:
            wrong[column] = (first, f"the name says {own or 'a plain number'!r}, the cells {usual!r}; {REMEDY}")
        else:
            units[column] = usual
    return CellUnits(units, wrong)


REMEDY = "write numbers alone, and the unit in the column's name"


def _carries(text: str) -> bool:
    return any(is_unit(match["unit"]) for match in CELL.finditer(text))


def _number(match: re.Match[str]) -> str:
    return match["number"] if is_unit(match["unit"]) else match[0]


def _unit(cell: str) -> str:
    match = CELL.fullmatch(cell)
    return match["unit"] if match and is_unit(match["unit"]) else ""
