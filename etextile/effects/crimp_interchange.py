"""Stretching one yarn family tightens the other: crimp passes from the pulled yarns to those they cross.

A woven yarn is wavy. Pulling the warp straightens it and bends the weft over it, so the weft gets shorter, or, where it
is held, tauter. Each segment follows its law at its own strain plus `coefficient` times the mean tensile strain of the
segments that cross it, in an energy, so that both families feel it alike. Under uniaxial tension the free family
contracts by that share and carries nothing, so coupons say nothing of it; over the punch both are pulled.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import ClassVar

import numpy as np

from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.change import lattice_block, with_lattice_block
from etextile.effects.crimped import CrimpedTrusses, CrossTangent
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock
from etextile.types import Array, IntArray


@dataclass(frozen=True)
class CrimpInterchange(Effect):
    """Strain that a crossing yarn's strain adds, as a share of it."""

    coefficient: float = 0.0

    stage: ClassVar[Stage] = Stage.COUPLING
    card: ClassVar[Card] = Card(
        id="crimp_interchange",
        mechanism="Stretching one yarn family tightens the other.",
        parameters=(Parameter("coefficient", "", 0.0, 0.5, "the added strain over the crossing yarn's strain"),),
        example=Example({"coefficient": 0.1}, (0.5, 1.9, 3.3, 4.4, 7.6), (0.03, 0.16, 0.32, 0.44, 0.77)),
        signature=(
            Signature("punch_force", 1, 15.0, "more where both families are stretched, growing with depth"),
            Signature("free_edge", 1, 10.0, "drawn in more: the weft is tightened by the pulled warp"),
            Signature("tensile", 0, 0.0, "none in uniaxial coupons, which may contract across"),
        ),
        confused_with=("punch_friction", "yarn_tail"),
        separate="Biaxial tension, or the contraction across a uniaxial coupon.",
        literature="Peirce, J. Textile Inst. 28 (1937) T45; Kawabata et al., J. Textile Inst. 64 (1973) 21.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model whose fabric trusses are tightened by those they cross."""
        block = lattice_block(model)
        cells = cell_segments(model)
        count = np.bincount(cells.ravel(), minlength=len(block.nodes))
        own = {item.name: getattr(block, item.name) for item in fields(TrussBlock)}
        trusses = CrimpedTrusses(**own, cells=cells, part=1.0 / count[cells], coefficient=self.coefficient)
        nodes, weights = _cell_nodes(block, cells)
        return with_lattice_block(model, trusses).with_contribution(CrossTangent(nodes, weights, trusses))


def cell_segments(model: Model) -> IntArray:
    """Return the truss numbers (Q, 4) of both warp and both weft segments of the cells that have all four."""
    lattice = model.lattice
    ends = np.sort(lattice.trusses, axis=1).tolist()
    found = {(a, b): number for number, (a, b) in enumerate(ends)}
    sides = np.sort(lattice.quads[:, [[0, 1], [3, 2], [0, 3], [1, 2]]], axis=2).tolist()
    cells = np.array([[found.get((a, b), -1) for a, b in cell] for cell in sides], dtype=np.int64).reshape(-1, 4)
    return cells[(cells >= 0).all(axis=1)]


def _cell_nodes(block: TrussBlock, cells: IntArray) -> tuple[IntArray, Array]:
    """Return the nodes (Q, K) of the cells' segments, each once, and the segments' weights (Q, 4, K) on them."""
    ends = block.nodes[cells]
    warp, weft = ends[:, :2].reshape(-1, 4), ends[:, 2:].reshape(-1, 4)
    shared = np.array_equal(np.sort(warp, axis=1), np.sort(weft, axis=1))
    nodes = np.ascontiguousarray(warp if shared else np.hstack([warp, weft]))
    at = ends[:, :, :, None] == nodes[:, None, None, :]
    return nodes, np.einsum("qse,qsek->qsk", block.weights[cells], at.astype(float))
