"""Observed states of wires (X-ray, continuity) against predicted ones: hits and misses place by place, Brier score.

A place is a hit when prediction and observation agree on whether a filament is broken there. The Brier score is the
mean of (p - o)^2 over the places, p the predicted probability and o = 1 where it happened (Brier, Mon. Weather Rev. 78
(1950) 1): 0 is perfect, and always giving the observed share q of broken places would score q (1 - q).

Wires are numbered as in the whole specimen, from -y; where symmetry planes cut the model, its mirror images answer.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from etextile.diagnose.data.measured import WireStates
from etextile.results.wire_history import WireHistory
from etextile.vocabulary import OPEN, PARTIAL, STATES
from wires.damage import FailureResult
from wires.judge import Judge
from wires.layout import WireLayout


HIT, FALSE_ALARM, MISSED = "hit", "false alarm", "missed break"


@dataclass(frozen=True)
class ObservedPlace:
    """One observation beside the prediction; `strain` is the criterion's measure, probabilities are those given it."""

    name: str
    observed: str
    predicted: str
    strain: float
    failure_probability: float
    open_probability: float

    @property
    def outcome(self) -> str:
        """`hit`, `false alarm` (predicted broken, seen whole) or `missed break`."""
        seen, said = (STATES.index(state) >= PARTIAL for state in (self.observed, self.predicted))
        return HIT if seen == said else FALSE_ALARM if said else MISSED


@dataclass(frozen=True)
class Score:
    """Brier score of an event over the places, and that of always giving the observed share."""

    brier: float
    base_rate: float


@dataclass(frozen=True)
class Comparison:
    """All places that could be compared, and sentences about those that could not."""

    places: tuple[ObservedPlace, ...]
    left_out: tuple[str, ...] = ()

    def count(self, outcome: str) -> int:
        """Return the number of places with an outcome."""
        return sum(place.outcome == outcome for place in self.places)

    @property
    def same_state(self) -> int:
        """Number of places where the very state was predicted."""
        return sum(place.observed == place.predicted for place in self.places)

    @property
    def broken(self) -> Score | None:
        """Score of `some filament is broken`; None without places."""
        return self._score([place.failure_probability for place in self.places], PARTIAL)

    @property
    def opened(self) -> Score | None:
        """Score of `the wire is interrupted`; None without places."""
        return self._score([place.open_probability for place in self.places], OPEN)

    def as_dict(self) -> dict[str, Any]:
        """Return the comparison as plain data."""
        return {
            "places": [{**asdict(place), "outcome": place.outcome} for place in self.places],
            "left_out": list(self.left_out),
            "hits": self.count(HIT),
            "false_alarms": self.count(FALSE_ALARM),
            "missed_breaks": self.count(MISSED),
            "same_state": self.same_state,
            "broken": None if self.broken is None else asdict(self.broken),
            "open": None if self.opened is None else asdict(self.opened),
        }

    def _score(self, probability: Iterable[float], least: int) -> Score | None:
        if not self.places:
            return None
        happened = np.array([STATES.index(place.observed) >= least for place in self.places], dtype=float)
        share = float(happened.mean())
        return Score(float(np.mean((np.array(list(probability)) - happened) ** 2)), share * (1.0 - share))


def compare_states(history: WireHistory, observed: WireStates, judge: Judge) -> Comparison:
    """Return what a judge predicts at the observed loops and displacements beside what was seen there.

    An observation belongs to the loop of its wire whose span it lies in, give or take half a span. Observations beyond
    the run or away from all loops are left out, with a sentence each.
    """
    end = float(history.displacement_mm.max(initial=0.0))
    damages: dict[float, FailureResult] = {}
    places: list[ObservedPlace] = []
    left_out: list[str] = []
    for displacement, wire, warp, state in zip(
        observed.displacement.tolist(),
        observed.wire.tolist(),
        observed.warp0.tolist(),
        observed.state.tolist(),
        strict=True,
    ):
        depth = f"{displacement:g} mm deep" if observed.unit == "mm" else f"at {displacement:g} {observed.unit}"
        name = f"wire {wire} at {warp:g} mm, {depth}"
        found = loop_at(history.layout, wire, warp)
        if isinstance(found, str) or displacement > end + 1e-9:
            reason = found if isinstance(found, str) else f"the run ends at {end:g} {observed.unit}"
            left_out.append(f"{name}: {reason}")
            continue
        if displacement not in damages:
            damages[displacement] = judge.judge(history.until(displacement))
        places.append(_place(name, STATES[state], damages[displacement], found))
    return Comparison(tuple(places), tuple(left_out))


def _place(name: str, observed: str, damage: FailureResult, loop: int) -> ObservedPlace:
    return ObservedPlace(
        name=name,
        observed=observed,
        predicted=STATES[damage.loop_state[loop]],
        strain=float(damage.max_strain[loop]),
        failure_probability=float(damage.failure_probability[loop]),
        open_probability=float(damage.open_probability[loop]),
    )


def loop_at(layout: WireLayout, wire: int, warp_mm: float) -> int | str:
    """Return the loop of the layout that stands for a place of the whole specimen, or why there is none."""
    twice = layout.wire_copies > 1
    mirrored = bool(twice.any())
    weft = np.unique(np.concatenate([layout.weft_mm, -layout.weft_mm[twice]])) if mirrored else layout.weft_mm
    if not 0 <= wire < len(weft):
        return f"the specimen has wires 0 to {len(weft) - 1}" if len(weft) else "the specimen has no wires"
    here = abs(warp_mm) if bool((layout.start_mm >= 0.0).all()) else warp_mm
    place = abs(weft[wire]) if mirrored else weft[wire]
    off = np.where(layout.loop_weft_mm == place, np.abs(layout.loop_warp_mm - here), np.inf)
    if not len(off) or off.min() > layout.loop_span_mm[off.argmin()]:
        return "no loop of the wire is there"
    return int(off.argmin())
