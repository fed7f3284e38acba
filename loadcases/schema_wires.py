"""The wires section of the case file: a comb or a drawing, with parts, joints and nets."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from etextile.units import shorten
from loadcases.conflicts import Conflict, refuse
from loadcases.schema_bond import Bond
from loadcases.schema_loops import Loops
from loadcases.schema_numbers import FilamentDiameter, Filaments, Length, Quantity, Share, Strict
from loadcases.schema_paths import Component, Net, WirePath


class Wires(Strict):
    """Conductive wires: a regular comb along the warp, or the paths of a drawing."""

    every_warp_yarns: Annotated[float, Quantity(at_least=1.0)] = Field(
        default=65.0,
        description="Warp yarns from wire to wire (65 is 5.91 mm in the estimated fabrics).",
        json_schema_extra={"origin": "stated: one wire per 65 warp yarns on average (Beex et al.)"},
    )
    first_offset: Length = Field(
        default=0.0,
        description="Distance of the reference wire from the centre line, mm; drawn wires and parts are shifted by it.",
        json_schema_extra={"origin": "estimated: the paper does not say where wires lie"},
    )
    material: str = Field(
        default="copper_soft",
        min_length=1,
        description="Name of a shipped wire material or path of a file (list wires).",
        json_schema_extra={"origin": "estimated: the paper says copper; soft copper's elongation fits its onset"},
    )
    filaments: Filaments = Field(
        default=7,
        description="Filaments twisted into one wire.",
        json_schema_extra={"origin": "estimated: six filaments twisted about one"},
    )
    filament_diameter: FilamentDiameter = Field(
        default=0.03,
        description="Diameter of one filament, mm.",
        json_schema_extra={"origin": "estimated: as the thinnest drawn copper wire with published strength, 30 um"},
    )
    crimp: Share = Field(
        default=0.02,
        description="Excess length of the wire in the weave, as a strain.",
        json_schema_extra={"origin": "estimated"},
    )
    coupons_contain_wires: bool = Field(
        default=True,
        description="Whether the coupons behind the fabric's laws contained these wires: the warp law is then lowered "
        "by their share. false for laws of the bare fabric; wires may then be stiffer than it.",
    )
    loops: Loops | None = Field(default=Loops(), description="Clearance loops; null for none.")
    bond: Bond = Field(
        default="perfect",
        description="perfect, or a line friction against which the wire slides.",
        json_schema_extra={"origin": "estimated: no friction of a wire in this weave is known"},
    )
    paths: tuple[WirePath, ...] = Field(
        default=(), description="Wires by name and line; they take the place of the comb. Beside a drawing: its wires."
    )
    layout: str | None = Field(
        default=None, min_length=1, description="Drawing of wires and parts, a .dxf or .csv file; null for none."
    )
    layout_units: Literal["mm", "cm", "m", "um", "in"] | None = Field(
        default=None, description="Unit of a drawing that does not say its own; null when it does."
    )
    components: tuple[Component, ...] = Field(default=(), description="Parts on the fabric and what they connect.")
    joined: tuple[tuple[str, str], ...] = Field(
        default=(), description="Pairs of wires that are joined where they cross; all other crossings are insulated."
    )
    nets: tuple[Net, ...] = Field(default=(), description="Connections whose loss is reported.")

    @property
    def drawn(self) -> bool:
        """Whether the wires are drawn, not a comb."""
        return bool(self.paths) or self.layout is not None

    @model_validator(mode="after")
    def _fits(self) -> Wires:
        found = []
        for key, items in (("nets", self.nets), ("components", self.components)):
            names = [item.name for item in items]
            twice = sorted({name for name in names if names.count(name) > 1})
            found += [Conflict(f"two {key} have one name (got {shorten(name)})", ((key,),)) for name in twice]
        if self.layout is None:
            found += [
                Conflict("this wire has no line, give along, at, or path", (("paths", str(number)),))
                for number, path in enumerate(self.paths)
                if path.along is None and path.path is None
            ]
        refuse(found)
        return self
