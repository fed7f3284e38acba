"""The specimen is mounted taut or slack between its clamps.

Mounting at strain e stretches the piece by 1 + e along the clamped direction before the test; the recorded shape of the
specimen is the stretched one. So the free length of every truss is that of the mounted lattice shrunk by 1 / (1 + e) in
that direction: warp by the full amount, diagonals by their share, weft not at all. Negative strain is slack.
A piece that was stretched both ways when it was laid in holds the share `across` of that strain in the other direction
too; its free edges draw in as soon as nobody holds them. How much it was is hardly ever known, so a diagnosis averages
over it.
Engineering strains of the fabric stay relative to the mounted fabric, as an optical measurement has them. Wires were
woven in before: their strains count from there, and multiply, (1 + mounted) (1 + since) - 1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.change import clamped_edges, with_fabric_trusses
from etextile.errors import BadInput
from etextile.lattice.weave import WIRE
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Contribution
from etextile.mechanics.truss import TrussBlock


@dataclass(frozen=True)
class Pretension(Effect):
    """Engineering strain at which the specimen sits in its clamps, negative is slack; share of it the other way."""

    strain: float = 0.0
    across: float = 0.0

    stage: ClassVar[Stage] = Stage.REST
    card: ClassVar[Card] = Card(
        id="pretension",
        mechanism="The specimen is mounted taut (or slack) between its clamps.",
        parameters=(
            Parameter("strain", "", -0.03, 0.03, "the strain from clamp to clamp when mounted", limits=(-0.1, 0.1)),
            Parameter(
                "across",
                "",
                0.0,
                1.0,
                "the share of that strain which the piece was mounted with in the other direction",
                neutral=None,
                default=0.0,
                form=True,
            ),
        ),
        example=Example(
            {"strain": 0.01, "across": 0.0}, (108.4, 25.2, 15.6, 10.6, 5.7), (0.11, -0.22, -0.22, -0.27, -0.29)
        ),
        signature=(
            Signature("punch_force", 1, 0.0, "far more at small displacement, fading with depth as 1 / displacement^2"),
            Signature("free_edge", 1, 0.0, "drawn in from the start on"),
        ),
        confused_with=("datum_offset", "bending_stiffness"),
        separate="Small displacements below 10 mm: a datum offset shifts the curve, pretension changes its slope at "
        "zero from nothing to something.",
        literature="Taut membranes under a punch: Begley and Mackin, J. Mech. Phys. Solids 52 (2004) 2005.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with changed free lengths; BadInput when nothing is clamped."""
        edges = clamped_edges(model)
        if not edges:
            raise BadInput.of("pretension needs clamped edges, the case has none", key="id")
        shrink = np.array([1.0 / (1.0 + self.across * self.strain)] * 2 + [1.0])
        axes = {"xy".find(name[0]) for name in edges}
        shrink[[0, 1] if -1 in axes else sorted(axes)] = 1.0 / (1.0 + self.strain)  # an outline holds both ways

        def mounted(block: TrussBlock) -> TrussBlock:
            ends = np.einsum("mk,mkc->mc", block.weights, model.points[block.nodes])
            ratio = np.linalg.norm(shrink * ends, axis=1) / np.linalg.norm(ends, axis=1)
            offset = ratio * block.offset
            span = block.span + (block.offset - offset)
            return replace(block, rest_length=ratio * block.rest_length, span=span, offset=offset)

        return _with_wires(with_fabric_trusses(model, mounted), float(shrink[0]))


def _with_wires(model: Model, shrink: float) -> Model:
    """Return the model whose wires, woven in along x before the piece was mounted, were mounted with it."""
    parts: list[Contribution] = []
    for part in model.contributions:
        own = getattr(part, "family", None)
        if own is not None and len(own) and bool((own == WIRE).all()):
            lengths = {name: shrink * getattr(part, name) for name in ("rest_length", "span", "offset")}
            part = replace(part, **lengths)  # type: ignore[type-var]
        parts.append(part)
    return replace(model, contributions=tuple(parts))
