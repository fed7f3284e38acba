"""Elastic clamps: the mount of the jaws gives, or their lining.

A mount that gives (screws, frame, load train) lets the jaw line move inwards in proportion to the line force along the
pull, T cos(alpha). A lining that gives lets fabric out past a jaw edge that stays where it is, in proportion to the
fabric's tension T itself. Under a punch, where fabric leaves the clamp at a slope, these are two mechanisms; `lining`
is the share of the give that lies in the lining.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.clamps import with_clamps
from etextile.mechanics.model import Model


@dataclass(frozen=True)
class ClampCompliance(Effect):
    """Give per line force, mm per N/mm, and the share of it that lies in the lining of the jaws."""

    compliance: float = 0.0
    lining: float = 0.0

    stage: ClassVar[Stage] = Stage.SUPPORT
    card: ClassVar[Card] = Card(
        id="clamp_compliance",
        mechanism="Elastic clamps: the jaw line moves inwards (mount) or lets fabric out (lining) with the force.",
        parameters=(
            Parameter("compliance", "mm**2/N", 0.0, 0.5, "the give in mm per N/mm of line force", limits=(0.0, 5.0)),
            Parameter(
                "lining",
                "",
                0.0,
                1.0,
                "the share of the give in the lining: 0 the mount moves, 1 fabric is fed",
                default=0.0,
            ),
        ),
        example=Example(
            {"compliance": 0.03, "lining": 0.0}, (-4.7, -5.4, -5.1, -4.6, -3.2), (-0.01, -0.01, 0.02, 0.04, 0.1)
        ),
        signature=(
            Signature("punch_force", -1, 0.0, "less, from small displacement on"),
            Signature("clamp_line", 1, 0.0, "the fabric moves at the clamp line in proportion to the force"),
        ),
        confused_with=("datum_offset", "machine_compliance"),
        separate="A mark on the fabric and one on the jaw at the clamp line: both move (mount) or the first alone "
        "(lining), from the start on, and return when unloaded.",
        literature="Beex et al., section 2.1, measure coupon strains optically for this reason; the punch test has no "
        "such remedy.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with elastic clamps; BadInput without clamps."""
        if self.compliance == 0.0:
            return model
        lining = self.lining * self.compliance
        return with_clamps(model, self.card.id, lining=lining, mount=self.compliance - lining)
