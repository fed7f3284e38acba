"""What loops and wires of one garment have in common, integrated exactly: scatter in three parts, and the calibration.

The strain that a part of a wire stands is its own scatter (`wires.weakest_link`, between loops) times a factor

    f = exp(g + w + c),

g between garments (spool, batch), w between the wires of a garment, both normal with mean 0, and c the doubt about the
calibration, one for loops and one for the weave. Given g, w and c all parts are independent, so

    P(wire whole | g, c) = E_w[ prod over its parts (1 - p(f)) ],    P(no wire lost | c) = E_g[ prod over wires ].

All expectations are sums over one grid of ln f of width h: for the normal density the trapezoid rule is exact to
exp(-2 pi^2 s^2 / h^2), so there is no noise of sampling. c is doubt and no scatter: it widens the interval of a
probability, whose value is the mean over it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from etextile.types import Array, IntArray


FINEST, COARSEST = 0.002, 0.02
REACH = 5.0
"""Standard deviations that are integrated over."""
SPREAD_STEPS = 160
"""Grid points at most from the middle to an end."""
INTERVAL = (0.025, 0.975)


@dataclass(frozen=True)
class Spread:
    """Standard deviations of ln f: between garments, between wires, of the calibration of loops and of the weave."""

    garment: float = 0.0
    wire: float = 0.0
    loops: float = 0.0
    woven: float = 0.0

    @property
    def grid(self) -> LogGrid:
        """The grid of ln f that serves all four."""
        parts = [part for part in (self.garment, self.wire, self.loops, self.woven) if part > 0.0]
        if not parts:
            return LogGrid(0, COARSEST)
        reach = REACH * (self.garment + self.wire + max(self.loops, self.woven))
        step = min(COARSEST, max(FINEST, min(parts), reach / SPREAD_STEPS))
        return LogGrid(int(np.ceil(reach / step)), step)

    def within(self) -> Spread:
        """Return the spread within one garment."""
        return replace(self, garment=0.0)


@dataclass(frozen=True)
class LogGrid:
    """Values k step of ln f for k = -half ... half."""

    half: int
    step: float

    @property
    def factors(self) -> Array:
        """(G,) factors f on the strain that is stood."""
        return np.asarray(np.exp(self.step * np.arange(-self.half, self.half + 1)))

    def weights(self, std: float) -> Array:
        """Return the probabilities (2 n + 1,) of the middle 2 n + 1 points for a normal ln f."""
        count = min(self.half, int(np.ceil(REACH * std / self.step)))
        if count == 0 or std == 0.0:
            return np.ones(1)
        density = np.exp(-0.5 * (self.step * np.arange(-count, count + 1) / std) ** 2)
        return np.asarray(density / density.sum())

    def full(self, std: float) -> Array:
        """Return those probabilities (G,) on the whole grid."""
        return _padded(self.weights(std), 2 * self.half + 1)


@dataclass(frozen=True)
class EventProbability:
    """Probability of an event with the 2.5 and 97.5 % points of what the doubt about the calibration makes of it."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Survival:
    """Probabilities (G, W) that nothing happens to the loops and to the woven part of each of W wires, given ln f."""

    loops: Array
    woven: Array
    grid: LogGrid
    spread: Spread

    def of_wires(self) -> Array:
        """Return the probability (W,) of an event on each wire."""
        both = float(np.hypot(self.spread.garment, self.spread.wire))
        return np.asarray(1.0 - (self.loops * (self._joint(both) @ self.woven)).sum(axis=0))

    def on_wire(self, wire: int) -> EventProbability:
        """Return the event on one wire, with its interval."""
        return self.given(1.0 - self.loops[:, None, wire] * self.woven[None, :, wire])

    def given(self, lost: Array) -> EventProbability:
        """Return an event of one wire from its probabilities (G, G), given the factors of loops and weave."""
        return self._event(lost, float(np.hypot(self.spread.garment, self.spread.wire)))

    def garment(self, copies: IntArray) -> Garment:
        """Return what happens to a garment of wires, each there `copies` (W,) times."""
        lost = 1.0 - self._given_garment()
        with np.errstate(divide="ignore"):
            none = np.exp(np.log1p(-np.minimum(lost, 1.0 - 1e-16)) @ copies)
        anything = self._event(1.0 - none, self.spread.garment)
        expected = self._event(lost @ copies, self.spread.garment)
        counts = self._counts(lost, copies)
        cumulative = np.cumsum(counts)
        low, high = (int(np.searchsorted(cumulative, level - 1e-12)) for level in INTERVAL)
        return Garment(expected, anything, (low, min(high, len(counts) - 1)), counts)

    def any_wire(self, copies: IntArray) -> float:
        """Return the probability that something happens to a wire of the garment."""
        lost = 1.0 - self._given_garment()
        none = np.exp(np.log1p(-np.minimum(lost, 1.0 - 1e-16)) @ copies)
        return float(np.clip((self._joint(self.spread.garment) * (1.0 - none)).sum(), 0.0, 1.0))

    def _given_garment(self) -> Array:
        """Return the survival (G, G, W) of wires over the factors of loops and of the weave, w integrated."""
        weights = self.grid.weights(self.spread.wire)
        half = len(weights) // 2
        loops, woven = (np.pad(part, ((half, half), (0, 0)), mode="edge") for part in (self.loops, self.woven))
        size = len(self.loops)
        total = np.zeros((size, size, self.loops.shape[1]))
        for shift, weight in enumerate(weights):
            total += weight * loops[shift : shift + size, None] * woven[None, shift : shift + size]
        return total

    def _joint(self, common: float) -> Array:
        """Return the probabilities (G, G) of the factors of loops and weave that share a part of that deviation."""
        return _joint_weights(self.grid, self.spread.loops, self.spread.woven, common)

    def _event(self, given: Array, common: float) -> EventProbability:
        """Return the mean of values (G, G) and what the doubt about the calibration makes of it."""
        value = float((self._joint(common) * given).sum())
        shared = self.grid.weights(common)
        half = len(shared) // 2
        loops, woven = (self.grid.weights(std) for std in (self.spread.loops, self.spread.woven))
        a, b = (self.grid.half - len(part) // 2 for part in (loops, woven))
        padded = np.pad(given, half, mode="edge")
        mean = np.zeros((len(loops), len(woven)))
        for shift, weight in enumerate(shared):
            mean += weight * padded[a + shift : a + shift + len(loops), b + shift : b + shift + len(woven)]
        low, high = _quantiles(mean, np.outer(loops, woven))
        return EventProbability(value, min(low, value), max(high, value))

    def _counts(self, lost: Array, copies: IntArray) -> Array:
        """Return the probabilities (N + 1,) that 0 ... N wires of the garment are lost."""
        weight = self._joint(self.spread.garment).ravel()
        each = np.repeat(lost.reshape(len(weight), -1), copies, axis=1)[weight > 1e-9]
        weight = weight[weight > 1e-9]
        counts = np.zeros((len(weight), each.shape[1] + 1))
        counts[:, 0] = 1.0
        for wire in range(each.shape[1]):
            share = each[:, wire : wire + 1]
            counts[:, 1:] = counts[:, 1:] * (1.0 - share) + counts[:, :-1] * share
            counts[:, 0] *= 1.0 - share[:, 0]
        return np.asarray(weight @ counts / weight.sum())


@dataclass(frozen=True)
class Garment:
    """What happens to the wires of a garment: number expected, chance of any, 95 % range of the number, its chances."""

    expected: EventProbability
    anything: EventProbability
    range: tuple[int, int]
    counts: Array


@lru_cache(maxsize=64)
def _joint_weights(grid: LogGrid, loops: float, woven: float, common: float) -> Array:
    """Return the probabilities (G, G) of ln f of loops and of the weave: a common part, and one of each one's own.

    They are asked for after every step of every sample and always the same.
    """
    size = 2 * grid.half + 1
    shared = grid.weights(common)
    half = len(shared) // 2
    padded = [np.pad(grid.full(std), half) for std in (loops, woven)]
    total = np.zeros((size, size))
    for shift, weight in enumerate(shared):
        total += weight * np.outer(*(part[2 * half - shift : 2 * half - shift + size] for part in padded))
    total /= total.sum()
    total.setflags(write=False)
    return total


def _padded(weights: Array, size: int) -> Array:
    missing = (size - len(weights)) // 2
    return np.pad(weights, missing)


def _quantiles(values: Array, weights: Array) -> tuple[float, float]:
    """Return the 2.5 and 97.5 % points of chances (n, m) on a grid with weights (n, m).

    A chance may double from one point to the next, and whole rows are alike where one of the doubts hardly counts. So
    each point stands for its cell, over which the logarithm is taken to be spread evenly between its ends.
    """
    logs = np.log(np.maximum(values, 1e-300))
    half = np.full(logs.shape, 1e-6)
    for axis in (0, 1):
        if logs.shape[axis] > 1:
            half += 0.5 * np.abs(np.gradient(logs, axis=axis))
    ends = np.concatenate([(logs - half).ravel(), (logs + half).ravel()])
    order = np.argsort(ends)
    rise = (weights / (2.0 * half)).ravel()
    slope = np.cumsum(np.concatenate([rise, -rise])[order])
    total = np.concatenate([[0.0], np.cumsum(slope[:-1] * np.diff(ends[order]))])
    low, high = np.clip(np.exp(np.interp(INTERVAL, total, ends[order])), values.min(), values.max())
    return float(low), float(high)
