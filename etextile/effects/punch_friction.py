"""Coulomb friction between body and fabric, more than the case has.

Fabric that slides down a smooth body spreads its stretch over the whole length; friction holds it at the apex and the
tension has to rise towards the clamp, so the largest strain moves from the apex to the rim of the contact.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.change import with_contact
from etextile.mechanics.model import Model


@dataclass(frozen=True)
class PunchFriction(Effect):
    """Coefficient of friction that is added to the case's."""

    mu: float = 0.0

    stage: ClassVar[Stage] = Stage.BODY
    card: ClassVar[Card] = Card(
        id="punch_friction",
        mechanism="Coulomb friction between punch and fabric.",
        parameters=(
            Parameter("mu", "", 0.0, 1.0, "the coefficient of friction beyond that of the case", limits=(0.0, 2.0)),
        ),
        example=Example({"mu": 0.3}, (0.1, 1.3, 2.2, 3.1, 6.0), (0.01, 0.06, 0.13, 0.2, 0.38)),
        signature=(
            Signature("punch_force", 1, 15.0, "a few per cent that grow with the wrapped area"),
            Signature("strain_field", 0, 20.0, "the peak moves from the apex to the rim of the contact"),
        ),
        confused_with=("crimp_interchange",),
        separate="The strain field over the punch, or a second test with a lubricated punch.",
        literature="Capstan equation; coefficients of 0.1 to 0.4 for fabrics on metal: Gupta (ed.), Friction in "
        "Textile Materials (2008).",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with more friction; BadInput without a body."""
        return with_contact(model, self.card.id, lambda contact: replace(contact, friction=contact.friction + self.mu))
