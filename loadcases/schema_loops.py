"""Clearance loops of the case file: at regular intervals."""

from __future__ import annotations

from pydantic import Field, model_validator

from loadcases.conflicts import Conflict, refuse
from loadcases.schema_numbers import Length, LoopLength, NonNegativeLength, PositiveLength, Share, Strict


class Loops(Strict):
    """Clearance loops, where the wire leaves the weave and spans freely."""

    spacing: PositiveLength = Field(
        default=20.0,
        description="Distance from loop centre to loop centre along the wire, mm.",
        json_schema_extra={"origin": "estimated: the paper says regular intervals"},
    )
    length: LoopLength = Field(
        default=4.0,
        description="Length of fabric that a loop spans, mm.",
        json_schema_extra={"origin": "estimated: the paper says some millimetres"},
    )
    slack: Share = Field(
        default=0.02,
        description="Excess length of the wire in the loop, as a share of the span.",
        json_schema_extra={"origin": "estimated"},
    )
    offset: Length = Field(
        default=0.0,
        description="Distance of the reference loop from the specimen centre, mm.",
        json_schema_extra={"origin": "estimated: the paper does not say where loops lie"},
    )
    component: NonNegativeLength = Field(
        default=0.0,
        description="Length of a rigid component in the middle of each loop, mm; 0 for an empty loop.",
        json_schema_extra={"origin": "stated: the paper's clearances were empty, without components"},
    )

    @model_validator(mode="after")
    def _fits(self) -> Loops:
        found = []
        if not self.length < self.spacing:
            message = f"the loops overlap (got {self.length:g} mm), must be below spacing, which is {self.spacing:g} mm"
            found.append(Conflict(message, (("length",), ("spacing",))))
        if not self.component < self.length:
            message = (
                f"the component fills its loop (got {self.component:g} mm), must be below length, "
                f"which is {self.length:g} mm"
            )
            found.append(Conflict(message, (("component",), ("length",))))
        refuse(found)
        return self
