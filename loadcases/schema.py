"""The case file: the one frozen model everything else is built from (design rule: the case file is the simulation)."""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import Field, field_validator, model_validator

from etextile.units import shorten
from etextile.visible import visible
from loadcases.conflicts import Conflict, refuse
from loadcases.conflicts_outline import load_conflicts, outline_conflicts
from loadcases.conflicts_worn import not_worn_conflicts, worn_conflicts
from loadcases.schema_body import LIMBS, Body, Mesh, Placed
from loadcases.schema_numbers import Strict, Version
from loadcases.schema_parts import (
    Contact,
    Effect,
    FabricPiece,
    Failure,
    Motion,
    Outputs,
    Solver,
    Supports,
)
from loadcases.schema_scatter import Scatter
from loadcases.schema_wires import Wires


OPPOSITE = {"x_min": "x_max", "x_max": "x_min", "y_min": "y_max", "y_max": "y_min"}


class Case(Strict):
    """One simulation, complete, from the fabric to the pictures; `scatter` is read by ensembles alone."""

    schema_version: Version
    title: str = Field(min_length=1, description="One line that names the case in reports.")
    description: str = Field(default="", description="What the case shows, free text.")
    fabric: FabricPiece = Field(description="Fabric and the piece cut from it.")
    wires: Wires | None = Field(default=None, description="Conductive wires; null for none, {} for the defaults.")
    supports: Supports = Field(default=Supports(), description="Clamped edges.")
    body: Body | None = Field(default=None, description="Body pressed into the fabric from below; null for none.")
    motion: Motion = Field(description="What moves and how far.")
    contact: Contact = Field(default=Contact(), description="Contact of body and fabric.")
    effects: tuple[Effect, ...] = Field(default=(), description="Further mechanisms, applied in this order.")
    failure: Failure = Field(default=Failure(), description="Failure criterion of the loops.")
    scatter: Scatter = Field(default=Scatter(), description="Scatter between specimens, for ensembles.")
    solver: Solver = Field(default=Solver(), description="Solver settings.")
    outputs: Outputs = Field(default=Outputs(), description="Pictures to draw.")

    @field_validator("title")
    @classmethod
    def _one_line(cls, value: str) -> str:
        if "\n" in value.strip():
            raise ValueError(f"more than one line (got {shorten(value)}), put the rest into description")
        return visible(value.strip())

    @field_validator("description")
    @classmethod
    def _written(cls, value: str) -> str:
        return visible(value)

    @property
    def worn(self) -> bool:
        """Whether the piece is worn on a limb."""
        return self.fabric.shape != "flat"

    @property
    def pattern(self) -> tuple[float, float]:
        """Size (mm) of the piece as it lies flat, along x and y; of a worn one the width at the joint."""
        length, width = self.fabric.size
        if width is None and isinstance(self.body, LIMBS):
            width = (1.0 + (self.fabric.ease or 0.0)) * self.body.girth
        return length, width or 0.0

    @model_validator(mode="after")
    def _consistent(self) -> Case:
        refuse(_conflicts(self))
        return self


def _conflicts(case: Case) -> Iterator[Conflict]:
    """Yield everything in a case that does not fit together."""
    if case.worn:
        yield from worn_conflicts(case)
        return
    yield from not_worn_conflicts(case)
    yield from _motion_conflicts(case)
    yield from _symmetry_conflicts(case)
    yield from _size_conflicts(case)
    wires, body = case.wires is not None, case.body is not None
    yield from outline_conflicts(case.fabric, case.supports, case.motion, wires=wires)
    bends = case.motion.target != "weight" or _may_bend(case)
    yield from load_conflicts(case.supports, case.motion, wires=wires, body=body, bends=bends)
    yield from _wire_conflicts(case)


def _may_bend(case: Case) -> bool:
    """Tell whether an effect resists bending; one that is not in the library may."""
    from etextile.effects.registry import EFFECTS

    own = [effect.id for effect in case.effects if effect.id in EFFECTS]
    foreign = [name for name in own if not EFFECTS[name].__module__.startswith("etextile.effects.")]
    return "bending_stiffness" in own or bool(foreign) or len(own) < len(case.effects)


