"""Sections of the case file other than the body: fabric, wires, supports, motion, contact, failure, solver, outputs."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from etextile.units import shorten, to_number
from loadcases.compression import Compression
from loadcases.conflicts import Conflict, refuse
from loadcases.schema_life import Cyclic
from loadcases.schema_numbers import (
    Angle,
    Count,
    CountOrZero,
    NonNegativeLength,
    PositiveLength,
    PositiveSpeed,
    Quantity,
    Steps,
    Strict,
)
from loadcases.schema_outline import Outline, with_size


Edge = Literal["x_min", "x_max", "y_min", "y_max", "outline"]
EDGES: tuple[str, ...] = ("x_min", "x_max", "y_min", "y_max")
MapName = Literal["failure", "warp_strain", "weft_strain", "diagonal_strain", "wire_strain"]


class FabricPiece(Strict):
    """The piece of fabric and how finely its lattice is laid out."""

    set: str = Field(
        default="estimated_mid",
        min_length=1,
        description="Name of a shipped fabric or path of a fabric file (list fabrics).",
    )
    coarsening: Annotated[float, Quantity(at_least=1.0)] = Field(
        default=19.5, description="Fabric cells per lattice cell along warp and along weft; 1 is yarn resolution."
    )
    shape: Literal["flat", "tube", "panel"] = Field(
        default="flat", description="flat, or worn on a limb: a tube around it, or a panel on its outer side."
    )
    size: tuple[PositiveLength, PositiveLength | None] = Field(
        description="Free size [length along x, width along y] of the whole specimen, mm."
    )
    ease: Annotated[float, Quantity(at_least=-0.4, at_most=0.5)] | None = Field(
        default=None,
        description=(
            "Of a tube: girth of the fabric over that of the limb, less 1 (negative: tight), with null for the width "
            "in size; null where the width is given."
        ),
    )
    outline: Outline | None = Field(
        default=None,
        description="A circle or a convex polygon instead of the rectangle, clamped all round.",
    )
    portion: Literal["quarter", "half", "whole"] = Field(
        default="whole",
        description=(
            "Part that is modelled: quarter keeps x >= 0 and y >= 0, half keeps x >= 0 (worn: one side of the plane "
            "in which the joint bends)."
        ),
    )
    warp_angle: Angle = Field(default=0.0, description="Angle from the specimen's x axis to the warp, deg.")
    compression_ratio: Compression = Field(
        default=0.0,
        description=(
            "Force of compressed trusses as a share of that in tension at the same strain (0: they buckle), for all or "
            "as {warp, weft, diagonal}; a larger ratio in the fabric file counts."
        ),
    )

    @model_validator(mode="before")
    @classmethod
    def _size_of_outline(cls, data: Any) -> Any:
        return with_size(data)

    @model_validator(mode="after")
    def _one_size(self) -> FabricPiece:
        if (
            self.outline is not None
            and max(abs((a or 0.0) - b) for a, b in zip(self.size, self.outline.extent, strict=True)) > 1e-6
        ):
            size, own = (
                " x ".join(f"{length or 0.0:g}" for length in item) for item in (self.size, self.outline.extent)
            )
            message = f"the outline measures {own} mm (size is {size}), leave the size away"
            refuse([Conflict(message, (("size",), ("outline",)))])
        return self


End = Literal["held", "band", "free"]


class Band(Strict):
    """An elastic band in the end of a worn piece, on skin that it may slip on."""

    stiffness: Annotated[float, Quantity("N", above=0.0, at_most=1e6)] = Field(
        default=15.0,
        description="Force of the band per strain, N.",
        json_schema_extra={"origin": "estimated: a knitted elastic of 25 mm that takes 6 N at 40 %"},
    )
    tension: Annotated[float, Quantity("N", above=0.0, at_most=1e6)] = Field(
        default=3.0,
        description="Tension of the band around the straight limb, N.",
        json_schema_extra={"origin": "estimated: 3 kPa under a band of 25 mm on a radius of 40 mm"},
    )
    skin_friction: Annotated[float, Quantity(at_least=0.0, at_most=10.0)] = Field(
        default=0.5,
        description="Coulomb coefficient of the band on skin.",
        json_schema_extra={"origin": "estimated: textile on dry skin 0.3 to 0.6, silicone dots more"},
    )


class Supports(Strict):
    """Edges of the specimen that are held."""

    clamped: tuple[Edge, ...] = Field(
        default=("x_min", "x_max"),
        min_length=1,
        description="Clamped edges of a flat piece, the others are free; [outline] clamps all round, also a rectangle.",
    )
    ends: tuple[End, End] = Field(
        default=("held", "held"),
        description="Upper and lower end of a worn piece: held (goes with the limb), band (may slip) or free.",
    )
    sides: Literal["free", "held"] = Field(
        default="free", description="Side edges of a panel: free, or held on the skin (sewn onto a tight garment)."
    )
    band: Band = Field(default=Band(), description="The elastic band of ends that have one.")

    @field_validator("clamped")
    @classmethod
    def _once(cls, value: tuple[Edge, ...]) -> tuple[Edge, ...]:
        if len(set(value)) < len(value):
            raise ValueError(f"an edge is named twice (got {shorten(list(value))}), name each edge once")
        if "outline" in value and len(value) > 1:
            raise ValueError(f"the outline is all edges (got {shorten(list(value))}), write [outline] alone")
        return value

    @property
    def edges(self) -> tuple[Edge, ...]:
        """The clamped edges; the outline of a rectangle is its four."""
        return ("x_min", "x_max", "y_min", "y_max", "outline") if "outline" in self.clamped else self.clamped


LOADS = {"pressure": "bar", "weight": "g/m**2"}
"""Units of total and path of the motions that raise a load."""
UNITS = {**LOADS, "joint": "deg"}
"""Units of motions that are no displacements."""


def with_loads(data: Any) -> Any:
    """Return the section `motion` with total and path of a load or joint as plain numbers in its unit."""
    unit = UNITS.get(str(data.get("target"))) if isinstance(data, dict) else None
    if unit is None:
        return data

    def read(value: Any) -> Any:
        try:
            return to_number(value, unit)
        except ValueError:
            return value if isinstance(value, str) and value.strip()[-1:].isdigit() else f"{value} (expected {unit})"

    data = dict(data)
    for key in ("total", "path"):
        value = data.get(key)
        if isinstance(value, str):
            data[key] = read(value)
        elif isinstance(value, list | tuple):
            data[key] = [read(item) if isinstance(item, str) else item for item in value]
    return data


class Motion(Strict):
    """What moves, how far and in how many increments."""

    total: PositiveLength | None = Field(
        default=None, description="Largest displacement, mm, or largest load: bar for pressure, g/m2 for weight."
    )
    flexion: Annotated[float, Quantity("deg", at_least=0.01, at_most=160.0)] | None = Field(
        default=None, description="Largest flexion of a joint, deg."
    )
    steps: Steps = Field(description="Output increments, equally spaced over total or flexion.")
    speed: PositiveSpeed = Field(default=1.0, description="Speed of the motion, mm/s.")
    target: Literal["body", "x_min", "x_max", "y_min", "y_max", "pressure", "weight", "joint"] = Field(
        default="body",
        description="body pushes up; an edge name pulls that clamp outwards; pressure inflates a piece that is clamped "
        "all round; weight lets the fabric hang by its own; joint bends a limb inside of a worn piece.",
    )
    path: tuple[NonNegativeLength, ...] | None = Field(
        default=None,
        min_length=1,
        description="Displacements (mm) or angles (deg) visited in turn (load, unload, ...); null goes to the largest.",
    )
    history: str | None = Field(
        default=None,
        min_length=1,
        description="Measured motion whose turning points become the path: a CSV with time_s and angle_deg (joint), "
        "displacement_mm or pressure_bar, or a shipped arc (list arcs). Its largest value replaces total or flexion.",
    )
    swing: Annotated[float, Quantity(above=0.0, below=1.0)] = Field(
        default=0.1, description="Swings of a history below this share of its range are left out."
    )
    path_from: str | None = Field(
        default=None, description="Where the path comes from; written when a history is read."
    )
    diaphragm: str | None = Field(
        default=None,
        min_length=1,
        description="Pressure of a burst tester's diaphragm alone over its height: a CSV of pressure_bar,height_mm. "
        "The report adds what the gauge shows with it; nothing else changes.",
    )
    diaphragm_curve: tuple[tuple[NonNegativeLength, Annotated[float, Quantity("bar", at_least=0.0)]], ...] | None = (
        Field(
            default=None,
            min_length=2,
            description="The same as points [height mm, pressure bar]; written when a file is read.",
        )
    )
    settled: Annotated[float, Quantity(at_least=0.0, at_most=0.1)] = Field(
        default=1e-4,
        description="A path of many cycles ends when plastic strain grows by less than this in each of two cycles in "
        "turn; what is left of it is taken from the settled cycles. 0 runs all of it.",
    )

    @model_validator(mode="before")
    @classmethod
    def _loads(cls, data: Any) -> Any:
        return with_loads(data)

    @property
    def unit(self) -> str:
        """Unit of total, flexion and path."""
        return UNITS.get(self.target, "mm")

    @property
    def reach(self) -> float:
        """Largest displacement, load or flexion."""
        reach: float | None = self.flexion if self.target == "joint" else self.total
        return reach or 0.0

    def straight(self, reach: float, steps: int, path: tuple[float, ...] | None = None) -> dict[str, Any]:
        """Return what is other in a motion that goes to `reach` (over the stations of a path) in so many steps."""
        return {"flexion" if self.target == "joint" else "total": reach, "steps": steps, "path": path, "history": None}

    @property
    def travel(self) -> float:
        """Length of the whole motion, there and back, mm or deg."""
        stations = (0.0, *(self.path or (self.reach,)))
        return sum(abs(after - before) for before, after in pairwise(stations))

    @model_validator(mode="after")
    def _path_reaches_total(self) -> Motion:
        key, other = ("flexion", "total") if self.target == "joint" else ("total", "flexion")
        rubber = "diaphragm" if self.diaphragm is not None else "diaphragm_curve"
        if self.diaphragm is not None and self.diaphragm_curve is not None:
            refuse([Conflict("a file and points are two diaphragms, keep one", (("diaphragm",), ("diaphragm_curve",)))])
        if getattr(self, rubber) is not None and self.target != "pressure":
            refuse([Conflict(f"a diaphragm is inflated, not {self.target}", ((rubber,), ("target",)))])
        if self.history is not None and self.path is not None:
            refuse([Conflict("a path and a history are two motions, keep one of them", (("history",), ("path",)))])
        if getattr(self, key) is None and self.history is None:
            expected = (type(self).model_fields[key].description or "").rstrip(".")
            refuse([Conflict(f"this key is missing, expected: {expected}", ((key,), ("target",)))])
        if getattr(self, other) is not None:
            refuse([Conflict(f"does not go with the target {self.target}, give {key} instead", ((other,),))])
        path, reach = self.path, self.reach
        if path is not None and abs(max(path) - reach) > 1e-9 * reach:
            message = f"the path reaches {max(path):g} {self.unit} but {key} is {reach:g} {self.unit}, make them equal"
            refuse([Conflict(message, (("path",), (key,)))])
        if path is not None and any(after == before for before, after in pairwise((0.0, *path))):
            message = f"the path stands still (got {shorten(list(path))}), each entry must differ from the one before"
            refuse([Conflict(message, (("path",),))])
        return self


MOST_FRICTION = 10.0
"""Largest coefficient of friction; beyond it the fabric sticks."""


def _friction(value: Any) -> float | Literal["stick"]:
    """Read the friction: `stick`, or a coefficient of 0 or more."""
    if value == "stick":
        return "stick"
    try:
        number = to_number(value, "")
    except ValueError:
        number = -1.0
    if not 0.0 <= number <= MOST_FRICTION:
        allowed = f"0, a positive coefficient up to {MOST_FRICTION:g} or 'stick'"
        raise ValueError(f"not a friction (got {shorten(value)}), must be {allowed}")
    return number


class Friction:
    """Annotation of a friction value: a coefficient of 0 or more, or 'stick'."""

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: Any) -> Any:
        """Validate through `_friction`."""
        from pydantic_core import core_schema

        return core_schema.no_info_plain_validator_function(_friction)

    @classmethod
    def __get_pydantic_json_schema__(cls, schema: Any, handler: Any) -> dict[str, Any]:
        """Return `number of 0 or more, or stick`."""
        return {"anyOf": [{"type": "number", "minimum": 0, "maximum": MOST_FRICTION}, {"const": "stick"}], "unit": "1"}


class Contact(Strict):
    """Contact of the body with the fabric."""

    friction: Annotated[float | Literal["stick"], Friction] = Field(
        default=0.0, description="Coulomb coefficient, 0 for frictionless, or stick."
    )
    max_penetration: Annotated[float, Quantity("mm", at_least=1e-6, at_most=1.0)] = Field(
        default=0.02, description="Trust limit of the penetration, mm."
    )
    stick_stiffness: Annotated[float, Quantity("N/mm**3", at_least=1e-3, at_most=1e6)] = Field(
        default=3.0,
        description="Shear stiffness of sticking contact, N/mm per mm2 of fabric (only with friction: stick).",
    )


class Effect(BaseModel):
    """An effect from the library (`etextile list effects`), with its own parameters beside `id`."""

    model_config = ConfigDict(extra="allow", frozen=True, allow_inf_nan=False)

    id: str = Field(min_length=1, description="Name of the effect.")

    @property
    def parameters(self) -> dict[str, Any]:
        """The effect's own keys as they were given."""
        return dict(self.model_extra or {})


