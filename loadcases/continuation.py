"""How a truss law may go on beyond the strain up to which it was identified: a low and a high continuation.

A coupon ends somewhere and a garment goes further. What yarns do there is not known: once crimp is used up they stiffen
towards their fibres, near their strength fibres slip and break and they soften (`effects/yarn_tail.py`). A fabric file
says how far the law may be off (`beyond`), and every run that passes the range says which verdicts hang on it.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from etextile.units import shorten, to_number
from loadcases.schema_numbers import Strict


TANGENT: Literal["tangent"] = "tangent"


class Slope:
    """Annotation of a slope of hardening: a multiple of the law's own, at least 0, or `tangent` for straight on."""

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Validate through `_slope`."""
        return core_schema.no_info_plain_validator_function(_slope)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Return `number of 0 or more, or tangent`."""
        return {"anyOf": [{"type": "number", "minimum": 0}, {"const": TANGENT}], "unit": "1"}


def _slope(value: Any) -> float | Literal["tangent"]:
    """Read a slope."""
    if value == TANGENT:
        return TANGENT
    try:
        number = to_number(value, "")
    except ValueError:
        number = -1.0
    if number < 0.0:
        raise ValueError(f"not a slope (got {shorten(value)}), must be 0, a positive factor or 'tangent'")
    return number


class Continuation(Strict):
    """Slopes of hardening beyond the range: multiples of the law's (below 1 softening, above 1 stiffening), tangent."""

    low: Annotated[float | Literal["tangent"], Slope] = Field(
        default=0.5, description="Low continuation: slope over that of the law, or tangent."
    )
    high: Annotated[float | Literal["tangent"], Slope] = Field(
        default=2.0, description="High continuation: slope over that of the law, or tangent."
    )
