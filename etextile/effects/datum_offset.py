"""The recorded displacement starts before or after the punch touches the fabric.

With an offset o the body stands o below the flat fabric when the record starts, so its true travel is the recorded
displacement minus o. A negative offset means that the record starts after contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.bodies import shifted
from etextile.effects.change import with_contact
from etextile.mechanics.model import Model


@dataclass(frozen=True)
class DatumOffset(Effect):
    """Recorded displacement at which the body really touches, mm."""

    offset: float = 0.0

    stage: ClassVar[Stage] = Stage.BODY
    card: ClassVar[Card] = Card(
        id="datum_offset",
        mechanism="The recorded displacement starts before (or after) contact.",
        parameters=(
            Parameter(
                "offset", "mm", -3.0, 3.0, "the recorded displacement at which contact begins", limits=(-15.0, 15.0)
            ),
        ),
        example=Example({"offset": 1.0}, (-34.0, -17.9, -13.7, -10.7, -6.8), (-0.29, -0.36, -0.32, -0.29, -0.22)),
        signature=(
            Signature("punch_force", -1, 0.0, "the whole curve shifts: a large share early, a small one late"),
            Signature("free_edge", -1, 0.0, "shifts alike: all channels lag by the same displacement"),
            Signature("strain_field", -1, 0.0, "shifts alike"),
        ),
        confused_with=("pretension", "clamp_compliance"),
        separate="Plot the other channels over the force instead of the displacement: with a pure offset they agree.",
        literature="Zero-point correction of indentation tests, as in ISO 14577-1, section 7.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with the body moved back along its way; BadInput without a body."""
        return with_contact(model, self.card.id, lambda contact: shifted(contact, -self.offset * contact.direction))
