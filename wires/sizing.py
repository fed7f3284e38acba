"""How much slack loops need, and how much crimp the wire in the weave: the inverse of judging, from the fabric alone.

A loop straightens before its wire stretches, so with the greatest span strain e a slack s leaves (1 + e) / (1 + s) - 1
in the wire (with a rigid component of share c of the span (1 + e - c) / (1 + s - c) - 1); crimp does the same for the
wire in the weave. The wires hardly change the fabric's strain, so one simulation serves for every slack. The wire is
taken as perfectly bonded: where it slides, the weave beside a loop shares its slack, and the sizes found here are too
small (see `wires.slip`).

The target is a probability that a filament breaks, of a garment, of each net or of each loop and woven piece. It need
not fall with slack (more slack bends a wire more at its exits, `filament_bundle`), so slack is looked for on a grid
first: the least that meets the target.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from etextile.errors import BadInput
from etextile.results.wire_history import WireHistory
from etextile.types import Array
from wires.damage import FailureResult
from wires.dependence import EventProbability
from wires.judge import Judge
from wires.reliability import Reliability


Per = Literal["garment", "net", "loop"]

BISECTIONS = 30
LARGEST = 0.5
"""Slack beyond which no loop is made: half as long again as the fabric it spans."""
SCAN = 51
"""Slacks at which the probabilities are looked at before any is refined."""
WEAVE_SHARE = 0.5
"""Share of a garment's or a net's target that the weave may take."""


@dataclass(frozen=True)
class NetStretch:
    """A net to be sized: a wire between two of its loops, both with it, or the whole wire where it names none."""

    wire: int
    from_loop: int | None = None
    to_loop: int | None = None

    def broken(self, found: Reliability) -> EventProbability:
        """Return that a filament breaks on it."""
        if self.from_loop is None or self.to_loop is None:
            return found.wire(self.wire)
        return found.net(self.wire, self.from_loop, self.to_loop, what="broken")


@dataclass(frozen=True)
class LoopSizes:
    """Slack (L,) each loop needs, NaN where no slack up to the largest is enough, and one for all; crimp of the weave.

    `probability_now`, `probability` (L,): of each loop as it is and with its slack. `reached_now`, `reached`: the
    greatest probability of what the target is for, as it is and with one slack for all.
    """

    target: float
    per: Per
    slack: Array
    everywhere: float
    crimp: float
    probability_now: Array
    probability: Array
    reached_now: float
    reached: float


def with_slack(
    history: WireHistory, slack: Array | float, *, crimp: float | None = None, was: Array | float = 0.0
) -> WireHistory:
    """Return the history of loops with other slacks (L,), perfectly bonded, and of wires with at least a crimp.

    was: crimp of every wire (W,), or of all.
    """
    layout = history.layout.with_loop_slack(slack)
    rigid = layout.loop_rigid_mm / layout.loop_span_mm
    strain = (1.0 + history.span_strain - rigid) / (1.0 + layout.loop_slack - rigid) - 1.0
    woven = history.element_strain
    if crimp is not None:
        own = np.broadcast_to(np.asarray(was, dtype=float), (layout.n_wires,))[history.element_wire]
        more = np.maximum((1.0 + woven) * (1.0 + own) / (1.0 + crimp) - 1.0, 0.0)
        woven = np.where(crimp > own, more, woven)
    return replace(history, wire_strain=np.maximum(strain, 0.0), element_strain=woven, layout=layout)


def size_loops(
    history: WireHistory,
    target: float,
    *,
    judge: Judge,
    per: Per = "loop",
    nets: Sequence[NetStretch] = (),
    crimp: Array | float = 0.0,
    largest: float = LARGEST,
) -> LoopSizes:
    """Return the least slack, and crimp where the weave breaks too, with probabilities of at most `target`.

    `crimp` is that of the history, of every wire (W,) or of all; what is returned is the least that every wire needs,
    their smallest where none needs more. Raises BadInput for a criterion that does not credit a loop with its slack,
    and for nets that are to be sized where there are none.
    """
    if not 0.0 < target < 1.0:
        raise BadInput.of(f"must lie between 0 and 1 (got {target:g})", key="target")
    if per == "net" and not nets:
        raise BadInput.of("the case has no nets, give it wires.nets or size per garment or loop", key="wires.nets")
    asked = _Asked(_worst(history), judge, per, tuple(nets), crimp)
    grid = np.linspace(0.0, largest, SCAN)
    most = asked.crimp_for(target, largest)
    scanned = np.stack([asked.judged(np.full(history.layout.n_loops, s), most).failure_probability for s in grid])
    if (scanned[0] > target).any() and np.array_equal(scanned[0], scanned[-1]):
        raise BadInput.of(
            f"the criterion {judge.criterion.name!r} does not ask for the slack of loops, take calibrated",
            key="failure.criterion",
        )
    everywhere = _least(lambda s: asked.probability(s, most), grid, target)
    slack = asked.own_slack(grid, scanned, target, most)
    now = asked.judged(history.layout.loop_slack, float(np.min(crimp)))
    then = asked.judged(np.nan_to_num(slack, nan=largest), most)
    return LoopSizes(
        target=target,
        per=per,
        slack=slack,
        everywhere=everywhere,
        crimp=most,
        probability_now=now.failure_probability,
        probability=then.failure_probability,
        reached_now=reached(now, per, nets).value,
        reached=asked.probability(everywhere if np.isfinite(everywhere) else largest, most),
    )


def surely(
    history: WireHistory,
    target: float,
    *,
    judge: Judge,
    per: Per = "loop",
    nets: Sequence[NetStretch] = (),
    crimp: Array | float = 0.0,
    largest: float = LARGEST,
) -> tuple[float, float]:
    """Return the least slack for all loops, and the crimp, with which all of the interval of the probability fits.

    The interval is that of what is not known of the coupons. Arguments as in `size_loops`; the slack is NaN where none
    up to `largest` is enough.
    """
    asked = _Asked(_worst(history), judge, per, tuple(nets), crimp, at="high")
    most = asked.crimp_for(target, largest)
    return _least(lambda s: asked.probability(s, most), np.linspace(0.0, largest, SCAN), target), most


def reached(found: FailureResult, per: Per, nets: Sequence[NetStretch] = ()) -> EventProbability:
    """Return the greatest probability of a broken filament on what the target is for, with its interval."""
    if per != "loop":
        return _together(found.reliability, per, nets)
    loops = found.failure_probability
    woven = np.zeros(0) if found.woven is None else found.woven.failure_probability
    value = float(max(loops.max(initial=0.0), woven.max(initial=0.0)))
    if found.reliability is None or value == 0.0:
        return EventProbability(value, value, value)
    parts = [found.reliability.loop(int(loops.argmax()))] if len(loops) else []
    parts += [found.reliability.piece(int(woven.argmax()))] if len(woven) else []
    return EventProbability(value, min(value, *(e.low for e in parts), 1.0), max(value, *(e.high for e in parts), 0.0))


@dataclass(frozen=True)
class _Asked:
    """What is sized, by whom, and how large its probability is with some slack and crimp."""

    history: WireHistory
    judge: Judge
    per: Per
    nets: tuple[NetStretch, ...]
    crimp: Array | float
    at: Literal["value", "high"] = "value"
    """What of the probability counts: its value or the upper end of its interval."""

    def judged(self, slack: Array, crimp: float) -> FailureResult:
        changed = with_slack(self.history, slack, crimp=crimp, was=self.crimp)
        return self.judge.judge(changed)

    def probability(self, slack: float | Array, crimp: float) -> float:
        """Return the greatest probability with one slack for all loops (or one each)."""
        loops = np.broadcast_to(np.asarray(slack, dtype=float), (self.history.layout.n_loops,))
        return float(getattr(reached(self.judged(loops, crimp), self.per, self.nets), self.at))

    def crimp_for(self, target: float, largest: float) -> float:
        """Return the least crimp with which the weave alone keeps its share of the target."""
        allowed = target if self.per == "loop" else WEAVE_SHARE * target
        least = float(np.min(self.crimp))
        slackened = replace(
            self.history,
            span_strain=np.zeros_like(self.history.span_strain),
        )
        weave = replace(self, history=slackened)
        found = _least(lambda k: weave.probability(0.0, k), np.linspace(least, least + largest, SCAN), allowed)
        return found if np.isfinite(found) else least

    def own_slack(self, grid: Array, scanned: Array, target: float, crimp: float) -> Array:
        """Return the slack (L,) of each loop: at the target itself, or all at one level that meets the joint target."""
        if self.per == "loop":
            return self._refined(grid, scanned, target, crimp)
        if self.probability(_at_level(grid, scanned, 0.0), crimp) > target:
            return np.full(scanned.shape[1], np.nan)
        low, high = -30.0, 0.0
        for _ in range(BISECTIONS // 2):
            middle = 0.5 * (low + high)
            enough = self.probability(_at_level(grid, scanned, float(np.exp(middle))), crimp) <= target
            low, high = (middle, high) if enough else (low, middle)
        return _at_level(grid, scanned, float(np.exp(low)))

    def _refined(self, grid: Array, scanned: Array, target: float, crimp: float) -> Array:
        """Return the least slack (L,) of each loop by bisection between the first slack that is enough and the last
        before it that is not.
        """
        enough = scanned <= target
        first = np.argmax(enough, axis=0)
        low, high = grid[np.maximum(first - 1, 0)], grid[first]
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            kept = self.judged(middle, crimp).failure_probability <= target
            low, high = np.where(kept, low, middle), np.where(kept, middle, high)
        return np.where(enough[0], 0.0, np.where(enough.any(axis=0), high, np.nan))


def _worst(history: WireHistory) -> WireHistory:
    """Return the flat fabric and the greatest strains so far: nothing heals."""
    parts: dict[str, Any] = {
        name: np.stack([np.zeros_like(values[0]), values.max(axis=0)])
        for name in ("span_strain", "wire_strain", "element_strain")
        for values in (getattr(history, name),)
    }
    return replace(history, displacement_mm=np.array([0.0, 1.0]), **parts)


def _together(found: Reliability | None, per: Per, nets: Sequence[NetStretch]) -> EventProbability:
    if found is None:
        raise ValueError("a judgement is needed")
    if per == "garment":
        return found.garment("broken").anything
    events = [net.broken(found) for net in nets]
    return EventProbability(max(e.value for e in events), max(e.low for e in events), max(e.high for e in events))


def _least(probability: Callable[[float], float], grid: Array, target: float) -> float:
    """Return the least value whose probability keeps the target, the first on the grid refined; NaN without one."""
    before = grid[0]
    for value in grid:
        if probability(float(value)) <= target:
            break
        before = value
    else:
        return float("nan")
    low, high = float(before), float(value)
    for _ in range(BISECTIONS if high > low else 0):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if probability(middle) <= target else (middle, high)
    return high


def _at_level(grid: Array, scanned: Array, level: float) -> Array:
    """Return the first slack (L,) at which each loop's probability (n, L) keeps a level, on the grid where never."""
    enough = scanned <= level
    first = np.where(enough.any(axis=0), np.argmax(enough, axis=0), np.argmin(scanned, axis=0))
    columns = np.arange(scanned.shape[1])
    before = np.maximum(first - 1, 0)
    above, below = scanned[before, columns], scanned[first, columns]
    gap = np.where(above > below, np.log(np.maximum(above, 1e-300)) - np.log(np.maximum(below, 1e-300)), 1.0)
    past = np.log(np.maximum(above, 1e-300)) - np.log(max(level, 1e-300))
    part = np.where((first > 0) & enough.any(axis=0), np.clip(past / gap, 0.0, 1.0), 1.0)
    return np.asarray(grid[before] + part * (grid[first] - grid[before]))
