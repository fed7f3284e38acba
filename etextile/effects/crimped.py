r"""Trusses whose strain grows with that of the yarns they cross: energy, force and tangent of crimp interchange.

In each lattice cell the two warp and two weft segments s, each counted by half, follow their laws at

    e_s = eps_s + c (r(eps_k) + r(eps_l)) / 2,       k, l the crossing segments,   r(eps) = positive part of eps,

rounded over `ROUNDING`. The energy is a function of the truss lengths alone, so forces stay axial, F = dU/dl, and what
is left beside plain trusses is the tangent between crossing segments, a contribution over the nodes of the cells.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from etextile.effects import kernels
from etextile.mechanics.kernels import add_dense_blocks
from etextile.mechanics.protocol import Contribution, Energy, Response
from etextile.mechanics.truss import TrussBlock, TrussResponse
from etextile.types import Array, IntArray


ROUNDING = 2e-3
"""Strain over which a crossing yarn begins to count."""
CROSSING = np.array([[2, 3], [2, 3], [0, 1], [0, 1]])
"""Segments of a cell (warp, warp, weft, weft) that cross each of them."""


@dataclass(frozen=True)
class CrimpState:
    """Plastic strains of whole trusses (M,) and of the halves in the cells (Q, 4)."""

    whole: Array
    half: Array


@dataclass(frozen=True)
class CrimpedTrusses(TrussBlock):
    """Fabric trusses of which those in `cells` (Q, 4: warp, warp, weft, weft) are tightened by the yarns they cross.

    part (Q, 4): share of the truss that counts in the cell; coupled (M,): whether a truss is in any cell.
    """

    cells: IntArray
    part: Array
    coefficient: float

    @property
    def coupled(self) -> Array:
        """1 for trusses in cells, 0 for others, shape (M,)."""
        return np.minimum(np.bincount(self.cells.ravel(), minlength=len(self.nodes)), 1).astype(float)

    def initial_state(self) -> CrimpState:  # type: ignore[override]
        """Return zero plastic strains."""
        return CrimpState(np.zeros(len(self.nodes)), np.zeros(self.cells.shape))

    def respond(self, x: Array, travel: float, state: CrimpState) -> CrimpedResponse:  # type: ignore[override]
        """Evaluate all trusses at positions x (P, 3)."""
        plain = super().respond(x, travel, state.whole)
        found = self.evaluate(plain.length, state.half)
        alone = 1.0 - self.coupled
        slope = self.gather(found.slope)
        stiff = self.gather(np.einsum("qaa->qa", found.curvature))
        mean = self.mean(found.plastic)
        return CrimpedResponse(
            self,
            plain.unit,
            plain.length,
            alone * plain.force + slope / plain.length,
            alone * plain.along + (stiff - slope) / plain.length**2,
            alone * plain.plastic + mean,
            CrimpState(alone * plain.plastic, found.plastic),
            found,
        )

    def evaluate(self, length: Array, old: Array) -> CellValues:
        """Return the energy's derivatives by the Hencky strains of the cells' segments at truss lengths (M,)."""
        strain = np.log(length / self.rest_length)[self.cells]
        reach, rise, bend = _positive_part(strain)
        c = 0.5 * self.coefficient
        effective = strain + c * reach[:, CROSSING].sum(axis=2)
        volume = self.part * (self.area * self.rest_length)[self.cells]
        tau, tangent, plastic = (np.empty(strain.size) for _ in range(3))
        law = self.law[self.cells].ravel()
        kernels.law_response(self.table, law, effective.ravel(), old.ravel(), tau, tangent, plastic)
        pull, stiff = (volume * values.reshape(strain.shape) for values in (tau, tangent))
        spread = np.tile(np.eye(4), (len(strain), 1, 1))
        for s, crossing in enumerate(CROSSING):
            spread[:, s, crossing] = c * rise[:, crossing]
        curvature = np.einsum("qs,qsa,qsb->qab", stiff, spread, spread)
        curvature[:, range(4), range(4)] += c * bend * pull[:, CROSSING].sum(axis=2)
        slope = np.einsum("qs,qsa->qa", pull, spread)
        return CellValues(slope, curvature, plastic.reshape(strain.shape), effective)

    def haste(self, response: TrussResponse, state: CrimpState) -> float:  # type: ignore[override]
        """Return the damage of trusses past their peak, over the most that one increment may bring."""
        return super().haste(response, state.whole + self.mean(state.half))

    def mean(self, values: Array) -> Array:
        """Return the means (M,) over cells of values of their segments (Q, 4), 0 for trusses in none."""
        return self.gather(values) / np.maximum(self.gather(np.ones(self.cells.shape)), 1.0)

    def gather(self, values: Array) -> Array:
        """Return the sum over cells (M,) of values of their segments (Q, 4)."""
        return np.asarray(np.bincount(self.cells.ravel(), values.ravel(), len(self.nodes)), dtype=np.float64)


@dataclass(frozen=True)
class CellValues:
    """dU/d eps (Q, 4) and d2U/d eps2 (Q, 4, 4) in N mm, plastic and effective strains (Q, 4)."""

    slope: Array
    curvature: Array
    plastic: Array
    strain: Array


@dataclass(frozen=True)
class CrimpedResponse(TrussResponse):
    """Tightened trusses at a trial, with the state to keep and what their cells' energy says."""

    after: CrimpState
    cells: CellValues

    @property
    def state(self) -> CrimpState:  # type: ignore[override]
        """Plastic strains to carry over."""
        return self.after

    def energy(self) -> Energy:
        """Return stored and plastic energy, N mm."""
        block = self.block
        if not isinstance(block, CrimpedTrusses):
            return super().energy()
        volume = block.area * block.rest_length
        strain = np.log(self.length / block.rest_length)
        whole = kernels.law_energy(block.table, block.law, (1.0 - block.coupled) * volume, strain, self.after.whole)
        flat = block.cells.ravel()
        half = kernels.law_energy(
            block.table,
            block.law[flat],
            block.part.ravel() * volume[flat],
            self.cells.strain.ravel(),
            self.after.half.ravel(),
        )
        return Energy(stored=whole[0] + half[0], plastic=whole[1] + half[1])


