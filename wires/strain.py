"""Strains of loops and woven-in wires at an increment, whatever their bond."""

from __future__ import annotations

import numpy as np

from etextile.lattice.weave import WIRE
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock
from etextile.solve.path import Increment
from etextile.types import Array
from wires.embed import EmbeddedWires
from wires.slip import SlidingWires
from wires.spans import LoopSpans


def wire_strains(wires: EmbeddedWires, model: Model, increment: Increment) -> dict[str, Array]:
    """Return the strains stored of an increment, all engineering strains.

    span_strain (L,): fabric span of each loop, along the fabric; wire_strain (L,), element_strain (K,): of the wire,
    after slack and crimp are taken up, 0 while it is slack. For perfectly bonded wires (1 + e) / (1 + excess) - 1; a
    sliding one is compared with the virgin length of wire that it now holds. Where a wire cannot slide, a loop's free
    length takes all that its span grows by; a chord would cut the kinks of a coarse lattice and lose more than a small
    part takes. All are strains since the wire was woven in: a specimen that was mounted at the strain p and is
    stretched by e is at (1 + p) (1 + e) - 1.
    """
    family = np.concatenate([block.family for block in model.truss_blocks])
    strain = increment.truss_strain[family == WIRE]
    woven = strain[wires.woven]
    of_wires = [
        (block, state)
        for block, state in zip(model.contributions, increment.state.states, strict=True)
        if isinstance(block, TrussBlock) and len(block.family) and block.family[0] == WIRE
    ]
    lengths = np.concatenate([block.span for block, _ in of_wires] or [np.zeros(0)])
    spans = LoopSpans.of(model.lattice, wires.layout, lands=wires.lands)
    span = spans.strain(increment.state.x, shrink=lengths[wires.loops] / spans.flat)
    wire = np.empty(len(strain))
    wire[wires.loops] = np.maximum((1.0 + span) / (1.0 + wires.layout.loop_slack) - 1.0, 0.0)
    wire[wires.woven] = np.maximum((1.0 + woven) / (1.0 + wires.element_crimp) - 1.0, 0.0)
    along = 1.0 + strain
    along[wires.loops] = 1.0 + span
    first = 0
    for block, state in of_wires:
        own = slice(first, first + len(block.nodes))
        first += len(block.nodes)
        if isinstance(block, SlidingWires):
            stretch = along[own] if block.anchored.all() else 1.0 + strain[own]
            wire[own] = np.maximum((stretch * block.span - block.rigid) / state.virgin - 1.0, 0.0)
    return {"span_strain": span, "wire_strain": wire[wires.loops], "element_strain": wire[wires.woven]}
