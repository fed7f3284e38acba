"""The outline of a piece that is no rectangle: a circle or a convex polygon in the specimen plane."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag, TypeAdapter, ValidationError, field_validator

from etextile.units import shorten
from loadcases.schema_numbers import Length, Quantity, Strict


Corner = tuple[Length, Length]


class CircleOutline(Strict):
    """A circle about the origin."""

    circle: Annotated[float, Quantity("mm", at_least=0.1)] = Field(
        description="Radius of a circle about the centre of the specimen, mm."
    )

    @property
    def extent(self) -> tuple[float, float]:
        """Size along x and y, mm."""
        return (2.0 * self.circle, 2.0 * self.circle)


class PolygonOutline(Strict):
    """A convex polygon around the origin."""

    polygon: tuple[Corner, ...] = Field(
        min_length=3, description="Corners [x, y] of a convex polygon around the origin, in turn, mm."
    )

    @field_validator("polygon")
    @classmethod
    def _convex(cls, value: tuple[Corner, ...]) -> tuple[Corner, ...]:
        """Return the corners counter-clockwise."""
        turns = [_turn(*corners) for corners in zip(value, value[1:] + value[:1], value[2:] + value[:2], strict=True)]
        if not (all(turn > 0.0 for turn in turns) or all(turn < 0.0 for turn in turns)):
            raise ValueError(f"not a convex polygon with corners in turn (got {shorten(list(map(list, value)))})")
        corners = value if turns[0] > 0.0 else value[::-1]
        if any(_turn((0.0, 0.0), a, b) <= 0.0 for a, b in zip(corners, corners[1:] + corners[:1], strict=True)):
            raise ValueError(
                f"the origin does not lie inside (got {shorten(list(map(list, value)))}), shift the polygon"
            )
        return corners

    @property
    def extent(self) -> tuple[float, float]:
        """Size of the box about the origin that holds the polygon, mm."""
        x, y = (2.0 * max(abs(corner[axis]) for corner in self.polygon) for axis in (0, 1))
        return (x, y)


def _turn(a: Corner, b: Corner, c: Corner) -> float:
    """Return twice the signed area of a triangle."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _kind(value: Any) -> str:
    """Tell the two forms apart."""
    return (
        "polygon" if isinstance(value, PolygonOutline) or (isinstance(value, dict) and "polygon" in value) else "circle"
    )


Outline = Annotated[
    Annotated[CircleOutline, Tag("circle")] | Annotated[PolygonOutline, Tag("polygon")], Discriminator(_kind)
]


def with_size(data: Any) -> Any:
    """Return the section `fabric` with the size that its outline has, where it names none."""
    if not isinstance(data, dict) or data.get("size") is not None or data.get("outline") is None:
        return data
    try:
        outline = TypeAdapter(Outline).validate_python(data["outline"])
    except (ValidationError, TypeError, ValueError):
        return {**data, "size": (1.0, 1.0)}  # the outline itself is refused where it stands
    return {**data, "size": outline.extent}