@dataclass(frozen=True)
class CrossTangent(Contribution):
    """Tangent between crossing segments: nodes (Q, K) of the cells, weights (Q, 4, K) of their segments on these."""

    nodes: IntArray
    weights: Array
    trusses: CrimpedTrusses
    name: str = "crimp interchange"

    def initial_state(self) -> CrimpState:
        """Return the state of the trusses, which this part follows."""
        return self.trusses.initial_state()

    def respond(self, x: Array, travel: float, state: CrimpState) -> CrossResponse:
        """Keep the trial: the trusses are evaluated again for what couples them, once that is asked for."""
        return CrossResponse(self, x.copy(), travel, state)


@dataclass(frozen=True)
class CrossResponse(Response):
    """A trial of the trusses: node positions x (P, 3), travel, and the state they started from."""

    block: CrossTangent
    x: Array
    travel: float
    before: CrimpState

    @cached_property
    def inner(self) -> CrimpedResponse:
        """The trusses at the trial."""
        return self.block.trusses.respond(self.x, self.travel, self.before)

    @property
    def state(self) -> CrimpState:
        """State of the trusses."""
        return self.inner.state

    def energy(self) -> Energy:
        """Return nothing: the trusses have it."""
        return Energy()

    def add_gradient(self, gradient: Array) -> None:
        """Add nothing: the trusses have it."""

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add what couples different segments; `exact` False makes it diagonally dominant."""
        cells = self.block.trusses.cells
        length = self.inner.length[cells]
        coupling = self.inner.cells.curvature / (length[:, :, None] * length[:, None, :])
        coupling[:, range(4), range(4)] = 0.0
        if not exact:
            coupling[:, range(4), range(4)] = np.abs(coupling).sum(axis=2)
        unit = self.inner.unit[cells]
        arms = (self.block.weights[:, :, :, None] * unit[:, :, None, :]).reshape(len(unit), 4, -1)
        add_dense_blocks(self.block.nodes, arms.transpose(0, 2, 1) @ coupling @ arms, rows, pairs, values)


def _positive_part(strain: Array) -> tuple[Array, Array, Array]:
    """Return the rounded positive part of strains with two derivatives."""
    rise = np.clip(strain / ROUNDING, 0.0, 1.0)
    reach = np.where(strain < ROUNDING, 0.5 * ROUNDING * rise**2, strain - 0.5 * ROUNDING)
    return reach, rise, np.where((rise > 0.0) & (rise < 1.0), 1.0 / ROUNDING, 0.0)
