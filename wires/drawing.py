"""Drawings of wires and parts as files (.csv, .dxf), read to the specifications that a case's own paths give.

A drawing lies in fabric coordinates: x along the warp, y along the weft, origin in the centre of the whole specimen. It
must say its unit, or the case does; a unit is never guessed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from etextile.errors import BadInput
from etextile.results.wire_layout import ALONG_WARP, ALONG_WEFT, LAID
from etextile.types import Array
from wires.parts import PartSpec
from wires.paths import PathSpec


UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "um": 1e-3, "in": 25.4}
"""Units that drawings may be in, mm."""
MOST_BYTES = 50_000_000
MOST_WIRES = 2000
DEFAULT_LOOP_MM = 4.0
DEFAULT_LAND_MM = (3.0, 3.0)
SUFFIXES = (".csv", ".dxf")


@dataclass(frozen=True)
class Drawing:
    """What a file holds: wires of the whole specimen with their loops, and parts."""

    wires: tuple[PathSpec, ...]
    parts: tuple[PartSpec, ...] = ()


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
    if path.suffix.lower() == ".dxf":
        from wires.drawing_dxf import read_dxf as read
    elif path.suffix.lower() == ".csv":
        from wires.drawing_csv import read_csv as read
    else:
        raise BadInput.of(f"not a drawing (got {path.suffix!r}), give a .csv or .dxf file", file=str(path))
    found = read(path, units=units, slack=slack)
    if not found.wires:
        raise BadInput.of("the drawing holds no wires", file=str(path))
    if len(found.wires) > MOST_WIRES:
        raise BadInput.of(f"the drawing holds {len(found.wires)} wires, at most {MOST_WIRES} are taken", file=str(path))
    return found


def write_drawing(drawing: Drawing, path: Path) -> None:
    """Write a drawing in the format that the file's name asks for, in mm; raises BadInput for another format."""
    if path.suffix.lower() == ".dxf":
        from wires.drawing_dxf import write_dxf as write
    elif path.suffix.lower() == ".csv":
        from wires.drawing_csv import write_csv as write
    else:
        raise BadInput.of(f"not a drawing (got {path.suffix!r}), write a .csv or .dxf file", file=str(path))
    write(drawing, path)


def kind_of(points: Array, *, laid: bool = False) -> tuple[int, tuple[tuple[float, float], ...]]:
    """Return kind and vertices of a drawn line (n, 2): straight along warp or weft is woven, else it is laid."""
    plain = tuple((float(x), float(y)) for x, y in points)
    if laid or len(points) < 2:
        return LAID, plain
    for kind, across in ((ALONG_WARP, 1), (ALONG_WEFT, 0)):
        along = points[:, kind]
        if np.ptp(points[:, across]) < 1e-6 and (np.all(np.diff(along) > 0.0) or np.all(np.diff(along) < 0.0)):
            ends = plain[0], plain[-1]
            return kind, tuple(sorted(ends))
    return LAID, plain


def shown(points: Sequence[float]) -> str:
    """Return a place as `(x, y) mm`."""
    return f"({points[0]:g}, {points[1]:g}) mm"
