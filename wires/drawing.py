"""Drawings of wires and parts as files (.csv, .dxf), read to the specifications that a case's own paths give.

A drawing lies in fabric coordinates: x along the warp, y along the weft, origin in the centre of the whole specimen. It
must say its unit, or the case does; a unit is never guessed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.results.wire_layout import ALONG_WARP, ALONG_WEFT, LAID
from etextile.types import Array
from wires.drawn import LoopSpec, PathSpec
from wires.parts import PartSpec


UNITS = {"mm": 1.0, "cm": 10.0, "m": 1000.0, "um": 1e-3, "in": 25.4}
"""Units that drawings may be in, mm."""
DEFAULT_LOOP_MM = 4.0
DEFAULT_LAND_MM = (3.0, 3.0)


@dataclass(frozen=True)
class Drawing:
    """What a file holds: wires of the whole specimen with their loops, and parts."""

    wires: tuple[PathSpec, ...]
    parts: tuple[PartSpec, ...] = ()

    def moved(self, along_warp: float, along_weft: float) -> Drawing:
        """Return the drawing at another place of the piece, mm."""

        def there(place: tuple[float, float]) -> tuple[float, float]:
            return place[0] + along_warp, place[1] + along_weft

        def loop(item: LoopSpec, kind: int) -> LoopSpec:
            if isinstance(item.at, tuple):
                return replace(item, at=there(item.at))
            step = {ALONG_WARP: along_warp, ALONG_WEFT: along_weft}.get(kind, 0.0)
            return replace(item, at=item.at + step)

        wires = tuple(
            replace(
                item,
                points=tuple(there(point) for point in item.points),
                loops=tuple(loop(own, item.kind) for own in item.loops),
            )
            for item in self.wires
        )
        return Drawing(wires, tuple(replace(part, at=there(part.at)) for part in self.parts))


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
