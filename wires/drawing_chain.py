"""Lines of a drawing put end to end: programs write a meander as hundreds of pieces, in any order and direction."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from etextile.types import Array
from wires.drawing import shown


GAP_MM = 0.01
"""Ends of lines this close to each other are one place."""


def chained(lines: Sequence[Array]) -> tuple[Array | None, str]:
    """Return the vertices (n, 2) of lines put end to end, the first as it stands, or what keeps them apart."""
    ends = _Ends(lines)
    after = ends.walk(lines[0][-1])
    before = ends.walk(lines[0][0])
    if ends.left:
        chain = [before[-1][-1] if before else lines[0][0], after[-1][-1] if after else lines[0][-1]]
        gap, place = ends.nearest(np.array(chain))
        return None, f"has open ends: a gap of {gap:.3g} mm at {shown(place.tolist())}, one layer is one unbroken line"
    return np.concatenate([*(way[:0:-1] for way in before[::-1]), lines[0], *(way[1:] for way in after)]), ""


class _Ends:
    """The ends of lines, and which lines are not yet in the chain."""

    def __init__(self, lines: Sequence[Array]) -> None:
        from scipy.spatial import cKDTree

        self._lines = lines
        self.left = set(range(1, len(lines)))
        self._places = np.array([end for line in lines for end in (line[0], line[-1])])
        self._tree = cKDTree(self._places)

    def walk(self, place: Array) -> list[Array]:
        """Return the lines that go on from a place, each from where the one before ends, and take them."""
        found: list[Array] = []
        while near := [end for end in self._tree.query_ball_point(place, GAP_MM) if end // 2 in self.left]:
            end = min(near, key=lambda item: float(np.linalg.norm(self._places[item] - place)))
            self.left.discard(end // 2)
            line = self._lines[end // 2]
            found.append(line[::-1] if end % 2 else line)
            place = found[-1][-1]
        return found

    def nearest(self, chain: Array) -> tuple[float, Array]:
        """Return how far the nearest line that is left lies from the ends (2, 2) of a chain, and from which, mm."""
        rest = self._places[[2 * number + side for number in sorted(self.left) for side in (0, 1)]]
        gap = np.linalg.norm(rest[:, None] - chain[None], axis=2)
        return float(gap.min()), np.asarray(chain[int(gap.min(axis=0).argmin())])
