"""Sliding wires as the interior-point solver sees them: slackness and friction lifted to pairs.

Elements pair stretch and slack as trusses do (`etextile.solve.barrier`), the stretch counted from the stress-free
length that the element holds at the trial. A slip point carries its traction t and the slips f, b >= 0 there and back,

    d = t / k + f - b,      (q - t) f = mu,      (q + t) b = mu,

d the slip from the anchor, k the stick stiffness, q the friction limit; mu = 0 is the law of `channel_friction`. Seen
from d a point bears t + off / c with the stiffness 1 / c, c = 1 / k + f / (q - t) + b / (q + t): between none and k.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from etextile.mechanics.kernels import add_truss_gradient, add_truss_tangent
from etextile.mechanics.onesided import OneSided
from etextile.types import Array, IntArray
from wires import slip_kernels as kernels
from wires.slip_trial import SlidingResponse


KEEP = 0.02
"""Share of what is left to a limit, and of a slip, that a step leaves at least."""
CENTRING = 0.3
"""Factor by which a step means to bring down the mean of (q - t) f and (q + t) b: between 0.02 and 0.3 all do on the
punch test at 0.01 to 1 N/mm, at 0.001 N/mm smaller ones cost cut-backs."""
FIRST_SLIP = 1e-2
"""Slip of a barely sticking point when a solve begins, mm."""
LEAST_PRODUCT = 1e-16
"""mu never aims below this, N mm."""


@dataclass(frozen=True)
class Rub:
    """Friction of the slip points: limit q, stick stiffness k, traction t, slips f and b; each (n,), q positive."""

    limit: Array
    stick: Array
    traction: Array
    forward: Array
    backward: Array

    @classmethod
    def start(cls, slip: Array, limit: Array, stick: Array) -> Rub:
        """Return about the law at slips (n,) mm, everything centred."""
        traction = limit * slip / np.hypot(slip, FIRST_SLIP + limit / stick)
        mu = FIRST_SLIP * limit
        return cls(limit, stick, traction, mu / (limit - traction), mu / (limit + traction))

    def linearised(self, slip: Array) -> Rubbing:
        """Return the linear equations about this state at slips (n,)."""
        up, down = self.limit - self.traction, self.limit + self.traction
        mu = max(CENTRING * 0.5 * float(np.mean(up * self.forward + down * self.backward)), LEAST_PRODUCT)
        give = 1.0 / self.stick + self.forward / up + self.backward / down
        off = slip - self.traction / self.stick - mu / up + mu / down
        return Rubbing(self, mu, give, off)


@dataclass(frozen=True)
class Rubbing:
    """Friction linearised: the product aimed at, c (n,) mm/N, and how far off the slip is (n,) mm."""

    now: Rub
    mu: float
    give: Array
    off: Array

    @property
    def borne(self) -> Array:
        """Traction (n,) on the right-hand side, N."""
        return self.now.traction + self.off / self.give

    def moved(self, step: Array) -> Rub:
        """Return the state after slips changed by `step` (n,), every limit kept."""
        now = self.now
        up, down = now.limit - now.traction, now.limit + now.traction
        rise = (step + self.off) / self.give
        forward = (self.mu + now.forward * rise) / up
        backward = (self.mu - now.backward * rise) / down
        traction = np.clip(now.traction + rise, KEEP * down - now.limit, now.limit - KEEP * up)
        return Rub(
            now.limit,
            now.stick,
            traction,
            np.maximum(forward, KEEP * now.forward),
            np.maximum(backward, KEEP * now.backward),
        )


class SlidingPairs(OneSided):
    """Sliding wires at a trial, with what their law gave for the stretches asked last."""

    def __init__(self, response: SlidingResponse) -> None:
        """Take the trial."""
        block, before = response.block, response.before
        self.response = response
        self.stretch = response.taut - response.free
        self.section = block.area * before.virgin / before.free
        self.plastic = np.log(before.free / before.virgin)
        pulls = self.stretch > 1e-13 * response.free
        elastic = block.row[0] * self.section / response.free
        secant = response.force / np.where(pulls, self.stretch, 1.0)
        self.stiffness = np.maximum(np.where(pulls & (secant > 1e-6 * elastic), secant, elastic), 1e-12)
        self.rubs = np.flatnonzero((before.limit > 0.0) & ~block.anchored)
        self.rub = self._first_rub()
        self._rubbing: Rubbing | None = None
        self._force = self._pull = np.zeros(0)
        self._ratio = np.ones(len(self.stretch))

    def _first_rub(self) -> Rub | None:
        """Return friction as it stands at the trial; None without any."""
        if not len(self.rubs):
            return None
        limit = self.response.before.limit[self.rubs]
        return Rub.start(self._slip(), limit, self.response.block.stick(self.response.before.limit)[self.rubs])

    def _slip(self) -> Array:
        """Return the slips from the anchors (n,), mm."""
        response = self.response
        return np.asarray(response.x[response.block.points[self.rubs], 0] - response.before.anchor[self.rubs])

    def bear(self, stretch: Array) -> tuple[Array, Array]:
        """Return force and dF/dl at the stress-free length plus `stretch` (M,)."""
        count = len(stretch)
        force, along, pull = np.empty(count), np.empty(count), np.empty(count)
        rest = self.response.free
        kernels.wire_forces(rest, stretch, self.section, self.plastic, self.response.block.row, force, along, pull)
        self._force, self._pull = force, pull
        self._ratio = (1.0 + stretch / rest) * self.response.chain
        return force, along

    def add_gradient(self, force: Array, gradient: Array) -> None:
        """Add the gradient of wires under `force` (M,): dG = l / R dF, and friction."""
        response, block = self.response, self.response.block
        pull = self._pull + self._ratio / response.chain * (force - self._force)
        add_truss_gradient(block.nodes, block.weights, response.unit, force, gradient)
        kernels.add_feed_gradient(block.nodes, pull, response.chain, block.anchored[block.ends], gradient)
        if self.rub is not None:
            borne = response.traction[self.rubs] if self._rubbing is None else self._rubbing.borne
            gradient[block.points[self.rubs], 0] += borne

    def add_tangent(
        self, force: Array, along: Array, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float
    ) -> None:
        """Add the tangent of wires under `force` (M,) that grows by `along` (M,), and of friction."""
        response, block = self.response, self.response.block
        across, bend = force / response.distance, response.bend
        if not exact:
            bend = np.maximum(bend, 0.0)
        add_truss_tangent(block.nodes, block.weights, response.unit, along, across, damping, rows, pairs, values)
        kernels.add_feed_tangent(
            block.nodes, block.weights, response.unit, along, self._ratio, bend, damping, rows, pairs, values
        )
        if self.rub is not None:
            self._rubbing = self.rub.linearised(self._slip())
            kernels.add_friction_tangent(block.points[self.rubs], 1.0 / self._rubbing.give, rows, values)

    def rate(self, step: Array) -> Array:
        """Return how the elements outgrow what they hold along `step` (P, 3), mm: dl - (l / R) dR."""
        block = self.response.block
        fed = step[block.points, 0][block.ends]
        grown = np.einsum("ec,ec->e", self._vectors(step), self.response.unit)
        return np.asarray(grown - self._ratio * (fed[:, 1] - fed[:, 0]))

    def bulge(self, step: Array, rate: Array) -> Array:
        """Return the length gained by turning along `step`."""
        vectors = self._vectors(step)
        along = np.einsum("ec,ec->e", vectors, self.response.unit)
        across = np.einsum("ec,ec->e", vectors, vectors) - along * along
        return np.asarray(0.5 * np.maximum(across, 0.0) / self.response.distance)

    def _vectors(self, step: Array) -> Array:
        """Return the change (M, 3) of the vectors along the elements."""
        block = self.response.block
        return np.asarray(np.einsum("ek,ekc->ec", block.weights[:, :-2], step[block.nodes[:, :-2]]))

    def follow(self, before: Any, step: Array) -> None:
        """Move friction along."""
        if before._rubbing is not None:
            self.rub = before._rubbing.moved(step[self.response.block.points[self.rubs], 0])
