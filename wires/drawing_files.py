"""Drawings in files: the format follows from the name, and what is read is bounded before it is read."""

from __future__ import annotations

from pathlib import Path

from etextile.errors import BadInput
from etextile.importers.foreign import what_it_is
from wires.drawing import Drawing


MOST_BYTES = 50_000_000
MOST_WIRES = 2000
MOST_PAIRS = 200_000
"""Parts times wires: each part is looked for on each wire."""
SUFFIXES = (".csv", ".dxf")


def read_drawing(path: Path, *, units: str | None = None, slack: float = 0.02) -> Drawing:
    """Return the wires and parts of a drawing; `slack` is that of loops which do not say theirs.

    Raises BadInput with everything that is wrong in the file.
    """
    if not path.is_file():
        raise BadInput.of(f"no such drawing (got {str(path)!r}), give a .csv or .dxf file", key="wires.layout")
    if path.stat().st_size > MOST_BYTES:
        size = path.stat().st_size / 1e6
        raise BadInput.of(
            f"the drawing is too large ({size:.0f} MB), at most {MOST_BYTES / 1e6:.0f} MB", file=str(path)
        )
    if path.suffix.lower() not in SUFFIXES:
        raise BadInput.of(f"not a drawing (got {path.suffix!r}), give a .csv or .dxf file", file=str(path))
    _refuse_foreign(path)
    if path.suffix.lower() == ".dxf":
        from wires.drawing_dxf import read_dxf as read
    else:
        from wires.drawing_csv import read_csv as read
    found = read(path, units=units, slack=slack)
    if not found.wires:
        raise BadInput.of("the drawing holds no wires", file=str(path))
    if len(found.wires) > MOST_WIRES:
        raise BadInput.of(f"the drawing holds {len(found.wires)} wires, at most {MOST_WIRES} are taken", file=str(path))
    pairs = len(found.wires) * len(found.parts)
    if pairs > MOST_PAIRS:
        text = f"the drawing holds {len(found.parts)} parts on {len(found.wires)} wires, at most {MOST_PAIRS} pairs"
        raise BadInput.of(f"{text} are taken", file=str(path))
    return found


def _refuse_foreign(path: Path) -> None:
    """Raise BadInput for a file that is something else than its name says."""
    with path.open("rb") as file:
        head = file.read(1024)
    if head[:2] == b"AC" and head[2:6].isdigit():
        raise BadInput.of("no drawing that can be read: this is a DWG file; save it as DXF", file=str(path))
    if words := what_it_is(head):
        raise BadInput.of(f"no drawing that can be read: this is {words}", file=str(path))


def write_drawing(drawing: Drawing, path: Path) -> None:
    """Write a drawing in the format that the file's name asks for, in mm; raises BadInput for another format."""
    if path.suffix.lower() == ".dxf":
        from wires.drawing_dxf import write_dxf as write
    elif path.suffix.lower() == ".csv":
        from wires.drawing_csv import write_csv as write
    else:
        raise BadInput.of(f"not a drawing (got {path.suffix!r}), write a .csv or .dxf file", file=str(path))
    write(drawing, path)
