"""Electrical resistance of wires over displacement, open circuits, and which nets are lost.

A wire stretched at constant volume has R/R0 = (1 + e)^2. Where k of its N filaments are broken the rest carries the
current: over a loop of length c in a wire of length L this adds (c / L) k / (N - k), and N of N interrupt it. k is the
whole number nearest to the expected one, which is the typical bundle, all of them in a loop that is called open. Damage
and plastic strain do not heal, so the greatest strain so far counts; elastic strain (0.1 %) is not told apart. Sliding
moves little wire, so lengths are those as mounted. Rigid components are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.results.wire_history import WireHistory
from etextile.types import Array, BoolArray, IntArray
from etextile.vocabulary import OPEN
from wires.damage import FailureResult
from wires.dependence import EventProbability
from wires.history import first_crossing, running_maximum
from wires.layout import WireLayout
from wires.woven import element_lengths


@dataclass(frozen=True)
class Net:
    """A connection along one wire, from the component in one loop to that in another; both loops belong to it."""

    name: str
    wire: int
    from_loop: int
    to_loop: int


@dataclass(frozen=True)
class NetResult:
    """What became of a net: displacement of its loss (None: kept), probability of a loss, R/R0 at the end."""

    net: Net
    lost_at_mm: float | None
    loss: EventProbability
    resistance_ratio: float


@dataclass(frozen=True)
class Conductors:
    """Lengths of wire as mounted, mm: woven-in elements (K,) with their crimp, loops (L,) with their slack."""

    element_mm: Array
    loop_mm: Array

    @classmethod
    def of(cls, history: WireHistory, *, crimp: float | Array) -> Conductors:
        """Return the lengths in the modelled part, crimp one for all or (W,); half of a loop that a plane halves."""
        layout = history.layout
        half = np.where(layout.loop_halved, 0.5, 1.0)
        taken_up = np.broadcast_to(np.asarray(crimp, dtype=float), (layout.n_wires,))[history.element_wire]
        woven = element_lengths(history) * (1.0 + taken_up)
        return cls(woven, half * (layout.loop_rest_mm - layout.loop_rigid_mm))


def typical_broken(damage: FailureResult) -> IntArray:
    """Return how many filaments (S, L) of the typical bundle are broken, all of them in an open one."""
    count = damage.loop_filaments
    broken = np.minimum(np.rint(damage.filaments_broken * count), count - 1)
    return np.where(damage.state == OPEN, count, broken).astype(np.int64)


def resistance_ratio(history: WireHistory, damage: FailureResult, conductors: Conductors) -> Array:
    """Return R/R0 (S, W) of every wire over the steps; infinite from the step on at which a loop is open."""
    return _ratio(history, damage, conductors, np.ones(history.layout.n_loops, dtype=bool), None)


def _ratio(
    history: WireHistory, damage: FailureResult, conductors: Conductors, loops: BoolArray, elements: BoolArray | None
) -> Array:
    """Return R/R0 (S, W) over the chosen loops (L,) and woven-in elements (K,), all of them for None."""
    layout = history.layout
    chosen = np.ones(len(history.element_wire), dtype=bool) if elements is None else elements
    loop_share, element_share = conductors.loop_mm * loops, conductors.element_mm * chosen
    count = damage.loop_filaments
    left = count - typical_broken(damage)
    thinner = np.where(left > 0, count / np.maximum(left, 1), np.inf)
    stretched = (1.0 + running_maximum(np.maximum(history.wire_strain, 0.0))) ** 2
    in_loops = np.where(loops, conductors.loop_mm * stretched * thinner, 0.0)
    in_weave = element_share * (1.0 + running_maximum(np.maximum(history.element_strain, 0.0))) ** 2
    now = _per_wire(in_loops, layout.loop_wire, layout) + _per_wire(in_weave, history.element_wire, layout)
    first = _per_wire(loop_share[None], layout.loop_wire, layout) + _per_wire(
        element_share[None], history.element_wire, layout
    )
    return np.where(first > 0.0, now / np.where(first > 0.0, first, 1.0), 1.0)


def _per_wire(values: Array, wire: IntArray, layout: WireLayout) -> Array:
    """Return the sums (S, W) of values (S, n) over the parts (n,) of each wire."""
    total = np.zeros((layout.n_wires, values.shape[0]))
    np.add.at(total, wire, values.T)
    return total.T


def net_results(
    history: WireHistory, damage: FailureResult, conductors: Conductors, nets: Sequence[Net]
) -> tuple[NetResult, ...]:
    """Return what became of each net; it is lost with the first of its loops that opens."""
    return tuple(_net_result(history, damage, conductors, net) for net in nets)


def _net_result(history: WireHistory, damage: FailureResult, conductors: Conductors, net: Net) -> NetResult:
    layout = history.layout
    low, high = sorted((net.from_loop, net.to_loop))
    own = (layout.loop_wire == net.wire) & (layout.loop_index >= low) & (layout.loop_index <= high)
    first, last = layout.loop_warp_mm[own].min(), layout.loop_warp_mm[own].max()
    between = (history.element_wire == net.wire) & (history.element_warp_mm > first) & (history.element_warp_mm < last)
    opened = opening_mm(damage)[own]
    lost = None if np.isnan(opened).all() else float(np.nanmin(opened))
    ratio = _ratio(history, damage, conductors, own, between)[-1, net.wire]
    return NetResult(net, lost, loss_of_net(damage, net), float(ratio))


def loss_of_net(damage: FailureResult, net: Net) -> EventProbability:
    """Return that something opens on a net, with the interval that the doubt about the calibration gives it."""
    if damage.reliability is not None:
        return damage.reliability.net(net.wire, net.from_loop, net.to_loop)
    layout, (low, high) = damage.layout, sorted((net.from_loop, net.to_loop))
    own = (layout.loop_wire == net.wire) & (layout.loop_index >= low) & (layout.loop_index <= high)
    alone = float(1.0 - np.prod(1.0 - damage.open_probability[own]))
    return EventProbability(alone, alone, alone)


def opening_mm(damage: FailureResult) -> Array:
    """Return the displacement (L,) at which the last filament of each loop breaks; NaN when it does not."""
    if damage.open_mm is not None:
        return damage.open_mm
    level = 1.0 - 0.5 / damage.loop_filaments
    return first_crossing(damage.displacement_mm, damage.filaments_broken, level)
