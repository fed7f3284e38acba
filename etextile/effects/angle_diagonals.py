r"""Diagonals that follow the angle of the yarns: the contribution behind `rotational_shear`.

In a cell with current warp and weft sides a, b and diagonals d the Hencky strain of a diagonal counts from the length
it would have if the yarns stood at their first angle,

    e = ln(d / d0) - h,    h = ln(alpha exp(2 r_a) + (1 - alpha) exp(2 r_b)) / 2,    alpha = a0^2 / (a0^2 + b0^2)

where r is the mean Hencky strain of both sides. The cosine law makes that
e = ln(1 + 2 a b sin(gamma) / (a^2 + b^2)) / 2, a function of the shear angle alone, also where the yarns are slack:
a fold of the fabric costs nothing as long as warp and weft stay at right angles, so that slack parts have many
equilibria. The energy V W(e) has the law, volume and history of the diagonals and, in all six distances between the
four nodes, closed derivatives.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from etextile.effects import cell_kernels as cells
from etextile.effects import kernels
from etextile.laws.powerlaw import E
from etextile.mechanics.onesided import OneSided
from etextile.mechanics.protocol import Contribution, Energy, Response
from etextile.types import Array, IntArray


BONDS = np.array([[0, 1], [3, 2], [0, 3], [1, 2], [0, 2], [1, 3]])
"""Ends of the six distances of a cell (origin, warp end, far corner, weft end): warp, warp, weft, weft, diagonals."""
INCIDENCE = np.zeros((6, 4))
INCIDENCE[range(6), BONDS[:, 0]] = -1.0
INCIDENCE[range(6), BONDS[:, 1]] = 1.0


@dataclass(frozen=True)
class AngleDiagonals(Contribution):
    """Two diagonals per cell: nodes (Q, 4), first distances (Q, 6) mm, volume (Q, 2) mm3, row of the law."""

    nodes: IntArray
    first: Array
    volume: Array
    table: Array
    name: str = "rotational shear"

    def initial_state(self) -> Array:
        """Return zero plastic strains (Q, 2)."""
        return np.zeros_like(self.volume)

    @cached_property
    def alpha(self) -> Array:
        """Share of the warp side in the first diagonal squared, (Q,)."""
        warp, weft = (self.first[:, k : k + 2].mean(axis=1) ** 2 for k in (0, 2))
        return np.asarray(warp / (warp + weft))

    def respond(self, x: Array, travel: float, state: Array) -> AngleDiagonalsResponse:
        """Evaluate all cells at positions x (P, 3) from plastic strains `state` (Q, 2)."""
        shape = self.shape_of(self.between_nodes(x))
        law = np.zeros(state.size, dtype=np.int64)
        tau, rise, plastic = (np.empty(state.size) for _ in range(3))
        kernels.law_response(self.table, law, shape.strain.ravel(), state.ravel(), tau, rise, plastic)
        pull, stiff = (self.volume * values.reshape(state.shape) for values in (tau, rise))
        return AngleDiagonalsResponse(self, shape, pull, stiff, plastic.reshape(state.shape))

    def shape_of(self, bonds: Array) -> CellShapes:
        """Return the strains of the diagonals for bond vectors (Q, 6, 3)."""
        length, share, strain = (np.empty(size) for size in ((len(bonds), 6), len(bonds), (len(bonds), 2)))
        cells.cell_strains(bonds, self.first, self.alpha, length, share, strain)
        return CellShapes(bonds, length, share, strain)

    def between_nodes(self, values: Array) -> Array:
        """Return the differences (Q, 6, 3) of nodal vectors (P, 3) along the bonds."""
        bonds = np.empty((len(self.nodes), 6, 3))
        cells.between_nodes(self.nodes, BONDS, values, bonds)
        return bonds

    def one_sided(self, response: AngleDiagonalsResponse, state: Array) -> OneSided:
        """Return the diagonals as elements that only pull."""
        return SlackAngleDiagonals(response, state)


@dataclass(frozen=True)
class CellShapes:
    """Cells as they stand: bonds (Q, 6, 3), lengths (Q, 6), share of the warp (Q,), strains of the diagonals (Q, 2)."""

    bonds: Array
    length: Array
    share: Array
    strain: Array


@dataclass(frozen=True)
class AngleDiagonalsResponse(Response):
    """Cells at a trial: shape, dU/de and d2U/de2 (Q, 2) in N mm, plastic strains (Q, 2)."""

    block: AngleDiagonals
    shape: CellShapes
    pull: Array
    stiff: Array
    plastic: Array

    @property
    def state(self) -> Array:
        """Plastic strains to carry over."""
        return self.plastic

    def energy(self) -> Energy:
        """Return stored and plastic energy, N mm."""
        block, law = self.block, np.zeros(self.pull.size, dtype=np.int64)
        stored, lost = kernels.law_energy(
            block.table, law, block.volume.ravel(), self.shape.strain.ravel(), self.plastic.ravel()
        )
        return Energy(stored=stored, plastic=lost)

    def add_gradient(self, gradient: Array) -> None:
        """Add nodal gradients to gradient (P, 3)."""
        shape = self.shape
        cells.add_cell_gradient(self.block.nodes, BONDS, shape.bonds, shape.length, shape.share, self.pull, gradient)

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add the tangent; `exact` False leaves out what the sides' stretch takes off and what falls with length."""
        shape = self.shape
        cells.add_cell_tangent(
            self.block.nodes, BONDS, shape.bonds, shape.length, shape.share, self.pull, self.stiff, exact, rows, pairs,
            values,
        )  # fmt: skip


