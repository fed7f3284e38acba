"""The strain of the fabric under each loop: the length from exit to entry along the deformed lattice.

Measured along the fabric from one cell line to the next, not across, so that neither the place of the lattice lines nor
the half of a loop that a symmetry plane cuts off changes the strain; a chord would cut the kinks of a coarse lattice.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.lattice.piece import Lattice
from etextile.types import Array, IntArray
from wires.embed import Lines
from wires.layout import WireLayout


@dataclass(frozen=True)
class LoopSpans:
    """Segments of all loops: nodes and weights (S, 4) of the vector along each, its loop (S,), flat length (L,) mm."""

    nodes: IntArray
    weights: Array
    loop: IntArray
    flat: Array

    @classmethod
    def of(cls, lattice: Lattice, layout: WireLayout) -> LoopSpans:
        """Cut the modelled part of every loop at the lattice lines it crosses."""
        lines = Lines.of(lattice)
        exits = np.where(layout.loop_halved, 0.0, layout.loop_exit_mm)
        stops = [_stops(lines.x, a, b) for a, b in zip(exits, layout.loop_entry_mm, strict=True)]
        start = np.concatenate([places[:-1] for places in stops] or [np.zeros(0)])
        end = np.concatenate([places[1:] for places in stops] or [np.zeros(0)])
        loop = np.repeat(np.arange(layout.n_loops), [len(places) - 1 for places in stops])
        cell = lines.column(0.5 * (start + end))
        weft = layout.loop_weft_mm[loop]
        nodes, from_start = lines.interpolate(start, weft, cell)
        _, from_end = lines.interpolate(end, weft, cell)
        return cls(nodes, from_end - from_start, loop, layout.loop_entry_mm - exits)

    def strain(self, x: Array) -> Array:
        """Return the engineering strain (L,) of the spans at node positions x (P, 3)."""
        vectors = np.einsum("sk,skc->sc", self.weights, x[self.nodes])
        length = np.bincount(self.loop, np.linalg.norm(vectors, axis=1), minlength=len(self.flat))
        strain: Array = length / self.flat - 1.0
        return strain


def _stops(lines: Array, start: float, end: float) -> Array:
    """Return start, the lattice lines between, and end; lines within a nanometre of an end count as that end."""
    between = lines[(lines > start + 1e-6) & (lines < end - 1e-6)]
    return np.concatenate([[start], between, [end]])
