"""The section `scatter` of the case file: how much specimens, wires and mounting differ, read by `ensemble` alone.

All numbers are standard deviations of normal distributions cut off at three of them (strength, of its logarithm, at
five); 0 switches an input off.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from loadcases.schema_numbers import NonNegativeLength, Quantity, Share, Strict


AUTOMATIC = "null is {} on a whole specimen and none on a quarter or half; a number makes the specimen whole."


class Scatter(Strict):
    """Scatter from specimen to specimen, as standard deviations."""

    fabric: Annotated[float, Quantity(at_least=0.0, at_most=10.0)] = Field(
        default=1.0,
        description=(
            "Factor on the fabric's own scatter: the covariance in its file, else the span from low to high estimate."
        ),
        json_schema_extra={"origin": "derived: low and high estimate taken as two standard deviations from the middle"},
    )
    strength: Share = Field(
        default=0.05,
        description="Strain at which wires break, from specimen to specimen: standard deviation of its logarithm.",
        json_schema_extra={"origin": "estimated: between spools; loops of one specimen scatter by failure.scatter"},
    )
    loop_slack: Share = Field(
        default=0.25,
        description="Slack from loop to loop, as a share of it.",
        json_schema_extra={"origin": "estimated"},
    )
    mounting: Annotated[float, Quantity(at_least=0.0, at_most=0.01)] = Field(
        default=0.002,
        description="Strain at which the specimen sits in its clamps, taut or slack.",
        json_schema_extra={"origin": "estimated: 0.2 mm in 100 mm by hand"},
    )
    wire_offset: NonNegativeLength | None = Field(
        default=None,
        description=f"Shift of all wires across the specimen, mm; {AUTOMATIC.format('0.3 mm')}",
        json_schema_extra={"origin": "estimated: three warp yarns"},
    )
    loop_offset: NonNegativeLength | None = Field(
        default=None,
        description=f"Shift of all loops along their wires, mm; {AUTOMATIC.format('0.5 mm')}",
        json_schema_extra={"origin": "estimated"},
    )
    punch_position: NonNegativeLength | None = Field(
        default=None,
        description=f"Place of the body, along and across alike, mm; {AUTOMATIC.format('0.5 mm')}",
        json_schema_extra={"origin": "estimated: centring by hand"},
    )
    punch_angle: Annotated[float, Quantity("deg", at_least=0.0, at_most=15.0)] | None = Field(
        default=None,
        description=f"Rotation of the body about x, y and z alike, deg; {AUTOMATIC.format('1 deg')}",
        json_schema_extra={"origin": "estimated"},
    )


POSITIONAL = {"wire_offset": 0.3, "loop_offset": 0.5, "punch_position": 0.5, "punch_angle": 1.0}
"""What breaks the symmetry of a quarter or half, with the standard deviation that null stands for."""
