"""Strains of loops and woven-in wires at an increment, whatever their bond."""

from __future__ import annotations

import numpy as np

from etextile.lattice.weave import WIRE
from etextile.mechanics.model import Model
from etextile.solve.path import Increment
from etextile.types import Array
from wires.embed import EmbeddedWires
from wires.slip import SlidingWires
from wires.spans import LoopSpans


def wire_strains(wires: EmbeddedWires, model: Model, increment: Increment) -> dict[str, Array]:
    """Return the strains stored of an increment, all engineering strains.

    span_strain (L,): fabric span of each loop, along the fabric; wire_strain (L,), element_strain (K,): of the wire,
    after slack and crimp are taken up, 0 while it is slack. For perfectly bonded wires (1 + e) / (1 + excess) - 1; a
    sliding one is compared with the virgin length of wire that it now holds.
    """
    family = np.concatenate([block.family for block in model.truss_blocks])
    strain = increment.truss_strain[family == WIRE]
    woven = strain[: wires.count]
    span = LoopSpans.of(model.lattice, wires.layout).strain(increment.state.x)
    for block, state in zip(model.contributions, increment.state.states, strict=True):
        if isinstance(block, SlidingWires):
            own = np.maximum(((1.0 + strain) * block.span - block.rigid) / state.virgin - 1.0, 0.0)
            return {"span_strain": span, "wire_strain": own[wires.count :], "element_strain": own[: wires.count]}
    return {
        "span_strain": span,
        "wire_strain": np.maximum((1.0 + span) / (1.0 + wires.layout.loop_slack) - 1.0, 0.0),
        "element_strain": np.maximum((1.0 + woven) / (1.0 + wires.crimp) - 1.0, 0.0),
    }
