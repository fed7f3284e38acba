r"""Shear resistance from springs on the angle between the yarns instead of diagonal trusses.

Diagonals resist shear, but they also stretch, and carry, when warp and weft are stretched together: the paper's own
explanation for its too stiff punch beyond 25 mm. Springs on the angle do not. In a trellis of fixed sides a, b sheared
by gamma the diagonals have the lengths d^2 = a^2 + b^2 +- 2 a b sin(gamma), so with q = 2 a b / (a^2 + b^2)

    eps+- = ln(1 +- q sin(gamma)) / 2

are the Hencky strains of virtual diagonals that follow the angle alone. They keep the volume, the law and the
plastic history of the real ones: in pure trellis shear the energy is the same, in equal biaxial stretch there is none.
`share` of each diagonal's area moves over, a quarter to each corner of its cell, where sin(gamma) is the cosine between
the yarns that cross there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from etextile.effects import kernels
from etextile.effects.angles import FIRST_ARM, SECOND_ARM, AngleBlock, AngleResult, arm_lengths, corners
from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.change import lattice_block, with_lattice_block
from etextile.lattice.weave import DIAGONAL
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Energy
from etextile.mechanics.truss import TrussBlock
from etextile.types import Array, IntArray


LEAST = 1e-6
"""Share of its area that a diagonal keeps at least, so that its stress and stiffness stay defined."""


@dataclass(frozen=True)
class VirtualDiagonals:
    """Two virtual diagonals per corner: aspect q (n,), volume (n, 2) mm3, one row of the law's parameter table."""

    aspect: Array
    volume: Array
    table: Array

    def initial_state(self) -> Array:
        """Return zero plastic strains (n, 2)."""
        return np.zeros_like(self.volume)

    def evaluate(self, cosine: Array, state: Array) -> AngleResult:
        """Return energy and derivatives with respect to sin(gamma) (n,) from plastic strains `state` (n, 2)."""
        signed = self.aspect[:, None] * np.array([1.0, -1.0])
        stretch = 1.0 + signed * cosine[:, None]
        strain = 0.5 * np.log(stretch)
        slope = 0.5 * signed / stretch
        law = np.zeros(strain.size, dtype=np.int64)
        tau, rise, plastic = (np.empty(strain.size) for _ in range(3))
        kernels.law_response(self.table, law, strain.ravel(), state.ravel(), tau, rise, plastic)
        stored, lost = kernels.law_energy(self.table, law, self.volume.ravel(), strain.ravel(), plastic)
        tau, rise = tau.reshape(strain.shape), rise.reshape(strain.shape)
        return AngleResult(
            (self.volume * tau * slope).sum(axis=1),
            (self.volume * (rise - 2.0 * tau) * slope**2).sum(axis=1),
            plastic.reshape(strain.shape),
            Energy(stored=stored, plastic=lost),
        )


@dataclass(frozen=True)
class RotationalShear(Effect):
    """Share of the diagonals' area that acts on the angle of the yarns."""

    share: float = 0.0

    stage: ClassVar[Stage] = Stage.ELEMENTS
    card: ClassVar[Card] = Card(
        id="rotational_shear",
        mechanism="Shear is resisted by springs on the yarn angle instead of diagonals that also stretch.",
        parameters=(Parameter("share", "", 0.0, 1.0, "the share of the shear resistance that acts on the angle"),),
        example=Example({"share": 1.0}),
        signature=(
            Signature("punch_force", -1, 0.0, "less, gradually more so, since the diagonals stretched over the punch"),
            Signature("free_edge", 0, 0.0, "the free edge moves"),
            Signature("tensile", 0, 0.0, "none: the bias curve is unchanged by construction"),
        ),
        confused_with=("machine_compliance", "geometry"),
        separate="The strain field beside the punch and the free edge; a compliant machine has the right shapes at the "
        "wrong displacement.",
        literature="Proposed by Beex et al., section 6; pin-jointed nets with shear springs: Sharma and Sutcliffe, "
        "Composites A 35 (2004) 637.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with thinner diagonals and springs at the corners of every cell."""
        block = lattice_block(model)
        cells, diagonals = cells_with_diagonals(block, model.lattice.quads)
        area = block.area.copy()
        area[diagonals.ravel()] *= max(1.0 - self.share, LEAST)
        nodes = corners(cells)
        potential = _potential(self.share, block, diagonals, arm_lengths(model.points, nodes))
        springs = AngleBlock("rotational shear", nodes, FIRST_ARM, SECOND_ARM, potential)
        return with_lattice_block(model, replace(block, area=area)).with_contribution(springs)


def cells_with_diagonals(block: TrussBlock, quads: IntArray) -> tuple[IntArray, IntArray]:
    """Return the cells (n, 4) that have both diagonals, and the truss numbers (n, 2) of those."""
    numbers = np.flatnonzero(block.family == DIAGONAL)
    ends = np.sort(block.nodes[numbers, :2], axis=1)
    found = {(int(a), int(b)): int(number) for (a, b), number in zip(ends, numbers, strict=True)}
    wanted = np.sort(quads[:, [[0, 2], [1, 3]]], axis=2).tolist()
    both = [[found.get((a, b), -1) for a, b in pair] for pair in wanted]
    diagonals = np.array(both, dtype=np.int64).reshape(-1, 2)
    keep = (diagonals >= 0).all(axis=1)
    return quads[keep], diagonals[keep]


def _potential(share: float, block: TrussBlock, diagonals: IntArray, arms: tuple[Array, Array]) -> VirtualDiagonals:
    """Return the potential of four corners per cell; at every other corner the diagonals change places."""
    a, b = arms
    square = a**2 + b**2
    quarter = 0.25 * share * block.area[np.stack([diagonals, diagonals[:, ::-1]] * 2, axis=1).reshape(-1, 2)]
    return VirtualDiagonals(
        2.0 * a * b / square, quarter * np.sqrt(square)[:, None], block.laws[DIAGONAL].row()[None, :]
    )
