"""Cyclic life of the loops: strain swings by rainflow counting, a strain-life law of the user's, Miner's sum.

Of the law nothing is known beforehand (no strain life of the wires of such fabrics is published), so there is no
default: either the coefficients of Coffin and Manson, strain range / 2 = coefficient (2 cycles)^exponent (thin copper
has exponents of about -0.5 to -0.7), or a table of strain ranges and cycles, interpolated on logarithms.

What is counted is the path from its first turn on: the first loading stretches wire and fabric for good, later cycles
swing less, so its strain is told apart and not added to Miner's sum. A path without a turn is closed by the way back
to the flat fabric, with the whole strain as the swing: an upper bound, since a thin wire that was stretched buckles on
the way back instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from rainflow import extract_cycles

from etextile.results.wire_history import WireHistory
from etextile.types import Array


CYCLE_FROM = 0.5
"""A swing of the motion is a cycle when it is at least this share of the largest one."""


class StrainLife(Protocol):
    """Cycles to failure over the strain range, and where the law comes from."""

    @property
    def source(self) -> str:
        """Where the numbers come from."""
        ...

    def cycles(self, strain_range: Array) -> Array:
        """Return the cycles to failure (n,); infinite where nothing swings."""
        ...

    def report(self) -> dict[str, Any]:
        """Return the law for the report."""
        ...


@dataclass(frozen=True)
class CoffinManson:
    """Coefficient (fatigue ductility) and exponent (negative), and where they come from."""

    coefficient: float
    exponent: float
    source: str

    def cycles(self, strain_range: Array) -> Array:
        """Return the cycles to failure (n,); infinite where nothing swings."""
        with np.errstate(divide="ignore"):
            reversals = (0.5 * np.asarray(strain_range) / self.coefficient) ** (1.0 / self.exponent)
        return np.asarray(0.5 * reversals)

    def report(self) -> dict[str, Any]:
        """Return the law for the report."""
        return {"law": "coffin_manson", "coefficient": self.coefficient, "exponent": self.exponent}


@dataclass(frozen=True)
class StrainTable:
    """Strain ranges (rising) and cycles (falling), straight lines on logarithms, going on beyond both ends."""

    strain_range: tuple[float, ...]
    cycles_to_failure: tuple[float, ...]
    source: str

    def cycles(self, strain_range: Array) -> Array:
        """Return the cycles to failure (n,); infinite where nothing swings."""
        x, y = np.log(self.strain_range), np.log(self.cycles_to_failure)
        with np.errstate(divide="ignore"):
            at = np.log(np.asarray(strain_range, dtype=np.float64))
        part = np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2)
        slope = np.diff(y) / np.diff(x)
        return np.asarray(np.exp(y[part] + slope[part] * (at - x[part])))

    def report(self) -> dict[str, Any]:
        """Return the law for the report."""
        return {"law": "table", "strain_range": self.strain_range, "cycles": self.cycles_to_failure}


@dataclass(frozen=True)
class Swings:
    """Cycles counted in one history: ranges, means and counts (n,), halves as 0.5."""

    ranges: Array
    means: Array
    counts: Array

    @property
    def largest(self) -> tuple[float, float]:
        """Range and mean of the largest swing, zeros without one."""
        if not len(self.ranges):
            return 0.0, 0.0
        most = int(np.argmax(self.ranges))
        return float(self.ranges[most]), float(self.means[most])

    def damage(self, law: StrainLife) -> float:
        """Return Miner's sum over the history, sum count / cycles(range)."""
        with np.errstate(over="ignore"):
            return float(np.sum(self.counts / law.cycles(self.ranges)))


def swings(series: Array) -> Swings:
    """Count the cycles of a history (S,) by rainflow (ASTM E1049, section 5.4.4)."""
    # the library gives nothing for two points; a first point that stands twice changes no reversal
    found = [(size, mean, count) for size, mean, count, _, _ in extract_cycles([series[0], *series]) if size > 0.0]
    return Swings(*np.array(found, dtype=np.float64).reshape(-1, 3).T)


@dataclass(frozen=True)
class Cycles:
    """The cyclic part of a run: `motion` (S,), strains `loops` (S, L), and what the first loading reached, (L,)."""

    motion: Array
    loops: Array
    first: Array
    repeated: bool

    @classmethod
    def of(cls, history: WireHistory) -> Cycles:
        """Return the path from its first turn on; one without a turn is closed by the way back."""
        motion, strain = history.displacement_mm, history.wire_strain
        back = np.flatnonzero(np.diff(motion) < 0.0)
        if not back.size:
            return cls(np.append(motion, motion[0]), np.vstack([strain, strain[:1]]), strain.max(axis=0), False)
        turn = int(back[0])
        return cls(motion[turn:], strain[turn:], strain[: turn + 1].max(axis=0), True)

    def continued(self, left: Array) -> Cycles:
        """Return the cycles with the travels (R,) left of a settled path, at the strains of the settled cycles.

        Those are the mean of the latest way down and the latest way up that come by a travel (of the ones that come
        nearest, where none does).
        """
        turns = np.flatnonzero(np.diff(np.sign(np.diff(self.motion)))) + 1
        ends = [0, *turns.tolist(), len(self.motion) - 1]
        ways = [slice(first, last + 1) for first, last in pairwise(ends)][::-1]
        strains = np.array([self._settled(ways, float(travel)) for travel in left])
        return replace(self, motion=np.append(self.motion, left), loops=np.vstack([self.loops, strains]))

    def _settled(self, ways: Sequence[slice], travel: float) -> Array:
        """Return the strains (L,) at a travel; the ways between turning points, the latest first."""
        found = []
        for down in (True, False):
            own = [way for way in ways if (self.motion[way][0] > self.motion[way][-1]) == down]
            if own:
                off = [max(self.motion[w].min() - travel, travel - self.motion[w].max(), 0.0) for w in own]
                found.append(self._along(own[int(np.argmin(off))], travel))
        return np.asarray(np.mean(found, axis=0))

    def _along(self, way: slice, travel: float) -> Array:
        """Return the strains (L,) at a travel on a way."""
        order = np.argsort(self.motion[way])
        motion, loops = self.motion[way][order], self.loops[way][order]
        return np.array([np.interp(travel, motion, loops[:, loop]) for loop in range(loops.shape[1])])

    @property
    def count(self) -> float:
        """How many cycles of the motion these are, those of at least half of the largest swing."""
        found = swings(self.motion)
        return float(found.counts[found.ranges >= CYCLE_FROM * found.largest[0]].sum())


def repeats(displacement_mm: Array) -> bool:
    """Tell whether a path goes back somewhere."""
    return bool((np.diff(displacement_mm) < 0.0).any())
