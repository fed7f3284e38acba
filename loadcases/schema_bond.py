"""How wires are held in the weave or on the fabric."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from loadcases.schema_numbers import NonNegativeLineForce, Quantity, Strict


class Slipping(Strict):
    """A wire that slides along its channel against friction."""

    line_friction: NonNegativeLineForce = Field(
        description="Friction force per length of channel, N/mm (wires of 30 um filaments: 0.01 slides far, 1 sticks)."
    )
    tension_factor: Annotated[float, Quantity(at_least=0.0, at_most=1e3)] = Field(
        default=0.0,
        description="Further friction per tension of the weft: N/mm per N/mm.",
        json_schema_extra={"origin": "estimated: none, until measured by pulling a wire out under weft tension"},
    )


def _bond_kind(value: Any) -> str:
    """Tell the two forms of `bond` apart."""
    return "slipping" if isinstance(value, (dict, Slipping)) else "perfect"


Bond = Annotated[
    Annotated[Literal["perfect"], Tag("perfect")] | Annotated[Slipping, Tag("slipping")], Discriminator(_bond_kind)
]
