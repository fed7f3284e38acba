"""What was found in a measured file or a mesh as text."""

from __future__ import annotations

import textwrap
from typing import TYPE_CHECKING

from etextile.app.tables import print_table
from etextile.studies.inspect import FileColumn, Inspection, LeftOut, runs


if TYPE_CHECKING:
    from etextile.studies.inspect import InspectedMesh
    from etextile.studies.inspect_folder import InspectedFile, InspectedFolder

WIDTH = 100
MOST_RUNS = 4


def print_inspection(found: Inspection | InspectedMesh) -> None:
    """Print one line of findings, the columns, what is left out and why, and what the reader noted."""
    if isinstance(found, Inspection):
        _print_table_file(found)
    else:
        _print_mesh(found)


def _print_table_file(found: Inspection) -> None:
    kind = found.channel.replace("_", " ")
    print(f"{found.file}: {found.found}")
    if found.problems:
        print(f"not read as {kind}, see the message below")
    else:
        print(f"read as {kind}: {len(found.used)} of {found.rows} rows")
    print()
    heads = ("no", "in the file", "unit", "smallest", "largest", "read as", "times", "sign", "zero")
    print_table("columns", heads, [_row(item) for item in found.columns])
    if found.left_out:
        print_table("left out", ("rows", "lines", "why"), [_left_out(item) for item in found.left_out])
    for note in (note for note in found.notes if not note.startswith("read as ")):
        print(textwrap.fill(note, WIDTH, initial_indent="- ", subsequent_indent="  "))


def print_folder(found: InspectedFolder) -> None:
    """Print the files of a folder of measurements in a table; what is wrong follows as messages."""
    print(f"{found.folder}: {found.title}")
    heads = ("file", "channel", "rows used", "how it is read")
    print_table("files", heads, [_file_row(item) for item in found.files])


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


def _print_mesh(found: InspectedMesh) -> None:
    low, high = found.box
    print(f"{found.file}: mesh of {len(found.vertices)} vertices and {len(found.faces)} triangles")
    print("not usable as it is, see the message below" if found.problems else "closed, in one piece")
    rows = [
        (axis, f"{low[i]:.6g}", f"{high[i]:.6g}", f"{high[i] - low[i]:.6g}", f"{found.highest[i]:.6g}")
        for i, axis in enumerate(("x, along the warp", "y, along the weft", "z, up"))
    ]
    print_table("size, mm", ("axis", "from", "to", "length", "highest point"), rows)
    for note in found.notes:
        print(textwrap.fill(note, WIDTH, initial_indent="- ", subsequent_indent="  "))
