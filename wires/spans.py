"""The strain of the fabric under each loop: the length from exit to entry along the deformed lattice.

Measured along the fabric from one cell line to the next, not across, so that neither the place of the lattice lines nor
the half of a loop that a symmetry plane cuts off changes the strain; a chord would cut the kinks of a coarse lattice.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.lattice.piece import Lattice
from etextile.types import Array, IntArray
from wires.cut import LatticeLines, border_crossings
from wires.lands import Lands
from wires.layout import WireLayout


@dataclass(frozen=True)
class LoopSpans:
    """Segments of all loops: nodes and weights (S, 4) of the vector along each, its loop (S,), flat length (L,) mm.

    `drawn` (L,) is what the vectors measure of the flat fabric: more or less than `flat` beside a land.
    """

    nodes: IntArray
    weights: Array
    loop: IntArray
    flat: Array
    drawn: Array

    @classmethod
    def of(cls, lattice: Lattice, layout: WireLayout, *, lands: Lands | None = None) -> LoopSpans:
        """Cut the modelled part of every loop at the lattice lines it crosses."""
        lines = LatticeLines.of(lattice)
        exits, entries, wire = layout.modelled_exit_mm, layout.modelled_entry_mm, layout.loop_wire
        borders = {int(number): border_crossings(layout, lines, int(number)) for number in np.unique(wire)}
        stops = [_stops(borders[int(w)], a, b) for w, a, b in zip(wire, exits, entries, strict=True)]
        start = np.concatenate([places[:-1] for places in stops] or [np.zeros(0)])
        end = np.concatenate([places[1:] for places in stops] or [np.zeros(0)])
        loop = np.repeat(np.arange(layout.n_loops), [len(places) - 1 for places in stops])
        middle, first, last = (layout.places(wire[loop], along) for along in (0.5 * (start + end), start, end))
        cell = lines.cells(middle)
        flat: Array = entries - exits
        drawn = flat
        if lands is not None:
            first, last = (lands.stretched(lines, layout, wire[loop], along, cell) for along in (start, end))
            distance = np.linalg.norm(last - first, axis=1)
            drawn = np.asarray(np.bincount(loop, distance, minlength=layout.n_loops), dtype=float)
        nodes, from_start = lines.interpolate(first, cell)
        _, from_end = lines.interpolate(last, cell)
        return cls(nodes, from_end - from_start, loop, flat, drawn)

    def strain(self, x: Array, *, shrink: Array | float = 1.0) -> Array:
        """Return the engineering strain (L,) of the spans at node positions x (P, 3).

        `shrink` (L,): length as woven over that of the flat piece, which mounting may have changed.
        """
        vectors = np.einsum("sk,skc->sc", self.weights, x[self.nodes])
        length = np.bincount(self.loop, np.linalg.norm(vectors, axis=1), minlength=len(self.flat))
        strain: Array = (length - shrink * (self.drawn - self.flat)) / (shrink * self.flat) - 1.0
        return strain


def _stops(lines: Array, start: float, end: float) -> Array:
    """Return start, the lattice lines between, and end; lines within a nanometre of an end count as that end."""
    between = np.unique(lines[(lines > start + 1e-6) & (lines < end - 1e-6)])
    return np.concatenate([[start], between, [end]])
