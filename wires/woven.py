"""The wire in the weave: its pieces between loops, each as one length of wire with the strain that matters to it.

Along a piece the strain varies from element to element. By the weakest link (`wires.weakest_link`) what counts is the
mean of the power m of the Weibull shape,

    e = (sum l_k e_k^m / sum l_k)^(1 / m),

which depends on the strain along the wire and not on how finely the lattice cuts it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.results.wire_history import WireHistory
from etextile.results.wire_layout import ALONG_WARP, ALONG_WEFT
from etextile.types import Array, BoolArray, IntArray
from wires.layout import WireLayout


@dataclass(frozen=True)
class WovenPieces:
    """P pieces of woven-in wire: wire (P,), ends (P,) mm along the warp, their length as woven, how many they are.

    `element` (K,) is the piece of each woven-in element, `weight` (K,) the element's share of its piece.
    """

    wire: IntArray
    start_mm: Array
    end_mm: Array
    length_mm: Array
    copies: IntArray
    element: IntArray
    weight: Array

    @property
    def count(self) -> int:
        """Number of pieces P."""
        return len(self.wire)

    @classmethod
    def of(cls, history: WireHistory) -> WovenPieces:
        """Return the pieces of a history's wires; what a symmetry plane cuts is one piece of twice the length."""
        layout, middle = history.layout, element_places(history)
        length = element_lengths(history)
        cut = cut_by_plane(layout)
        order = np.full(len(middle), -1, dtype=np.int64)
        rows: list[tuple[int, float, float, float, int]] = []
        for wire in range(layout.n_wires):
            own = layout.loop_wire == wire
            exits = np.append(layout.loop_exit_mm[own], layout.end_mm[wire])
            entries = np.append(layout.start_mm[wire], layout.loop_entry_mm[own])
            for start, end in zip(entries, exits, strict=True):
                inside = (history.element_wire == wire) & (middle > start) & (middle < end)
                if not inside.any():
                    continue
                order[inside] = len(rows)
                at_plane = cut[wire] and start == layout.start_mm[wire]
                total = float(length[inside].sum())
                rows.append(
                    (wire, start, end, 2.0 * total if at_plane else total, 2 if cut[wire] and not at_plane else 1)
                )
        columns = list(zip(*rows, strict=True)) or [(), (), (), (), ()]
        modelled = np.bincount(order, length, minlength=len(rows)) if len(rows) else np.zeros(0)
        return cls(
            wire=np.array(columns[0], dtype=np.int64),
            start_mm=np.array(columns[1], dtype=float),
            end_mm=np.array(columns[2], dtype=float),
            length_mm=np.array(columns[3], dtype=float),
            copies=np.array(columns[4], dtype=np.int64),
            element=order,
            weight=length / modelled[order] if len(order) else length,
        )

    def mean(self, strain: Array, shape: float) -> Array:
        """Return the strains (S, P) that count, from those of the elements (S, K)."""
        peak = self.peak(strain)
        safe = np.where(peak > 0.0, peak, 1.0)
        total = np.zeros((self.count, len(strain)))
        np.add.at(total, self.element, (self.weight * (np.maximum(strain, 0.0) / safe[:, self.element]) ** shape).T)
        return np.asarray(np.where(peak > 0.0, safe * total.T ** (1.0 / shape), 0.0))

    def peak(self, strain: Array) -> Array:
        """Return the greatest strain (S, P) of each piece, from those of the elements (S, K)."""
        found = np.zeros((self.count, len(strain)))
        np.maximum.at(found, self.element, strain.T)
        return found.T


def cut_by_plane(layout: WireLayout) -> BoolArray:
    """Return which wires (W,) are the half of a wire that a symmetry plane cuts at their start."""
    places = {ALONG_WARP: layout.vertex_warp_mm, ALONG_WEFT: layout.vertex_weft_mm}
    cut = np.zeros(layout.n_wires, dtype=bool)
    for kind, coordinate in places.items():
        if len(coordinate) and (coordinate >= 0.0).all():
            cut |= (layout.kind == kind) & (layout.start_mm == 0.0)
    return cut


def element_places(history: WireHistory) -> Array:
    """Return the coordinates (K,) along their wires of the middles of woven-in elements."""
    return history.element_warp_mm if history.element_along_mm is None else history.element_along_mm


def element_lengths(history: WireHistory) -> Array:
    """Return the lengths (K,) of woven-in elements.

    Where a history has none they are rebuilt from the middles: they fill the wire between loops.
    """
    if history.element_length_mm is not None:
        return history.element_length_mm
    layout, middle = history.layout, element_places(history)
    length = np.zeros(len(history.element_wire))
    for wire in range(layout.n_wires):
        loops = layout.loop_wire == wire
        exits = np.append(np.where(layout.loop_halved[loops], 0.0, layout.loop_exit_mm[loops]), layout.end_mm[wire])
        entries = np.append(layout.start_mm[wire], layout.loop_entry_mm[loops])
        for start, end in zip(entries, exits, strict=True):
            own = np.flatnonzero((history.element_wire == wire) & (middle > start) & (middle < end))
            for element in own[np.argsort(middle[own])]:
                length[element] = 2.0 * (middle[element] - start)
                start += length[element]
    return length
