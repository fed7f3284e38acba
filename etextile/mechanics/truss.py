"""Trusses of one or more families: fabric yarns between nodes, wires embedded in cells.

A truss spans the difference vector d = sum_a w_a x_a of its k nodes (sum_a w_a = 0). Two nodes with weights (-1, 1) are
a yarn segment; a wire element between two points interpolated in lattice cells has up to eight.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from etextile.lattice.weave import LAND
from etextile.laws.powerlaw import DAMAGE_ONSET, DAMAGE_RATE, PowerLaw
from etextile.mechanics import kernels
from etextile.mechanics.onesided import OneSided
from etextile.mechanics.protocol import Contribution, Energy, Fields, Response
from etextile.types import Array, BoolArray, IntArray


MOST_DAMAGE = 0.5
"""Damage that a truss past its force peak may take in one increment, as ln of what it bore over what it still bears."""


@dataclass(frozen=True)
class TrussBlock(Contribution):
    """Trusses with the power law: nodes (M, k), weights (M, k), rest_length (M,) mm, area (M,) mm2, law (M,) into laws.

    A truss is as long as its ends are apart, less its `offset` (M,) mm: the part of it that a land holds (below zero
    for wires whose ends are drawn together on a land); rest length and span are those of what stretches.

    `family` (M,) names the kind for results (0 warp, 1 weft, 2 diagonal, 3 wire); `span` (M,) is the distance of the
    end points in the flat fabric, the base of engineering strain (it differs from the rest length when a truss is
    mounted slack or taut).
    """

    name: str
    nodes: IntArray
    weights: Array
    rest_length: Array
    span: Array
    offset: Array
    area: Array
    law: IntArray
    laws: tuple[PowerLaw, ...]
    family: IntArray

    @classmethod
    def between_nodes(
        cls, name: str, trusses: IntArray, *, length: Array, area: Array, family: IntArray, laws: tuple[PowerLaw, ...]
    ) -> TrussBlock:
        """Return plain two-node trusses whose law is chosen by their family."""
        weights = np.tile(np.array([-1.0, 1.0]), (len(trusses), 1))
        none = np.zeros(len(trusses))
        return cls(name, trusses.astype(np.int64), weights, length, length, none, area, family, laws, family)

    @property
    def fault(self) -> str:
        """What is wrong with the arrays, '' when nothing is: effects of users may return any."""
        count = len(self.nodes)
        for name in ("rest_length", "span", "offset", "area", "law", "family"):
            values = np.asarray(getattr(self, name))
            if values.shape != (count,):
                return f"{name} of the trusses {self.name!r} has the shape {values.shape}, expected ({count},)"
            if not np.isfinite(values).all():
                return f"{name} of the trusses {self.name!r} is not finite at {int(np.argmin(np.isfinite(values)))}"
        if count and not (self.law.min() >= 0 and self.law.max() < len(self.laws)):
            return f"law of the trusses {self.name!r} goes beyond its {len(self.laws)} laws"
        return ""

    @property
    def in_results(self) -> bool:
        """Whether the trusses have cells of their own in results; those under parts lie on trusses of the lattice."""
        return not (len(self.family) and self.family[0] == LAND)

    @cached_property
    def table(self) -> Array:
        """Parameter rows of the laws, shape (len(laws), columns)."""
        return np.array([law.row() for law in self.laws])

    @cached_property
    def modulus(self) -> Array:
        """Young's modulus (M,) MPa."""
        return np.array([law.E for law in self.laws])[self.law]

    @cached_property
    def carries_compression(self) -> BoolArray:
        """Whether a truss carries a share of its loading curve in compression (M,)."""
        return np.array([law.compression_ratio > 0.0 for law in self.laws])[self.law]

    def initial_state(self) -> Array:
        """Return zero plastic strains (M,)."""
        return np.zeros(len(self.nodes))

    def respond(self, x: Array, travel: float, state: Array) -> TrussResponse:
        """Evaluate all trusses at positions x (N, 3) from plastic strains `state` (M,)."""
        count = len(self.nodes)
        unit = np.empty((count, 3))
        length, force, along, plastic = (np.empty(count) for _ in range(4))
        kernels.truss_response(
            x, self.nodes, self.weights, self.rest_length, self.offset, self.area, self.law, self.table, state,
            unit, length, force, along, plastic,
        )  # fmt: skip
        return TrussResponse(self, unit, length, force, along, plastic)

    def among(self, elements: IntArray, number: IntArray) -> TrussBlock | None:
        """Return some of the trusses; those of effects, which know their neighbours, stay together."""
        if type(self) is not TrussBlock:
            return None
        return replace(
            self,
            nodes=number[self.nodes[elements]],
            weights=self.weights[elements],
            rest_length=self.rest_length[elements],
            span=self.span[elements],
            offset=self.offset[elements],
            area=self.area[elements],
            law=self.law[elements],
            family=self.family[elements],
        )

    def state_among(self, state: Array, elements: IntArray) -> Array:
        """Return the plastic strains of `elements`."""
        return state[elements]

    def haste(self, response: TrussResponse, state: Array) -> float:
        """Return how much damage trusses past their force peak took, over the most that one increment may bring.

        While such a truss snaps its neighbours unload: what they took until then is lost in a longer increment.
        """
        if not self.table[:, DAMAGE_RATE].any():
            return 0.0
        past = (response.force > 0.0) & (response.along < 0.0)
        law = self.table[self.law[past]]
        before, after = (np.maximum(p[past] - law[:, DAMAGE_ONSET], 0.0) for p in (state, response.plastic))
        return float((law[:, DAMAGE_RATE] * (after - before)).max(initial=0.0)) / MOST_DAMAGE

    def one_sided(self, response: TrussResponse, state: Array) -> OneSided | None:
        """Return the trusses as elements that only pull; blocks with another response are taken as they are."""
        return SlackTrusses(response, state) if type(response) is TrussResponse else None