class Failure(BaseModel):
    """When a loop fails; a criterion may have parameters of its own beside `onset`."""

    model_config = ConfigDict(extra="allow", frozen=True, allow_inf_nan=False)

    criterion: str = Field(default="calibrated", min_length=1, description="Name of the criterion (list criteria).")
    onset: Annotated[float, Quantity(at_least=1e-4, at_most=1.0)] = Field(
        default=0.07,
        description="Strain at which first filaments break: of the fabric in the coupons (calibrated, span_strain), or "
        "of the wire (wire_strain).",
    )
    file: str | None = Field(
        default=None, min_length=1, description="Python file that defines the criterion; null for a known one."
    )
    cyclic: Cyclic | None = Field(default=None, description="Strain-life law and required cycles; null for none.")

    @property
    def parameters(self) -> dict[str, Any]:
        """The onset and the criterion's further keys, as `wires.failure.evaluate` takes them."""
        return {"onset": self.onset, **(self.model_extra or {})}


class Solver(Strict):
    """Settings of the nonlinear solution; the defaults suit all shipped cases."""

    linear: str = Field(default="auto", min_length=1, description="Linear solver: auto, band, pardiso or superlu.")
    nonlinear: str = Field(default="newton", min_length=1, description="Nonlinear solver.")
    tolerance: Annotated[float, Quantity(above=0.0, below=1.0)] = Field(
        default=1e-6, description="Residual force at convergence, relative to the forces that act."
    )
    max_iterations: Count = Field(default=60, description="Newton iterations of one increment before it is cut.")
    max_cut_backs: CountOrZero = Field(default=8, description="How often an increment may be halved.")


class Outputs(Strict):
    """What is drawn beside the report."""

    maps: tuple[MapName, ...] = Field(
        default=("failure", "warp_strain", "wire_strain"), description="Maps rendered into the folder maps."
    )
