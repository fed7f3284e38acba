"""Yarn stress grows with strain rate, and coupons and punch run at different rates.

Polymer yarns stiffen by some per cent per decade of strain rate. The coupons run at 1.67e-3 /s. In the punch test a
straight yarn from clamp to punch is stretched by sqrt(2) - 1 when the travel equals half the clamp distance L / 2, so
the average rate is (sqrt(2) - 1) speed / (L / 2): 8.3e-3 /s at 1 mm/s and L = 100 mm, the paper's number. A pulled
clamp strains at speed / L. All fabric laws are scaled by 1 + per_decade log10(rate / coupon rate).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log10, sqrt
from typing import ClassVar

from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.change import FABRIC, half_length, with_laws
from etextile.errors import BadInput
from etextile.mechanics.model import Model


COUPON_RATE = 1.67e-3
"""Strain rate of the warp and weft coupons, 1/s (paper, section 2)."""


def strain_rate(model: Model) -> float:
    """Return the average strain rate of the motion, 1/s."""
    length = half_length(model)
    if model.carried.any():
        return model.speed / (2.0 * length)
    return (sqrt(2.0) - 1.0) * model.speed / length


@dataclass(frozen=True)
class RateDependence(Effect):
    """Relative growth of all fabric stresses per decade of strain rate."""

    per_decade: float = 0.0

    stage: ClassVar[Stage] = Stage.LAW
    card: ClassVar[Card] = Card(
        id="rate_dependence",
        mechanism="Yarn stress grows with strain rate; coupons and punch run at different rates.",
        parameters=(
            Parameter(
                "per_decade", "", -0.05, 0.3, "the growth of stress per decade of strain rate", limits=(-0.3, 1.0)
            ),
        ),
        example=Example({"per_decade": 0.05}, (3.5, 3.5, 3.5, 3.5, 3.5), (0.0, 0.0, 0.0, 0.0, 0.0)),
        signature=(
            Signature("punch_force", 1, 0.0, "the same few per cent at every displacement"),
            Signature("free_edge", 0, 0.0, "none: all stresses scale alike"),
            Signature("strain_field", 0, 0.0, "none"),
        ),
        confused_with=("geometry", "load cell gain"),
        separate="Test at a tenth and at ten times the speed.",
        literature="Nylon and polyester yarns, 3 to 10 % per decade: Morton and Hearle, Physical Properties of Textile "
        "Fibres (2008), chapter on rheology.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with all fabric laws scaled to the rate of its motion; BadInput where nothing is left."""
        factor = 1.0 + self.per_decade * log10(strain_rate(model) / COUPON_RATE)
        if factor <= 0.0:
            message = (
                f"the strain rate {strain_rate(model):.3g} 1/s is so far from the coupons' {COUPON_RATE:g} 1/s that"
            )
            raise BadInput.of(f"{message} {self.per_decade:g} per decade leaves no stress", key="per_decade")
        return with_laws(model, FABRIC, lambda law: law.scaled(factor))
