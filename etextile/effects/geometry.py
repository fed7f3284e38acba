"""The punch is a little larger or smaller than the case says, or stands beside the centre.

A larger punch bends the fabric over a wider cap and shortens the free span; off centre it loads the nearer clamp more,
which shows as asymmetry. Size changes by a parallel surface (exact for spheres, capsules); the body still starts just
touching the flat fabric.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from etextile.contact.contact import Contact
from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.effects.bodies import grown, shifted
from etextile.effects.change import with_contact
from etextile.errors import BadInput, Problem
from etextile.mechanics.model import Model


@dataclass(frozen=True)
class Geometry(Effect):
    """Change of the punch radius and of its place along x and y, mm."""

    radius: float = 0.0
    x: float = 0.0
    y: float = 0.0

    stage: ClassVar[Stage] = Stage.BODY
    card: ClassVar[Card] = Card(
        id="geometry",
        mechanism="Punch radius or centre differs from the case.",
        parameters=(
            Parameter(
                "radius",
                "mm",
                -2.0,
                2.0,
                "the radius of the punch less that of the case",
                default=0.0,
                limits=(-12.0, 30.0),
            ),
            Parameter("x", "mm", -5.0, 5.0, "the place of the punch off the case's, along the specimen", default=0.0),
            Parameter("y", "mm", -5.0, 5.0, "the place of the punch off the case's, across the specimen", default=0.0),
        ),
        example=Example({"radius": 0.5, "x": 0.0, "y": 0.0}, (1.5, 1.6, 1.7, 1.6, 1.8), (0.0, 0.0, -0.02, -0.01, 0.0)),
        signature=(
            Signature("punch_force", 1, 0.0, "a nearly constant few per cent"),
            Signature("free_edge", 0, 0.0, "an off-centre punch draws the two edges, or their two halves, in unlike"),
        ),
        confused_with=("rate_dependence",),
        separate="Gauge the punch; compare left and right halves of the free edge and of the strain field.",
        literature="Punch of 30 mm diameter, stated without tolerance: Beex et al., section 5.",
        limits="Off-centre needs a model of the whole specimen (or a half, along its own axis).",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with the other body; BadInput without a body or off the plane of symmetry of a part."""
        problems = [
            Problem(f"{name} off a symmetry plane (got {value:g} mm), set fabric.portion to whole", key=name)
            for name, value, cut in zip("xy", (self.x, self.y), model.lattice.symmetry, strict=True)
            if cut and value != 0.0
        ]
        if problems:
            raise BadInput(problems)
        return with_contact(model, self.card.id, self._changed)

    def _changed(self, contact: Contact) -> Contact:
        contact = grown(contact, self.radius) if self.radius != 0.0 else contact
        return shifted(contact, np.array([self.x, self.y, 0.0]))
