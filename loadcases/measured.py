"""Material numbers in files: plain, or with standard deviation and where they come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from etextile.errors import nearest
from etextile.units import shorten, to_number
from loadcases.schema_numbers import Quantity, Strict


KEYS = ("value", "std", "source", "estimated")


class Measured(Strict):
    """A number with its standard deviation (if known) and its origin."""

    value: float = Field(description="The number itself.")
    std: float | None = Field(default=None, description="Standard deviation, in the unit of the value.")
    source: str | None = Field(default=None, description="Where the number comes from.")
    estimated: bool = Field(default=False, description="True for a number without a source.")


@dataclass(frozen=True)
class Stated:
    """Annotation of a `Measured` in the unit and bounds of `quantity`; `origin` demands source or estimated: true."""

    quantity: Quantity
    origin: bool = False

    def read(self, value: Any) -> Measured:
        """Read a plain number or {value, std, source, estimated}; raises ValueError that says what is allowed."""
        if isinstance(value, Measured):
            return value
        item = value if isinstance(value, Mapping) else {"value": value}
        for key in item:
            if key not in KEYS:
                raise ValueError(f"unknown key {key!r} in it, allowed are {', '.join(KEYS)}{nearest(str(key), KEYS)}")
        if "value" not in item:
            raise ValueError(f"the number is missing (got {shorten(value)}), write {{value: ..., std: ...}}")
        return self._checked(item)

    def _checked(self, item: Mapping[str, Any]) -> Measured:
        """Check the parts of {value, std, source, estimated}."""
        std, source, estimated = item.get("std"), item.get("source"), item.get("estimated", False)
        number = self.quantity.read(item["value"])
        spread = None if std is None else to_number(std, self.quantity.unit)
        if spread is not None and spread < 0.0:
            raise ValueError(f"negative standard deviation (got {shorten(std)}), must be at least 0")
        if not isinstance(estimated, bool) or not (source is None or isinstance(source, str)):
            raise ValueError(f"wrong origin (got {shorten(dict(item))}), write source: text or estimated: true")
        if self.origin and bool(source) == estimated:
            raise ValueError(
                f"no clear origin (got {shorten(item['value'])}), give either source: text or estimated: true"
            )
        return Measured(value=number, std=spread, source=source, estimated=estimated)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Validate through `read`."""
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Return `number, text with a unit, or mapping` for editors."""
        number = self.quantity.__get_pydantic_json_schema__(schema, handler)
        mapping = {
            "type": "object",
            "properties": {
                "value": number,
                "std": {"anyOf": [{"type": "number", "minimum": 0}, {"type": "string"}, {"type": "null"}]},
                "source": {"type": ["string", "null"]},
                "estimated": {"type": "boolean"},
            },
            "required": ["value"],
            "additionalProperties": False,
        }
        return {"anyOf": [*number["anyOf"], mapping], "unit": number["unit"]}
