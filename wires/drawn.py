"""What a designer draws: wires by name with kind, vertices and loops, each knowing where it was written."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from etextile.errors import Problem
from etextile.results.wire_layout import ALONG_WARP, ALONG_WEFT
from etextile.types import Array
from wires.lines import distance_along


@dataclass(frozen=True)
class Origin:
    """Where something was written: file, line and key of a case, or the entity of a drawing as key."""

    file: str = ""
    line: int | None = None
    key: str = ""

    def problem(self, message: str, *, key: str = "") -> Problem:
        """Return a problem at this place, or at a key below it."""
        return Problem(message, self.file, self.line, key=f"{self.key}.{key}" if key and not self.file else self.key)


@dataclass(frozen=True)
class LoopSpec:
    """A loop: coordinate along the wire or place (warp, weft) of its centre, length of fabric it spans, slack, part."""

    at: float | tuple[float, float]
    length_mm: float
    slack: float
    rigid_mm: float = 0.0
    origin: Origin = field(default_factory=Origin, compare=False)


@dataclass(frozen=True)
class PathSpec:
    """A wire of the whole specimen: name, kind (index into KINDS), vertices (n, 2) warp and weft, mm, and loops."""

    name: str
    kind: int
    points: tuple[tuple[float, float], ...]
    loops: tuple[LoopSpec, ...] = ()
    origin: Origin = field(default_factory=Origin, compare=False)

    @cached_property
    def line(self) -> Array:
        """Vertices as an array (n, 2)."""
        return np.array(self.points, dtype=float).reshape(-1, 2)

    @property
    def along(self) -> Array:
        """Coordinate along the wire of each vertex (n,)."""
        if self.kind in (ALONG_WARP, ALONG_WEFT):
            return np.asarray(self.line[:, self.kind])
        return distance_along(self.line)


@dataclass(frozen=True)
class Centred:
    """A loop by its centre's coordinate along the wire."""

    along: float
    spec: LoopSpec