def _motion_conflicts(case: Case) -> Iterator[Conflict]:
    """Yield a target that is not there: no body, or an edge that is not clamped."""
    target = case.motion.target
    if target == "body" and case.body is None:
        message = "there is no body to move (got 'body'), give the case a body or name a clamped edge"
        yield Conflict(message, (("motion", "target"), ("body",)))
    if target in OPPOSITE and target not in case.supports.edges:
        clamped = ", ".join(case.supports.clamped)
        message = f"this edge is not clamped (got {target!r}), clamped are {clamped}"
        yield Conflict(message, (("motion", "target"), ("supports", "clamped")))


def _symmetry_conflicts(case: Case) -> Iterator[Conflict]:
    """Yield what breaks the symmetry that a quarter or half model relies on."""
    portion, remedy = case.fabric.portion, "or set fabric.portion to whole"
    if portion == "whole":
        return
    if case.fabric.warp_angle != 0.0:
        message = f"a {portion} needs the warp along x (got {case.fabric.warp_angle:g} deg), use 0 {remedy}"
        yield Conflict(message, (("fabric", "warp_angle"), ("fabric", "portion")))
    axes = ("x", "y") if portion == "quarter" else ("x",)
    clamped = case.supports.edges
    for edge in clamped:
        if edge[0] in axes and OPPOSITE[edge] not in clamped:
            message = (
                f"a {portion} needs opposite edges alike (got {edge} without {OPPOSITE[edge]}), clamp both {remedy}"
            )
            yield Conflict(message, (("supports", "clamped"), ("fabric", "portion")))
    target = case.motion.target
    if target in clamped and target[0] in axes:
        message = f"a {portion} mirrors this edge and would move both (got {target!r}), set fabric.portion to whole"
        yield Conflict(message, (("motion", "target"), ("fabric", "portion")))
    yield from _body_symmetry_conflicts(case, axes, remedy)


def _body_symmetry_conflicts(case: Case, axes: tuple[str, ...], remedy: str) -> Iterator[Conflict]:
    """Yield a body that is off the symmetry planes, turned out of them or not symmetric itself."""
    body, portion = case.body, case.fabric.portion
    if not isinstance(body, Placed):
        return
    if body.type in ("mesh", "elbow", "knee", "own"):
        message = f"a {portion} needs a body symmetric about its planes (got {body.type}), set fabric.portion to whole"
        yield Conflict(message, (("fabric", "portion"), ("body", "type")))
        return
    if any(body.position["xy".index(axis)] != 0.0 for axis in axes):
        message = f"a {portion} needs the body in the centre (got {list(body.position)}), use [0, 0] {remedy}"
        yield Conflict(message, (("body", "position"), ("fabric", "portion")))
    if body.type != "sphere" and any(angle % 90.0 != 0.0 for angle in body.rotation):
        message = f"a {portion} needs a body turned by multiples of 90 deg (got {list(body.rotation)}), {remedy[3:]}"
        yield Conflict(message, (("body", "rotation"), ("fabric", "portion")))


def _size_conflicts(case: Case) -> Iterator[Conflict]:
    """Yield a body that stands beside the specimen and loops that are longer than it."""
    length, width = case.pattern
    if isinstance(case.body, Placed) and not isinstance(case.body, Mesh):  # a mesh has its origin anywhere
        x, y = case.body.position
        if abs(x) >= length / 2 or abs(y) >= width / 2:
            message = (
                f"the body stands beside the specimen (got {[x, y]}), stay within +-{length / 2:g}, +-{width / 2:g} mm"
            )
            yield Conflict(message, (("body", "position"), ("fabric", "size")))
    if case.wires is not None and case.wires.loops is not None and case.wires.loops.length >= length:
        message = f"loops are longer than the specimen (got {case.wires.loops.length:g} mm), stay below {length:g} mm"
        yield Conflict(message, (("wires", "loops", "length"), ("fabric", "size")))


def _wire_conflicts(case: Case) -> Iterator[Conflict]:
    """Yield wires in a whole piece cut at an angle, whose cells at the edges cannot hold them; others cannot turn."""
    angle = case.fabric.warp_angle
    if case.wires is not None and angle != 0.0 and case.fabric.portion == "whole":
        message = f"wires need the warp along x (got {angle:g} deg), use 0 or wires: null"
        yield Conflict(message, (("fabric", "warp_angle"), ("wires",)))
