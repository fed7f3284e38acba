"""Sliding wires at a trial: what the elements are, what each holds and rubs, and the history that a trial leaves."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from etextile.mechanics.kernels import add_truss_tangent
from etextile.mechanics.protocol import Energy
from etextile.mechanics.truss import TrussBlock, TrussResponse
from etextile.types import Array, BoolArray, IntArray
from wires import slip_kernels as kernels
from wires.wire_law import law_row


STICK_MM = 1e-4
"""Elastic slip before a point slides. It rounds the end of a slip zone over sqrt(2 E A STICK_MM / q), about 1 mm."""
STIFFEST = 1e4
"""Stick stiffness at most, over E A / h of the wire between two slip points."""
LEAST_SHARE = 0.02
"""Share of its first stress-free length below which an element empties only exponentially."""


@dataclass(frozen=True)
class WeftPressure:
    """Weft tension that grips the wire: N(strain) in N/mm from the weft's loading curve, times `factor`.

    nodes (n, 4), share (n, 2): the two weft segments beside each slip point and their weights; rest (n,): their length.
    """

    factor: float
    nodes: IntArray
    share: Array
    rest: Array
    strain: Array
    tension: Array

    def line_friction(self, x: Array) -> Array:
        """Return the friction (n,) in N/mm that the weft's tension adds at positions x (P, 3)."""
        corners = x[self.nodes]
        first = np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)
        second = np.linalg.norm(corners[:, 3] - corners[:, 2], axis=1)
        strain = (self.share[:, 0] * first + self.share[:, 1] * second) / self.rest - 1.0
        return np.asarray(self.factor * np.interp(strain, self.strain, self.tension))


@dataclass(frozen=True)
class SlipState:
    """History: fed length s and stick anchor (n,) mm, friction limit (n,) N, stress-free and virgin length (M,) mm, and
    the work done so far by plastic flow and friction, N mm.
    """

    fed: Array
    anchor: Array
    limit: Array
    free: Array
    virgin: Array
    plastic_work: float = 0.0
    friction_work: float = 0.0


@dataclass(frozen=True)
class SlidingElements(TrussBlock):
    """Wire elements, woven-in ones first, then loops; nodes (M, k + 2) end with the slip points of both ends.

    rigid (M,): length of a component in the element that does not stretch; points (n,): node numbers of the slip
    points; anchored (n,): points at which the wire is held; channel (n,): length of channel each stands for, mm, times
    the wire's share; line_friction N/mm.
    """

    rigid: Array
    points: IntArray
    anchored: BoolArray
    channel: Array
    line_friction: float
    pressure: WeftPressure | None = None

    @property
    def ends(self) -> IntArray:
        """Slip points (M, 2) of each element, counted from 0."""
        return np.asarray(self.nodes[:, -2:] - self.points[0])

    @cached_property
    def row(self) -> Array:
        """The wire's law for the kernels."""
        return law_row(self.laws[0])

    @property
    def stiffest(self) -> Array:
        """Largest stick stiffness (n,), N/mm."""
        modulus = self.laws[0].E * float(self.area.max())
        return STIFFEST * modulus / np.maximum(self.channel, 1e-6)

    def stick(self, limit: Array) -> Array:
        """Return the stick stiffness (n,) N/mm for friction limits (n,) N."""
        return np.minimum(np.maximum(limit, 1e-300) / STICK_MM, self.stiffest)

    def limit_at(self, x: Array) -> Array:
        """Return the friction limits (n,) N at positions x (P, 3)."""
        more = 0.0 if self.pressure is None else self.pressure.line_friction(x)
        return self.channel * (self.line_friction + more)


@dataclass(frozen=True)
class SlidingResponse(TrussResponse):
    """Sliding wires at a trial; `length` is the chord along the fabric, `taut` that without the wire's rigid part."""

    block: SlidingElements
    before: SlipState
    x: Array
    taut: Array
    free: Array
    chain: Array
    pull: Array
    traction: Array
    grip: Array
    found: Energy

    @property
    def state(self) -> SlipState:  # type: ignore[override]
        """History at the end of the increment: what each element now holds, anchors where the wire slid moved along."""
        block, before = self.block, self.before
        fed = self.x[block.points, 0].copy()
        virgin = np.clip(before.virgin + self._virgin_gain(fed - before.fed), 1e-6 * self.free, None)
        free = self.free * np.exp(self.plastic) * before.virgin / before.free
        limit = block.limit_at(self.x)
        return replace(
            before,
            fed=fed,
            anchor=fed - np.clip(self.traction, -limit, limit) / block.stick(limit),
            limit=limit,
            free=free,
            virgin=np.minimum(virgin, free),
            plastic_work=self.found.plastic,
            friction_work=self.found.friction,
        )

    def _virgin_gain(self, step: Array) -> Array:
        """Return the virgin length (M,) each element gains when stress-free lengths step (n,) pass the slip points."""
        block, before = self.block, self.before
        left, right = block.ends.T
        dense = before.virgin / before.free
        from_right, from_left = np.ones(len(step)), np.ones(len(step))
        from_right[left], from_left[right] = dense, dense
        moved = step * np.where(step > 0.0, from_right, from_left)
        return np.asarray(moved[right] - moved[left])

    @property
    def bend(self) -> Array:
        """Curvature (M,) of the energy over the fed length where elements are nearly empty, N/mm."""
        return np.where(self.chain < 1.0, -self.pull * self.chain / (LEAST_SHARE * self.block.rest_length), 0.0)

    def energy(self) -> Energy:
        """Return stored energy (with the elastic part of stick), plastic and friction work so far, N mm."""
        return self.found

    def add_gradient(self, gradient: Array) -> None:
        """Add forces on nodes and slip points; held slip points get none, so that they do not count as reactions."""
        block = self.block
        super().add_gradient(gradient)
        kernels.add_feed_gradient(block.nodes, self.pull, self.chain, block.anchored[block.ends], gradient)
        kernels.add_friction(block.points, self.traction, block.anchored, gradient)

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add the tangent; what softening and emptying elements make negative is left out unless `exact`."""
        block = self.block
        along, across, bend = self.along, self.force / self.distance, self.bend
        if not exact:
            along, bend = np.maximum(along, 0.0), np.maximum(bend, 0.0)
        add_truss_tangent(block.nodes, block.weights, self.unit, along, across, damping, rows, pairs, values)
        kernels.add_feed_tangent(
            block.nodes, block.weights, self.unit, along, self.taut / self.free * self.chain, bend, damping,
            rows, pairs, values,
        )  # fmt: skip
        kernels.add_friction_tangent(block.points, self.grip, rows, values)
