"""Numbers of the case file: what each accepts (unit, bounds), how it is refused, and how it looks in JSON Schema."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from etextile.units import shorten, to_number


MOST = 1_000_000
"""Largest whole number where no other bound is given."""
MOST_STEPS = 100_000
"""Most points on the path of a motion."""


class Strict(BaseModel):
    """Base of all sections: unknown keys are errors, values cannot be changed after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def _known_version(value: Any) -> Any:
    """Refuse a format that this program does not read, newer ones by name."""
    if isinstance(value, bool) or value != 1:
        newer = isinstance(value, (int, float)) and value > 1
        wrong = "this format is newer than the program" if newer else "not a known format version"
        remedy = "update etextile, this one reads version 1" if newer else "write 1"
        raise ValueError(f"{wrong} (got {shorten(value)}), {remedy}")
    return 1


Version = Annotated[
    Literal[1], BeforeValidator(_known_version), Field(description="Version of this file format, write 1.")
]


@dataclass(frozen=True)
class Quantity:
    """Annotation of a float in `unit` that may be written as text with a unit; bounds are part of it."""

    unit: str = ""
    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    below: float | None = None

    def read(self, value: Any) -> float:
        """Convert and check one value; raises ValueError that says what is allowed."""
        number = to_number(value, self.unit)
        if (
            (self.above is not None and not number > self.above)
            or (self.at_least is not None and not number >= self.at_least)
            or (self.at_most is not None and not number <= self.at_most)
            or (self.below is not None and not number < self.below)
        ):
            raise ValueError(f"out of range (got {shorten(value)}), must be {self.allowed()}")
        return number

    def allowed(self) -> str:
        """Say the bounds in words, with the unit."""
        unit = f" {self.unit}" if self.unit else ""
        bounds = (
            ("above", self.above), ("at least", self.at_least), ("at most", self.at_most), ("below", self.below)
        )  # fmt: skip
        return " and ".join(f"{word} {bound:g}{unit}" for word, bound in bounds if bound is not None)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Validate through `read`; pydantic keeps the plain float."""
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Return `number with bounds or text with a unit` for editors."""
        names = {
            "exclusiveMinimum": self.above,
            "minimum": self.at_least,
            "maximum": self.at_most,
            "exclusiveMaximum": self.below,
        }
        bounds = {name: bound for name, bound in names.items() if bound is not None}
        text = {"type": "string", "pattern": r"^\s*[+-]?(\d+\.?\d*|\.\d+)"}
        return {"anyOf": [{"type": "number", **bounds}, text], "unit": self.unit or "1"}


@dataclass(frozen=True)
class Whole:
    """Annotation of a whole number with bounds."""

    at_least: int = 0
    at_most: int = MOST

    def read(self, value: Any) -> int:
        """Accept 5 and 5.0, refuse 5.5, text and booleans; raises ValueError that says what is allowed."""
        if isinstance(value, bool) or not isinstance(value, (int, float)) or value != value or value % 1 != 0:
            raise ValueError(f"not a whole number (got {shorten(value)}), must be {self.at_least} or more")
        if value < self.at_least:
            raise ValueError(f"out of range (got {shorten(value)}), must be {self.at_least} or more")
        if value > self.at_most:
            raise ValueError(f"out of range (got {shorten(value)}), must be {self.at_most} or less")
        return int(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Validate through `read`."""
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Return a bounded integer."""
        return {"type": "integer", "minimum": self.at_least, "maximum": self.at_most}


Number = Annotated[float, Quantity()]
Share = Annotated[float, Quantity(at_least=0.0, at_most=1.0)]
NonNegative = Annotated[float, Quantity(at_least=0.0)]
Positive = Annotated[float, Quantity(above=0.0)]
Length = Annotated[float, Quantity("mm")]
PositiveLength = Annotated[float, Quantity("mm", above=0.0)]
NonNegativeLength = Annotated[float, Quantity("mm", at_least=0.0)]
Angle = Annotated[float, Quantity("deg", at_least=-360.0, at_most=360.0)]
PositiveStress = Annotated[float, Quantity("MPa", above=0.0)]
NonNegativeStress = Annotated[float, Quantity("MPa", at_least=0.0)]
PositiveSpeed = Annotated[float, Quantity("mm/s", at_least=1e-6, at_most=1e6)]
NonNegativeLineForce = Annotated[float, Quantity("N/mm", at_least=0.0, at_most=1e4)]
LoopLength = Annotated[float, Quantity("mm", at_least=0.01)]
FilamentDiameter = Annotated[float, Quantity("mm", at_least=1e-3, at_most=5.0)]
Count = Annotated[int, Whole(1)]
Steps = Annotated[int, Whole(1, MOST_STEPS)]
Filaments = Annotated[int, Whole(1, 10_000)]
CountOrZero = Annotated[int, Whole(0)]
