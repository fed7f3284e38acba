"""What was found in a measured file or a mesh as text."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING

from etextile.studies.inspect import FileColumn, Inspection, LeftOut, runs
from etextile.text.columns import Columns


if TYPE_CHECKING:
    from etextile.studies.inspect import InspectedMesh
    from etextile.studies.inspect_folder import InspectedFile, InspectedFolder

WIDTH = 100
MOST_RUNS = 4


def inspection(found: Inspection | InspectedMesh) -> Iterator[str | Columns]:
    """Yield one line of findings, the columns, what is left out and why, and what the reader noted."""
    return _table_file(found) if isinstance(found, Inspection) else _mesh(found)


def folder_inspection(found: InspectedFolder) -> Iterator[str | Columns]:
    """Yield the files of a folder of measurements in a table; what is wrong is in its problems."""
    yield f"{found.folder}: {found.title}"
    heads = ("file", "channel", "rows used", "how it is read")
    yield Columns("files", heads, [_file_row(item) for item in found.files])


def _table_file(found: Inspection) -> Iterator[str | Columns]:
    kind = found.channel.replace("_", " ")
    yield f"{found.file}: {found.found}"
    if found.problems:
        yield f"not read as {kind}, see the message below\n"
    else:
        yield f"read as {kind}: {len(found.used)} of {found.rows} rows\n"
    heads = ("no", "in the file", "unit", "smallest", "largest", "read as", "times", "sign", "zero")
    yield Columns("columns", heads, [_row(item) for item in found.columns])
    if found.left_out:
        yield Columns("left out", ("rows", "lines", "why"), [_left_out(item) for item in found.left_out])
    yield from (_noted(note) for note in found.notes if not note.startswith("read as "))


def _noted(note: str) -> str:
    return textwrap.fill(note, WIDTH, initial_indent="- ", subsequent_indent="  ")


def _file_row(item: InspectedFile) -> tuple[str, ...]:
    """Return the line of one file."""
    if not item.channel:
        return (item.file, "-", "-", "not named in measured.yaml, not read")
    if item.found is None or item.problems:
        return (item.file, item.channel, "-", "not read, see the message below")
    said = item.found.found.removeprefix("read as ")
    return (item.file, item.channel, f"{len(item.found.used)} of {item.found.rows}", said)


def _row(item: FileColumn) -> tuple[str, ...]:
    """Return the line of one column; a column that is not read has dashes."""
    ends = tuple("-" if value is None else f"{value:.6g}" for value in (item.low, item.high))
    plain = item.unit if item.unit is None or item.unit else "plain number"
    said = (str(item.number), item.name or "-", plain or "-", *ends)
    if not item.quantity:
        return (*said, "not read", "-", "-", "-")
    return (*said, item.quantity, f"{item.factor:.6g}", "-" if item.sign < 0 else "+", f"{item.zero:.6g}")


def _left_out(item: LeftOut) -> tuple[str, str, str]:
    parts = [f"{first} to {last}" if last > first else str(first) for first, last in runs(item.lines)]
    shown = ", ".join(parts[:MOST_RUNS]) + (f" and {len(parts) - MOST_RUNS} more" if len(parts) > MOST_RUNS else "")
    return str(len(item.lines)), shown, item.why


def _mesh(found: InspectedMesh) -> Iterator[str | Columns]:
    low, high = found.box
    yield f"{found.file}: mesh of {len(found.vertices)} vertices and {len(found.faces)} triangles"
    yield "not usable as it is, see the message below" if found.problems else "closed, in one piece"
    rows = [
        (axis, f"{low[i]:.6g}", f"{high[i]:.6g}", f"{high[i] - low[i]:.6g}", f"{found.highest[i]:.6g}")
        for i, axis in enumerate(("x, along the warp", "y, along the weft", "z, up"))
    ]
    yield Columns("size, mm", ("axis", "from", "to", "length", "highest point"), rows)
    yield from map(_noted, found.notes)
