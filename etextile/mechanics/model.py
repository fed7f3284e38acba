"""The model: everything the solver needs, as plain data that an effect can copy with a change.

Unknowns are the positions of `points`. Further unknowns (wire slip, a machine spring) are extra points behind the
lattice nodes of which only some components are free, so one node-block pattern serves all.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from etextile.lattice.piece import Lattice
from etextile.mechanics.protocol import Contribution
from etextile.mechanics.truss import TrussBlock
from etextile.types import Array, BoolArray, IntArray


class Guide(Protocol):
    """Nodes that are held and led along a curve, such as a cuff that moves with a limb."""

    @property
    def nodes(self) -> IntArray:
        """Numbers (n,) of the nodes."""

    def positions(self, travel: float) -> Array:
        """Return the positions (n, 3) mm at `travel`."""

    def rate(self, travel: float, *, onward: bool = False) -> Array:
        """Return the derivative (n, 3) of the positions by the travel; `onward` where another motion begins."""


@dataclass(frozen=True)
class Followers:
    """Points that ride on nodes (wires in their cells): x_f = sum_a weights_fa x[nodes_fa], both (F, k).

    cells (K, 2): trusses between points as numbered in results (lattice nodes first, then followers), in the order of
    the truss blocks behind the lattice; wire (K,): number of the conductive wire.
    """

    nodes: IntArray
    weights: Array
    cells: IntArray
    wire: IntArray

    def positions(self, x: Array) -> Array:
        """Return the positions (F, 3) of the followers."""
        positions: Array = np.einsum("fk,fkc->fc", self.weights, x[self.nodes])
        return positions


@dataclass(frozen=True)
class Model:
    """Lattice, contributions, supports and motion.

    points (P, 3) mm: reference positions, lattice nodes first; fixed (P, 3): components that are prescribed;
    carried (P, 3): displacement of prescribed components per mm of travel; guide: nodes that are led along a curve
    instead; travel (S,): output points of the motion, mm (or what else the path parameter is), which begins at
    `begins`; unit: of the travel, as messages say it; direction (3,): of the travel, the sense in which its force
    counts; force_factor: force on the whole specimen over force on the modelled part.
    """

    lattice: Lattice
    points: Array
    fixed: BoolArray
    carried: Array
    contributions: tuple[Contribution, ...]
    travel: Array
    direction: Array
    speed: float = 1.0
    force_factor: float = 1.0
    followers: Followers | None = None
    guide: Guide | None = None
    begins: float = 0.0
    unit: str = "mm"
    notes: tuple[str, ...] = ()

    def with_contribution(self, contribution: Contribution) -> Model:
        """Return a copy with one more contribution."""
        return replace(self, contributions=(*self.contributions, contribution))

    @property
    def trusses(self) -> tuple[TrussBlock, ...]:
        """All truss blocks, those that result files leave out among them."""
        return tuple(part for part in self.contributions if isinstance(part, TrussBlock))

    @property
    def truss_blocks(self) -> tuple[TrussBlock, ...]:
        """The truss blocks in the order of the result file."""
        return tuple(block for block in self.trusses if block.in_results)

    @property
    def lattice_block(self) -> TrussBlock:
        """The trusses of the fabric."""
        return self.truss_blocks[0]

    @property
    def longest_step(self) -> float:
        """Largest travel (mm) of one increment that every part allows."""
        return min(part.longest_step for part in self.contributions)

    @property
    def truss_count(self) -> int:
        """Number of trusses of the lattice and the wires."""
        return sum(len(block.nodes) for block in self.truss_blocks)

    @cached_property
    def typical_stiffness(self) -> float:
        """Median elastic stiffness E A / l of the lattice trusses, N/mm: the scale of penalties and damping."""
        block = self.lattice_block
        modulus = np.array([law.E for law in block.laws])[block.law]
        return float(np.median(modulus * block.area / block.rest_length))

    @cached_property
    def diagonal(self) -> float:
        """Diagonal of the box around all points, mm."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0)))

    def prescribed(self, travel: float) -> Array:
        """Return positions (P, 3) whose fixed components are where the motion has carried them."""
        held = self.points + travel * self.carried
        if self.guide is not None:
            held[self.guide.nodes] = self.guide.positions(travel)
        return held

    def prescribed_rate(self, travel: float, *, onward: bool = False) -> Array:
        """Return the derivative (P, 3) of the prescribed positions by the travel; `onward` where another begins."""
        if self.guide is None:
            return self.carried
        rate = self.carried.copy()
        rate[self.guide.nodes] = self.guide.rate(travel, onward=onward)
        return rate

    def all_points(self, x: Array) -> Array:
        """Return positions of lattice nodes and followers, the points of the result file, from unknowns x (P, 3)."""
        nodes = x[: len(self.lattice.points)]
        return nodes if self.followers is None else np.concatenate([nodes, self.followers.positions(x)])

    def on_all_points(self, values: Array) -> Array:
        """Return nodal values (P, 3) on the points of the result file; followers get zero."""
        nodes = values[: len(self.lattice.points)]
        if self.followers is None:
            return nodes
        return np.concatenate([nodes, np.zeros((len(self.followers.nodes), 3))])
