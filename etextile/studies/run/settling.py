"""Does a piece settle under repeated loading? Plastic strain added from peak to peak, until it is none.

A piece that is loaded again and again to the same depth flows a little less each time (friction and slack let it) until
it only swings: it shakes down. A path of many cycles is then at its end as far as plasticity goes: what is left of it
lies inside of what was simulated, and the strains there are those of the settled cycles at the same travel. Of a piece
that does not settle the report says so, with the plastic strain that its last cycle adds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from etextile.results.reader import Results
from etextile.types import Array, IntArray


IN_TURN = 2
"""So many cycles in turn must add less than the tolerance."""
WITHIN = 0.05
"""What is left of a path may go back further than what was simulated by this share of the reach."""


def peaks(travel: Array) -> IntArray:
    """Return the output steps (k,) at which a path (S,) turns back, and its end when it rises there."""
    rises = np.diff(travel, prepend=-np.inf, append=-np.inf) > 0.0
    return np.asarray(np.flatnonzero(rises[:-1] & ~rises[1:]), dtype=np.int64)


@dataclass
class Settling:
    """The growth of plastic strain from peak to peak of a path; travel: (S,) output steps, tolerance: a strain.

    `over`: the rest of the path adds nothing new.
    """

    travel: Array
    tolerance: float

    def __post_init__(self) -> None:
        """Begin before the first peak."""
        self.at = peaks(self.travel)
        self.growth: list[float] = []
        self._last: Array | None = None
        self.over = False

    def take(self, step: int, plastic: Array) -> bool:
        """Take the plastic strains (m,) of an output step; True when the rest of the path adds nothing new."""
        if step not in self.at:
            return False
        if self._last is not None:
            self.growth.append(float(np.abs(plastic - self._last).max(initial=0.0)))
        self._last = np.array(plastic)
        self.over = self.over or (self.settled and self._covers(step))
        return self.over

    @property
    def settled(self) -> bool:
        """Tell whether the last cycles added less plastic strain than the tolerance."""
        last = self.growth[-IN_TURN:]
        return len(last) == IN_TURN and max(last) < self.tolerance

    def _covers(self, step: int) -> bool:
        """Tell whether what is left of the path lies within what was simulated since the first peak."""
        done, left = self.travel[self.at[0] : step + 1], self.travel[step + 1 :]
        reach = float(self.travel.max())
        return bool(
            left.size and left.max() <= self.travel[: step + 1].max() and left.min() >= done.min() - WITHIN * reach
        )


def settling_of(results: Results, travel: Array, tolerance: float) -> Settling:
    """Return the growth of plastic strain over the peaks that a result file holds."""
    found = Settling(travel, tolerance)
    for step in found.at[found.at < results.steps]:
        found.take(int(step), results.array("plastic_strain", int(step)))
    return found


def work_lost(results: Results, found: Settling, factor: float) -> dict[str, list[float]]:
    """Return the work (N mm) that plastic flow and friction took from peak to peak, the area of a cycle in the curve.

    factor: how often the modelled part stands in the whole piece.
    """
    rows = results.increments
    ends = [int(np.flatnonzero(rows.step == step)[0]) for step in found.at[: len(found.growth) + 1]]
    names = ("plastic_work", "friction_work")
    return {f"{name}_Nmm": (factor * np.diff(getattr(rows, name)[ends])).tolist() for name in names}


def cycles_block(found: Settling, steps: int) -> dict[str, Any] | None:
    """Return the entry `cycles` of the report for a run of `steps` output steps, None for less than two peaks."""
    if not found.growth:
        return None
    simulated, total = len(found.growth), len(found.at) - 1
    return {
        "in_path": total,
        "simulated": simulated,
        "settled": found.growth[-1] < found.tolerance,
        "ended_early": steps < len(found.travel),
        "plastic_strain_added": found.growth,
        "tolerance": found.tolerance,
        "sentence": _sentence(found, simulated, total, early=steps < len(found.travel)),
    }


def _sentence(found: Settling, simulated: int, total: int, *, early: bool) -> str:
    last, many = found.growth[-1], f"{simulated} cycle{'s' if simulated > 1 else ''}"
    if found.tolerance > 0.0 and last < found.tolerance:
        text = f"the piece has settled: the last of {many} adds {last:.1e} of plastic strain at most"
        if early:
            text += f"; the other {total - simulated} were not simulated, their strains are those of the settled cycles"
        return text
    return f"the piece has not settled: the last of {many} still adds {last:.1e} of plastic strain"
