"""The reliability of a garment: expected numbers of lost wires with intervals, chances of any loss, of each net.

Everything is worked out from the chances of the parts given what they share (`wires.dependence`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from etextile.types import Array, BoolArray, IntArray
from wires.chances import OPEN_FROM, WHOLE_BELOW, Chances
from wires.dependence import EventProbability, Garment, LogGrid, Spread, Survival
from wires.layout import WireLayout
from wires.woven import WovenPieces


Happening = Literal["broken", "opened"]


@dataclass(frozen=True)
class WireStretch:
    """Stretches of one wire by the modelled wire they are images of: how many of its loops (L,) and pieces (P,)."""

    wire: int
    loops: IntArray
    woven: Array | None


@dataclass(frozen=True)
class Reliability:
    """What a criterion says of a garment at the end of a run: chances (G, 1, L) of loops and (G, 1, P) of pieces."""

    layout: WireLayout
    pieces: WovenPieces | None
    loops: Chances
    woven: Chances | None
    grid: LogGrid
    spread: Spread

    def garment(self, what: Happening) -> Garment:
        """Return how many wires lose a filament (`broken`) or are interrupted (`opened`)."""
        return self._broken if what == "broken" else self._opened

    @cached_property
    def _broken(self) -> Garment:
        return self._survival("broken").garment(self.layout.wire_copies)

    @cached_property
    def _opened(self) -> Garment:
        return self._survival("opened").garment(self.layout.wire_copies)

    def net(self, wire: int, from_loop: int, to_loop: int, *, what: Happening = "opened") -> EventProbability:
        """Return what happens to the loops of a wire from one to another, and to the weave between them."""
        layout, low, high = self.layout, min(from_loop, to_loop), max(from_loop, to_loop)
        loops = (layout.loop_wire == wire) & (layout.loop_index >= low) & (layout.loop_index <= high)
        woven = None
        if self.pieces is not None and loops.any():
            first, last = layout.loop_exit_mm[loops].min(), layout.loop_entry_mm[loops].max()
            woven = (self.pieces.wire == wire) & (self.pieces.start_mm > first) & (self.pieces.end_mm < last)
        return self._survival(what, loops=loops, woven=woven, once=True).on_wire(wire)

    def wire(self, wire: int, *, what: Happening = "broken") -> EventProbability:
        """Return what happens to a whole wire, with its images."""
        return self._survival(what).on_wire(wire)

    def loop(self, number: int) -> EventProbability:
        """Return that a filament breaks on one modelled loop."""
        one = np.arange(len(self.layout.loop_wire)) == number
        woven = None if self.pieces is None else np.zeros(len(self.pieces.wire))
        survival = self._survival("broken", loops=one, woven=woven, once=True)
        return survival.on_wire(int(self.layout.loop_wire[number]))

    def piece(self, number: int) -> EventProbability:
        """Return that a filament breaks on one modelled piece in the weave."""
        if self.pieces is None:
            raise ValueError("the criterion knows no wire in the weave")
        one = np.arange(len(self.pieces.wire)) == number
        survival = self._survival("broken", loops=np.zeros(self.layout.n_loops, dtype=bool), woven=one, once=True)
        return survival.on_wire(int(self.pieces.wire[number]))

    def series(self, stretches: Sequence[WireStretch]) -> EventProbability:
        """Return that something opens on stretches, each of another wire of the whole specimen."""
        found = [self._survival("opened", loops=item.loops, woven=item.woven, once=True) for item in stretches]
        loops, woven = (
            np.stack([getattr(part, name)[:, item.wire] for part, item in zip(found, stretches, strict=True)], axis=1)
            for name in ("loops", "woven")
        )
        return replace(found[0], loops=loops, woven=woven).garment(np.ones(len(found), dtype=np.int64)).anything

    def survival_of(self, stretch: WireStretch) -> Array:
        """Return that nothing opens on a stretch, given the factors of loops and of the weave (G, G)."""
        survival = self._survival("opened", loops=stretch.loops, woven=stretch.woven, once=True)
        return np.asarray(survival.loops[:, None, stretch.wire] * survival.woven[None, :, stretch.wire])

    def shared(self, lost: Array) -> EventProbability:
        """Return an event of wires that share all scatter, from its probabilities given the factors (G, G)."""
        size = 2 * self.grid.half + 1
        none = np.ones((size, 1))
        return Survival(none, none, self.grid, self.spread).given(np.broadcast_to(lost, (size, size)))

    def report(self) -> dict[str, Any]:
        """Return the keys of `reliability` in report.json; nets are added by `wires.electrical`."""
        found: dict[str, Any] = {"wires": int(self.layout.wire_copies.sum())}
        intervals: dict[str, Any] = {}
        for what, name in (("broken", "broken"), ("opened", "open")):
            garment = self.garment(what)  # type: ignore[arg-type]
            for key, event in (
                (f"expected_wires_{name}", garment.expected),
                (f"p_any_wire_{name}", garment.anything),
            ):
                found[key] = event.value
                intervals[key] = [event.low, event.high]
            found[f"wires_{name}_range"] = list(garment.range)
        low, high = intervals["p_any_wire_broken"]
        return {
            **found,
            "low": low,
            "high": high,
            "intervals": intervals,
            "limits": {"whole_below": WHOLE_BELOW, "open_from": OPEN_FROM},
            "scatter": vars(self.spread),
            "judged": ["loops"] if self.woven is None else ["loops", "weave"],
            "nets": [],
        }

    def _survival(
        self,
        what: Happening,
        *,
        loops: BoolArray | IntArray | None = None,
        woven: Array | BoolArray | None = None,
        once: bool = False,
    ) -> Survival:
        """Return the survival (G, W) of wires, over the chosen loops (L,) and pieces (P,); `once` without images."""
        layout = self.layout
        copies = np.ones_like(layout.loop_copies) if once else layout.loop_copies
        kept = copies if loops is None else copies * loops
        of_loops = survival(getattr(self.loops, what), layout.loop_wire, kept, layout.n_wires)[:, -1]
        of_woven = np.ones_like(of_loops)
        if self.woven is not None and self.pieces is not None:
            count = np.ones_like(self.pieces.copies) if once else self.pieces.copies
            shares: Array = np.asarray(count if woven is None else count * woven, dtype=float)
            of_woven = survival(getattr(self.woven, what), self.pieces.wire, shares, layout.n_wires)[:, -1]
        return Survival(of_loops, of_woven, self.grid, self.spread)


def survival(probability: Array, wire: IntArray, copies: IntArray | Array, count: int) -> Array:
    """Return prod (1 - p)^copies (G, S, W) over the parts of each of `count` wires, from p (G, S, n)."""
    logs = np.log1p(-np.minimum(probability, 1.0 - 1e-16))
    on = np.zeros((len(wire), count))
    on[np.arange(len(wire)), wire] = copies
    return np.asarray(np.exp(logs @ on))


def spread_of(parameters: Mapping[str, float], doubt: tuple[float, float]) -> Spread:
    """Return the spread that a criterion's parameters and its doubt about loops and weave describe."""
    return Spread(parameters.get("garment_scatter", 0.0), parameters.get("wire_scatter", 0.0), *doubt)
