"""Cells that an edge cuts, as polygons for drawing, so that a clamped end is a straight line and not a row of teeth."""

from __future__ import annotations

import numpy as np

from etextile.types import BoolArray, IntArray


CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))
SIDES = ((0, 0, 0, 1), (1, 1, 0, 1), (0, 0, 1, -1), (1, 0, 0, -1))
"""Sides of a cell in turn: direction (0 warp, 1 weft), lattice offset of its first node, and the sense it is run in."""


def edge_cells(
    start: IntArray, direction: IntArray, nodes: IntArray, *, kept: BoolArray, skipping: bool = False
) -> IntArray:
    """Return cells with a cut side, as nodes (q, 4) in turn; a triangle repeats its last node, more than four corners
    take further rows.

    start (m, 2): lattice index of the first node of warp and weft trusses; direction (m,): 0 warp, 1 weft;
    nodes (m, 2): their ends, cut ones included; kept (m,): trusses that were not left off. Cells with a side that was
    left off are not drawn, or with `skipping` closed without it.
    """
    keys = zip(direction.tolist(), *start.T.tolist(), strict=True)
    gone: list[int] | None = [] if skipping else None
    sides = {key: ends if used else gone for key, ends, used in zip(keys, nodes.tolist(), kept.tolist(), strict=True)}
    near = start[:, None, :] - np.array([[0, 0], [1, 0], [0, 1], [1, 1]])
    found = []
    for i, j in np.unique(near.reshape(-1, 2), axis=0).tolist():
        ring = _ring(sides, i, j)
        found += [[ring[0], *(ring[k : k + 3] + ring[-1:])[:3]] for k in range(1, len(ring) - 1, 2)]
    return np.array(found, dtype=np.int64).reshape(-1, 4)


def _ring(sides: dict[tuple[int, int, int], list[int] | None], i: int, j: int) -> list[int]:
    """Return the nodes around a cell in turn; none for a whole cell, and for one with a side that was left off."""
    ring: list[int] = []
    whole = 0
    for direction, di, dj, sense in SIDES:
        key = (direction, i + di, j + dj)
        ends = sides.get(key, [])
        if ends is None:
            return []
        whole += len(ends) == 2
        ring += ends[::sense]
    ring = [node for k, node in enumerate(ring) if node != ring[k - 1]]
    return [] if whole == len(SIDES) and len(ring) == len(SIDES) else ring