class SlackAngleDiagonals(OneSided):
    """The diagonals (2 Q) at a trial beyond their slack lengths at the start of the increment.

    Lengths are effective ones, exp(e), in units of the first length; forces are energies, N mm.
    """

    def __init__(self, response: AngleDiagonalsResponse, plastic: Array) -> None:
        """Take the trial and the plastic strains (Q, 2) it started from."""
        block = response.block
        self.response = response
        self.plastic = plastic.ravel()
        self.length = np.exp(response.shape.strain)
        self.slack = np.exp(self.plastic)
        self.stretch = self.length.ravel() - self.slack
        elastic = block.table[0, E] * block.volume.ravel() / self.slack
        pulls = self.stretch > 1e-13
        secant = (response.pull / self.length).ravel() / np.where(pulls, self.stretch, 1.0)
        self.stiffness = np.maximum(np.where(pulls & (secant > 1e-6 * elastic), secant, elastic), 1e-12)

    def bear(self, stretch: Array) -> tuple[Array, Array]:
        """Return force and slope of the law at stretches (2 Q,) beyond the slack lengths."""
        block = self.response.block
        force, along = np.empty(len(stretch)), np.empty(len(stretch))
        kernels.law_beyond(block.table, block.volume.ravel(), self.slack, stretch, self.plastic, force, along)
        return force, along

    def _bearing(self, force: Array, along: Array) -> AngleDiagonalsResponse:
        """Return the response in which the diagonals bear `force` that grows by `along`, both (2 Q,)."""
        pull = force.reshape(-1, 2) * self.length
        return replace(self.response, pull=pull, stiff=along.reshape(-1, 2) * self.length**2 + pull)

    def add_gradient(self, force: Array, gradient: Array) -> None:
        """Add the gradient when the diagonals bear `force` (2 Q,)."""
        self._bearing(force, np.zeros_like(force)).add_gradient(gradient)

    def add_tangent(
        self, force: Array, along: Array, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float
    ) -> None:
        """Add the tangent when the diagonals bear `force` that grows by `along`, both (2 Q,)."""
        self._bearing(force, along).add_tangent(rows, pairs, values, exact=exact, damping=damping)

    def rate(self, step: Array) -> Array:
        """Return the change of stretch (2 Q,) along `step` (P, 3), to first order."""
        shape = self.response.shape
        rate = np.empty_like(self.length)
        cells.cell_rates(shape.bonds, shape.length, shape.share, self._bonds(step), rate)
        return np.asarray((self.length * rate).ravel())

    def bulge(self, step: Array, rate: Array) -> Array:
        """Return what the stretch changes beyond `rate` along `step`."""
        block, shape = self.response.block, self.response.shape
        moved = block.shape_of(shape.bonds + self._bonds(step))
        return np.asarray((np.exp(moved.strain) - self.length).ravel() - rate)

    def _bonds(self, step: Array) -> Array:
        """Return the changes (Q, 6, 3) of the bond vectors."""
        return self.response.block.between_nodes(step)