@dataclass(frozen=True)
class TrussResponse(Response):
    """Trusses at a trial: unit vectors (M, 3), length mm, force N, along = dF/dl N/mm, plastic strain; each (M,)."""

    block: TrussBlock
    unit: Array
    length: Array
    force: Array
    along: Array
    plastic: Array

    @property
    def state(self) -> Array:
        """Plastic Hencky strains (M,) to carry over."""
        return self.plastic

    @property
    def distance(self) -> Array:
        """Distance (M,) of the ends, mm."""
        return self.length + self.block.offset

    @property
    def strain(self) -> Array:
        """Engineering strain (M,) of the spans."""
        return self.length / self.block.span - 1.0

    @property
    def stress(self) -> Array:
        """True stress (M,) MPa: force over the area A0 exp(-eps_p); zero for a truss an effect has left no area."""
        area = self.block.area
        return np.divide(self.force, area, out=np.zeros_like(area), where=area > 0.0) * np.exp(self.plastic)

    @property
    def fields(self) -> Fields | None:
        """Strains and forces of trusses of the lattice and of wires; None for helpers."""
        return Fields(self.strain, self.stress, self.plastic, self.force) if self.block.in_results else None

    @property
    def softening(self) -> int:
        """Number of taut trusses whose force falls with length."""
        return int(np.count_nonzero((self.force > 0.0) & (self.along < 0.0)))

    @property
    def giving_way(self) -> str:
        """Trusses past their peak, in words."""
        count = self.softening
        return f"{count} yarn segment{'s are' if count > 1 else ' is'} past the peak force" if count else ""

    def energy(self) -> Energy:
        """Return stored and plastic energy, N mm."""
        block = self.block
        stored, plastic = kernels.truss_energy(
            self.length, block.rest_length, block.area, block.law, block.table, self.plastic
        )
        return Energy(stored=stored, plastic=plastic)

    def add_gradient(self, gradient: Array) -> None:
        """Add nodal forces (as derivative of the energy) to gradient (N, 3)."""
        kernels.add_truss_gradient(self.block.nodes, self.block.weights, self.unit, self.force, gradient)

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add the tangent to the pattern values; only softening and carried compression make it indefinite."""
        along, across = self.along, self.force / self.distance
        if not exact:
            along, across = np.maximum(along, 0.0), np.maximum(across, 0.0)
        kernels.add_truss_tangent(
            self.block.nodes, self.block.weights, self.unit, along, across, damping, rows, pairs, values
        )


class SlackTrusses(OneSided):
    """Trusses at a trial beyond their slack lengths rest exp(eps_p) at the start of the increment.

    Trusses that carry compression add that branch as it is: only its change of stiffness at zero is one-sided.
    """

    def __init__(self, response: TrussResponse, plastic: Array) -> None:
        """Take the trial, and the plastic strains (M,) it started from."""
        block = response.block
        self.response = response
        self.plastic = plastic
        self.slack_length = block.rest_length * np.exp(plastic)
        self.stretch = response.length - self.slack_length
        pulls = self.stretch > 1e-13 * block.rest_length
        elastic = block.modulus * block.area / self.slack_length
        secant = response.force / np.where(pulls, self.stretch, 1.0)
        self.stiffness = np.maximum(np.where(pulls & (secant > 1e-6 * elastic), secant, elastic), 1e-12)
        self.pushes = block.carries_compression & ~pulls

    def bear(self, stretch: Array) -> tuple[Array, Array]:
        """Return force and dF/dl of the law at the slack length plus `stretch` (M,)."""
        block = self.response.block
        force, along = np.empty(len(stretch)), np.empty(len(stretch))
        kernels.truss_law(
            self.slack_length, stretch, block.rest_length, block.area, block.law, block.table, self.plastic,
            force, along,
        )  # fmt: skip
        return force, along

    def add_gradient(self, force: Array, gradient: Array) -> None:
        """Add nodal forces of trusses that pull with `force` (M,)."""
        block, response = self.response.block, self.response
        force = np.where(self.pushes, force + response.force, force) if self.pushes.any() else force
        kernels.add_truss_gradient(block.nodes, block.weights, response.unit, force, gradient)

    def add_tangent(
        self, force: Array, along: Array, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float
    ) -> None:
        """Add the tangent of trusses that pull with `force` (M,) and stiffness `along` (M,)."""
        block, response = self.response.block, self.response
        if self.pushes.any():
            pushed = response.force if exact else np.maximum(response.force, 0.0)
            force = np.where(self.pushes, force + pushed, force)
            along = np.where(self.pushes, along + response.along, along)
        kernels.add_truss_tangent(
            block.nodes, block.weights, response.unit, along, force / response.distance, damping, rows, pairs, values
        )

    def rate(self, step: Array) -> Array:
        """Return the change of length (M,) along `step`, to first order."""
        rate = np.empty(len(self.stretch))
        kernels.truss_rate(step, self.response.block.nodes, self.response.block.weights, self.response.unit, rate)
        return rate

    def bulge(self, step: Array, rate: Array) -> Array:
        """Return the length gained by turning along `step`."""
        bulge = np.empty(len(self.stretch))
        block, response = self.response.block, self.response
        kernels.truss_bulge(step, block.nodes, block.weights, response.distance, rate, bulge)
        return bulge
