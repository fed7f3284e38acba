"""Elastic clamps: jaw linings and frame give in proportion to the line force along the pull."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.clamps import with_clamps
from etextile.mechanics.model import Model


@dataclass(frozen=True)
class ClampCompliance(Effect):
    """Motion of the clamped edge into the specimen per line force, mm per N/mm."""

    compliance: float = 0.0

    stage: ClassVar[Stage] = Stage.SUPPORT
    card: ClassVar[Card] = Card(
        id="clamp_compliance",
        mechanism="Elastic clamps move inwards in proportion to the line force.",
        parameters=(Parameter("compliance", "mm**2/N", 0.0, 0.5, "the motion in mm per N/mm of line force"),),
        example=Example({"compliance": 0.03}, (-4.7, -5.4, -5.1, -4.6, -3.2), (-0.01, -0.01, 0.02, 0.04, 0.1)),
        signature=(
            Signature("punch_force", -1, 0.0, "less, from small displacement on"),
            Signature("clamp_line", 1, 0.0, "the fabric moves at the clamp line in proportion to the force"),
        ),
        confused_with=("datum_offset", "machine_compliance"),
        separate="A mark on the clamp line: it moves from the start on and returns when unloaded.",
        literature="Beex et al., section 2.1, measure coupon strains optically for this reason; the punch test has no "
        "such remedy.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with elastic clamps; BadInput without clamps."""
        return with_clamps(model, self.card.id, compliance=self.compliance)
