"""Wires of the case file that are drawn one by one: their lines, their loops, the parts and the nets."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Discriminator, Field, Tag, create_model, model_validator

from loadcases.conflicts import Conflict, refuse
from loadcases.schema_bond import Bond
from loadcases.schema_loops import Loops
from loadcases.schema_numbers import (
    CountOrZero,
    FilamentDiameter,
    Filaments,
    Length,
    LoopLength,
    NonNegativeLength,
    PositiveLength,
    Share,
    Strict,
)


Place = tuple[Length, Length]


def _spot_kind(value: Any) -> str:
    return "place" if isinstance(value, (list, tuple)) else "along"


class LoopAt(Strict):
    """A clearance loop where a designer puts it; a bare number or place stands for `at`."""

    at: Annotated[Annotated[Length, Tag("along")] | Annotated[Place, Tag("place")], Discriminator(_spot_kind)] = Field(
        description="Centre: coordinate along the wire, mm (of a laid wire the length from its start), or [warp, weft]."
    )
    length: LoopLength = Field(default=4.0, description="Length of fabric that the loop spans, mm.")
    slack: Share = Field(default=0.02, description="Excess length of the wire in the loop, as a share of the span.")
    component: NonNegativeLength = Field(default=0.0, description="Length of a part in its middle that is rigid, mm.")


def _as_loop(value: Any) -> Any:
    return value if isinstance(value, (dict, LoopAt)) else {"at": value}


def _loops_kind(value: Any) -> str:
    return "regular" if isinstance(value, (dict, Loops)) else "listed"


PathLoops = Annotated[
    Annotated[Loops, Tag("regular")]
    | Annotated[tuple[Annotated[LoopAt, BeforeValidator(_as_loop)], ...], Tag("listed")],
    Discriminator(_loops_kind),
]

_Extent: Any = create_model(
    "_Extent",
    __base__=Strict,
    **{  # `from` is a word of the language, so it cannot be written as a field
        "from": (
            Length | None,
            Field(default=None, description="Where a straight wire begins, mm; null: at the edge."),
        ),
        "to": (Length | None, Field(default=None, description="Where a straight wire ends, mm; null: at the edge.")),
    },  # type: ignore[call-overload]
)


class WirePath(_Extent):  # type: ignore[misc]
    """One wire: woven straight along warp or weft, or laid along a line; null keys are those of the section."""

    name: str = Field(min_length=1, description="Name of the wire in nets, maps and reports.")
    along: Literal["warp", "weft"] | None = Field(default=None, description="Yarns that a woven wire follows.")
    at: Length | None = Field(default=None, description="Place of a woven wire across these yarns, mm from the centre.")
    path: tuple[Place, ...] | None = Field(
        default=None, description="Vertices [warp, weft] of a laid (stitched) wire, mm from the centre of the specimen."
    )
    material: str | None = Field(default=None, min_length=1, description="Wire material.")
    filaments: Filaments | None = Field(default=None, description="Filaments twisted into the wire.")
    filament_diameter: FilamentDiameter | None = Field(default=None, description="Diameter of one filament, mm.")
    crimp: Share | None = Field(default=None, description="Excess length of the wire in the weave or between stitches.")
    bond: Bond | None = Field(
        default=None, description="Hold by the weave or the stitches: perfect or a line friction."
    )
    loops: PathLoops | None = Field(default=None, description="Loops: a list, or regular ones; null for none.")

    @property
    def extent(self) -> tuple[float | None, float | None]:
        """Where a straight wire begins and ends; None at the edge of the piece."""
        return getattr(self, "from"), self.to

    @model_validator(mode="after")
    def _one_line(self) -> WirePath:
        found = []
        if self.path is not None and (self.along is not None or self.at is not None or self.extent != (None, None)):
            found.append(Conflict("a laid wire has its vertices, leave out along, at, from and to", (("path",),)))
        if (self.along is None) != (self.at is None):
            found.append(Conflict("a woven wire needs both along and at", (("along" if self.at is None else "at",),)))
        if self.along is None and self.extent != (None, None):
            found.append(Conflict("only a woven wire has from and to, give along and at", (("from",),)))
        start, end = self.extent
        if start is not None and end is not None and not start < end:
            found.append(
                Conflict(f"the wire has no length (from {start:g} to {end:g} mm), from must be below to", (("to",),))
            )
        refuse(found)
        return self


class Component(Strict):
    """A part that sits on the fabric as a rigid land and connects wires."""

    name: str = Field(min_length=1, description="Name of the part in nets, maps and reports.")
    at: Place | None = Field(default=None, description="Centre [warp, weft], mm; null: where the drawing has it.")
    size: tuple[PositiveLength, PositiveLength] = Field(
        default=(3.0, 3.0), description="Extent of its land along warp and weft, mm."
    )
    interposer: tuple[PositiveLength, PositiveLength] | None = Field(
        default=None, description="Extent of a carrier under the part, which is the land then, mm; null for none."
    )
    connects: tuple[str, ...] = Field(default=(), description="Wires it is connected to.")
    rigid: bool = Field(
        default=True, description="Whether the land holds the fabric under it; false: it hangs in loops."
    )


class Net(Strict):
    """A connection, lost when what it runs over is interrupted: loops of one wire, or wires and parts by name."""

    name: str = Field(min_length=1, description="Name of the net in reports.")
    wire: CountOrZero | None = Field(default=None, description="Number of the wire, counted from -y.")
    from_loop: CountOrZero | None = Field(default=None, description="Loop of the first component, counted from -x.")
    to_loop: CountOrZero | None = Field(default=None, description="Loop in which the other component sits.")
    wires: tuple[str, ...] = Field(default=(), description="Wires the net runs over, by name.")
    parts: tuple[str, ...] = Field(default=(), description="Parts it connects, the source first.")

    @model_validator(mode="after")
    def _one_form(self) -> Net:
        numbered = (self.wire, self.from_loop, self.to_loop)
        if self.wires or self.parts:
            wrong = any(item is not None for item in numbered) or not self.wires or len(self.parts) < 2
            text = "a net by name needs wires and two or more parts, and no numbers of wires and loops"
        else:
            wrong = any(item is None for item in numbered)
            text = "give wire, from_loop and to_loop, or wires and parts"
        refuse([Conflict(text, (("name",),))] if wrong else [])
        return self
