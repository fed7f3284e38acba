"""The wires section of the case file: wires, their loops, their bond and the nets they carry."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from etextile.units import shorten
from loadcases.conflicts import Conflict, refuse
from loadcases.schema_numbers import (
    Count,
    CountOrZero,
    Length,
    NonNegativeLength,
    NonNegativeLineForce,
    PositiveLength,
    Quantity,
    Share,
    Strict,
)


class Loops(Strict):
    """Clearance loops, where the wire leaves the weave and spans freely."""

    spacing: PositiveLength = Field(
        default=20.0,
        description="Distance from loop centre to loop centre along the wire, mm.",
        json_schema_extra={"origin": "estimated: the paper says regular intervals"},
    )
    length: PositiveLength = Field(
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


class Slipping(Strict):
    """A wire that slides along its channel against friction."""

    line_friction: NonNegativeLineForce = Field(
        description="Friction force per length of channel, N/mm (wires of 30 um filaments: 0.01 slides far, 1 sticks)."
    )
    tension_factor: Annotated[float, Quantity(at_least=0.0)] = Field(
        default=0.0,
        description="Further friction per tension of the weft: N/mm per N/mm.",
        json_schema_extra={"origin": "estimated: none, until measured by pulling a wire out under weft tension"},
    )


class Net(Strict):
    """An electrical connection along one wire, lost when a loop on it is interrupted."""

    name: str = Field(min_length=1, description="Name of the net in reports.")
    wire: CountOrZero = Field(description="Number of the wire, counted from -y.")
    from_loop: CountOrZero = Field(description="Loop in which the first component sits, counted from -x.")
    to_loop: CountOrZero = Field(description="Loop in which the other component sits.")


def _bond_kind(value: Any) -> str:
    """Tell the two forms of `bond` apart."""
    return "slipping" if isinstance(value, (dict, Slipping)) else "perfect"


Bond = Annotated[
    Annotated[Literal["perfect"], Tag("perfect")] | Annotated[Slipping, Tag("slipping")], Discriminator(_bond_kind)
]


class Wires(Strict):
    """Conductive wires in warp direction."""

    every_warp_yarns: Annotated[float, Quantity(at_least=1.0)] = Field(
        default=65.0,
        description="Warp yarns from wire to wire (65 is 5.91 mm in the estimated fabrics).",
        json_schema_extra={"origin": "stated: one wire per 65 warp yarns on average (Beex et al.)"},
    )
    first_offset: Length = Field(
        default=0.0,
        description="Distance of the reference wire from the centre line, mm.",
        json_schema_extra={"origin": "estimated: the paper does not say where wires lie"},
    )
    material: str = Field(
        default="copper_soft",
        min_length=1,
        description="Name of a shipped wire material or path of a file (list wires).",
        json_schema_extra={"origin": "estimated: the paper says copper; soft copper's elongation fits its onset"},
    )
    filaments: Count = Field(
        default=7,
        description="Filaments twisted into one wire.",
        json_schema_extra={"origin": "estimated: six filaments twisted about one"},
    )
    filament_diameter: PositiveLength = Field(
        default=0.03,
        description="Diameter of one filament, mm.",
        json_schema_extra={"origin": "estimated: as the thinnest drawn copper wire with published strength, 30 um"},
    )
    crimp: Share = Field(
        default=0.02,
        description="Excess length of the wire in the weave, as a strain.",
        json_schema_extra={"origin": "estimated"},
    )
    loops: Loops | None = Field(default=Loops(), description="Clearance loops; null for none.")
    bond: Bond = Field(
        default="perfect",
        description="perfect, or a line friction against which the wire slides.",
        json_schema_extra={"origin": "estimated: no friction of a wire in this weave is known"},
    )
    nets: tuple[Net, ...] = Field(default=(), description="Connections whose loss is reported.")

    @model_validator(mode="after")
    def _nets_differ(self) -> Wires:
        names = [net.name for net in self.nets]
        twice = sorted({name for name in names if names.count(name) > 1})
        refuse([Conflict(f"a net is named twice (got {shorten(twice[0])})", (("nets",),))] if twice else [])
        return self
