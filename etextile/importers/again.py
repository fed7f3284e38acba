"""Words within a table: its names on a new page, a remark of the machine, or the names of the next specimen's."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from etextile.errors import BadInput
from etextile.importers.dialect import FileRow
from etextile.importers.numerals import is_number, value_of


def without_names(
    body: Sequence[FileRow], above: Sequence[FileRow], decimal: str, file: str
) -> tuple[list[FileRow], list[FileRow]]:
    """Return the rows of the table and those within that repeat its names or hold a remark (`above`: rows before it).

    A remark is one cell of words between two rows of the table. Raises BadInput where numbers begin anew below such
    rows: that is another specimen's table.
    """
    heads = [row.cells for row in above[-2:] if len(row.cells) > 1]
    width = Counter(len(row.cells) for row in body).most_common(1)[0][0] if body else 0
    repeats = {i for i in range(1, len(body) - 1) if _is_remark(body[i - 1 : i + 2], width, decimal)}
    for i in [i for i, row in enumerate(body) if row.cells in heads]:
        repeats |= _words_around(body, i, decimal)
    kept = [row for i, row in enumerate(body) if i not in repeats]
    for i in sorted(repeats):
        before = next((body[j] for j in range(i - 1, -1, -1) if j not in repeats), None)
        after = next((body[j] for j in range(i + 1, len(body)) if j not in repeats), None)
        if before is not None and after is not None and _anew(body[0], before, after, decimal):
            same = "with the same names " if any(body[j].cells in heads for j in repeats) else ""
            message = f"another table {same}begins here, of the next specimen or test"
            remedy = "put each into a file of its own"
            raise BadInput.of(f"{message}; {remedy}", file=file, line=body[i].line)
    return kept, [body[i] for i in sorted(repeats)]


def _is_remark(rows: Sequence[FileRow], width: int, decimal: str) -> bool:
    """Tell whether the middle one of three rows is a remark."""
    before, row, after = (item.cells for item in rows)
    filled = [cell for cell in row if cell]
    around = all(len(cells) == width and any(is_number(cell, decimal) for cell in cells) for cells in (before, after))
    return around and len(row) != width and len(filled) == 1 and not is_number(filled[0], decimal)


def _words_around(body: Sequence[FileRow], at: int, decimal: str) -> set[int]:
    """Return the rows without numbers, or of another width, right above and below a row of names, with it."""
    width = len(body[at].cells)

    def apart(row: FileRow) -> bool:
        return len(row.cells) != width or not any(is_number(cell, decimal) for cell in row.cells)

    first = last = at
    while first > 1 and apart(body[first - 1]):
        first -= 1
    while last + 1 < len(body) and apart(body[last + 1]):
        last += 1
    return set(range(first, last + 1))


def _anew(first: FileRow, before: FileRow, after: FileRow, decimal: str) -> bool:
    """Tell whether most columns that change stand nearer to their first value again than to the one before."""
    votes = 0
    for cells in zip(first.cells, before.cells, after.cells, strict=False):
        start, last, now = (value_of(cell, decimal) for cell in cells)
        if start is None or last is None or now is None or start == last:
            continue
        votes += 1 if abs(now - start) < abs(now - last) else -1
    return votes > 0
