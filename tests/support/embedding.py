"""Wires of one construction put into a model of the test's own, bonded or sliding."""

from __future__ import annotations

import numpy as np

from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.results.wire_layout import WireLayout
from wires.embed import EmbeddedWires, bonded, with_strands
from wires.embed_slip import WeaveHold, sliding


def embedded(
    model: Model, layout: WireLayout, law: PowerLaw, *, area_mm2: float, crimp: float, channel: WeaveHold | None
) -> tuple[Model, EmbeddedWires]:
    """Return the model with all wires of a layout, sliding in a channel or bonded without one."""
    wires = np.arange(layout.n_wires)
    if channel is None:
        return with_strands(model, layout, [bonded(model, layout, wires, law, area_mm2=area_mm2, crimp=crimp)])
    model, strand = sliding(model, layout, wires, law, area_mm2=area_mm2, crimp=crimp, channel=channel)
    return with_strands(model, layout, [strand])
