"""Clamps hold a limited tension and feed the fabric past the jaw edge beyond it.

Fabric sticks between the jaws until its tension per width reaches the limit, then it is drawn past the edge of the
jaws, which stays where it is, against friction that grows (or fades) with slip. The paper sees it in its experiments
from about 40 mm on. The middle of the clamp, where the tension is largest, slides first and hands its load to its
neighbours. The check is a strip of yarns over the punch, in closed form (`tests/physics/test_clamp_feeds.py`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.clamps import with_clamps
from etextile.mechanics.model import Model


@dataclass(frozen=True)
class ClampSlip(Effect):
    """Tension at which fabric slides out of its clamps (0: never) and its growth with slip."""

    limit: float = 0.0
    hardening: float = 0.0

    stage: ClassVar[Stage] = Stage.SUPPORT
    card: ClassVar[Card] = Card(
        id="clamp_slip",
        mechanism="Clamps hold a limited tension, then feed the fabric past their edge with friction.",
        parameters=(
            Parameter(
                "limit",
                "N/mm",
                0.5,
                100.0,
                "the tension per width of clamp at which it slides",
                scale="log",
                limits=(0.02, 1000.0),
            ),
            Parameter(
                "hardening",
                "N/mm**2",
                -5.0,
                20.0,
                "the growth of that tension per mm of slip",
                neutral=None,
                default=0.0,
            ),
        ),
        example=Example(
            {"limit": 12.0, "hardening": 0.0}, (0.0, 0.0, -3.1, -20.7, -42.8), (0.0, 0.0, 0.01, 0.09, 0.56)
        ),
        signature=(
            Signature("punch_force", -1, 25.0, "nothing, then a plateau once the clamps slide; repeats scatter more"),
            Signature("clamp_line", 1, 25.0, "the fabric moves at the clamp line, first in the middle"),
            Signature("free_edge", -1, 25.0, "less draw-in"),
        ),
        confused_with=("yarn_tail", "yarn_damage", "yarn_sliding"),
        separate="A mark on the fabric at the clamp line.",
        literature="Slip from about 40 mm on: Beex et al., section 5.1.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model whose clamps slide; BadInput without clamps."""
        return with_clamps(model, self.card.id, limit=self.limit, hardening=self.hardening)
