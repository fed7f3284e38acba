r"""Shear resistance from the angle between the yarns instead of diagonal trusses.

Diagonals resist shear, but they also stretch, and carry, when warp and weft are stretched together: the paper's own
explanation for its too stiff punch beyond 25 mm. Springs on the angle do not. In a trellis of fixed sides a, b sheared
by gamma the diagonals have the lengths d^2 = a^2 + b^2 +- 2 a b sin(gamma), so with q = 2 a b / (a^2 + b^2)

    eps+- = ln(1 +- q sin(gamma)) / 2

is a Hencky strain that follows the angle alone. `share` of each diagonal's area moves over to a diagonal with that
strain, which keeps volume, law and plastic history: in pure trellis shear the energy is the same, in biaxial stretch
there is none.

Nothing keeps a net of such springs from folding between its nodes without a force: it has many equilibria, and up to
25 mm the height of its free edge at mid-span differs by 1 to 2 mm from one lattice to the next. Real fabric bends.
`FOLD`, the bending stiffness of a light woven fabric, comes with the springs; it changes the force by less than a
thousandth and settles the folds, but nobody knows it, so the card leaves their height undetermined.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from etextile.effects.angle_diagonals import INCIDENCE, AngleDiagonals
from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage, Undetermined
from etextile.effects.bending_stiffness import turn_blocks
from etextile.effects.change import lattice_block, with_lattice_block
from etextile.lattice.weave import DIAGONAL
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock
from etextile.types import IntArray


FOLD = 0.02
"""Bending stiffness of the fabric per width, N mm."""
LEAST = 1e-6
"""Share of its area that a diagonal keeps at least, so that its stress and stiffness stay defined."""


@dataclass(frozen=True)
class RotationalShear(Effect):
    """Share of the diagonals' area that acts on the angle of the yarns."""

    share: float = 0.0

    stage: ClassVar[Stage] = Stage.ELEMENTS
    card: ClassVar[Card] = Card(
        id="rotational_shear",
        mechanism="Shear is resisted by springs on the yarn angle instead of diagonals that also stretch.",
        parameters=(Parameter("share", "", 0.0, 1.0, "the share of the shear resistance that acts on the angle"),),
        example=Example({"share": 1.0}, (-3.1, -7.3, -9.4, -11.3, -14.4), (0.01, 0.01, 0.09, 0.07, -0.09)),
        signature=(
            Signature("punch_force", -1, 0.0, "less, gradually more so, since the diagonals stretched over the punch"),
            Signature("free_edge", 0, 0.0, "the free edge stays farther out between mid-span and clamp, and may fold"),
            Signature("tensile", 0, 0.0, "none: the bias curve is unchanged by construction"),
        ),
        confused_with=("machine_compliance", "geometry"),
        separate="The strain field beside the punch and the free edge; a compliant machine has the right shapes at the "
        "wrong displacement.",
        limits=f"Comes with a bending stiffness of the fabric, {FOLD} N*mm times the share, that settles its folds.",
        undetermined=(Undetermined("free_edge", "height", 1.0),),
        literature="Proposed by Beex et al., section 6; pin-jointed nets with shear springs: Sharma and Sutcliffe, "
        "Composites A 35 (2004) 637.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with thinner diagonals and others that follow the angle in every cell."""
        block = lattice_block(model)
        cells, diagonals = cells_with_diagonals(block, model.lattice.quads)
        area = block.area.copy()
        area[diagonals.ravel()] *= max(1.0 - self.share, LEAST)
        first = np.linalg.norm(INCIDENCE @ model.points[cells], axis=2)
        volume = self.share * block.area[diagonals] * first[:, 4:]
        springs = AngleDiagonals(cells, first, volume, block.laws[DIAGONAL].row()[None, :])
        changed = with_lattice_block(model, replace(block, area=area)).with_contribution(springs)
        for turns in turn_blocks(model, self.share * FOLD, clamp=0.0):
            changed = changed.with_contribution(turns)
        return changed


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
