"""Wire material files: the elastoplastic law and the strength of one filament, every number with its origin."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Annotated

from pydantic import Field

from loadcases import catalogue
from loadcases.measured import Measured, Stated
from loadcases.schema_numbers import Quantity, Strict, Version
from loadcases.schema_wires import Wires
from loadcases.validate import validated
from loadcases.yaml_text import parse_document, read_text, shown
from wires.weakest_link import on_gauge


PositiveStress = Annotated[Measured, Stated(Quantity("MPa", at_least=1e-3, at_most=1e7), origin=True)]
PositiveNumber = Annotated[Measured, Stated(Quantity(above=0.0, at_most=1e6), origin=True)]
Exponent = Annotated[Measured, Stated(Quantity(at_least=0.01, at_most=20.0), origin=True)]
Strain = Annotated[Measured, Stated(Quantity(at_least=1e-6, at_most=10.0), origin=True)]
BreakStrain = Annotated[Measured, Stated(Quantity(at_least=1e-4, at_most=10.0), origin=True)]
Shape = Annotated[Measured, Stated(Quantity(at_least=0.1, at_most=1e4), origin=True)]
Gauge = Annotated[Measured, Stated(Quantity("mm", at_least=0.1, at_most=1e5), origin=True)]
PositiveDiameter = Annotated[Measured, Stated(Quantity("mm", at_least=1e-3, at_most=5.0), origin=True)]
AnyNumber = Annotated[Measured, Stated(Quantity(at_least=-5.0, at_most=5.0), origin=True)]


NUMBERS = {
    "E": "MPa",
    "sigma_y0": "MPa",
    "H": "MPa",
    "n": "",
    "e0": "",
    "elongation_at_break": "",
    "reference_diameter": "mm",
    "elongation_exponent": "",
    "weibull_shape": "",
    "resistivity": "ohm mm2/m",
}
"""The numbers of a wire material with their units."""


class WireMaterial(Strict):
    """Material of a filament: sigma_y = sigma_y0 eps_p/(eps_p + e0) + H eps_p^n, and its elongation at break."""

    schema_version: Version
    title: str = Field(min_length=1, description="One line that names the material.")
    description: str = Field(default="", description="What the numbers are, free text.")
    E: PositiveStress = Field(description="Young's modulus, MPa.")
    sigma_y0: PositiveStress = Field(description="Yield stress, MPa.")
    H: PositiveStress = Field(description="Hardening factor, MPa.")
    n: Exponent = Field(description="Hardening exponent.")
    e0: Strain = Field(
        default=Measured(value=1e-3, estimated=True), description="Plastic strain over which sigma_y0 builds up."
    )
    elongation_at_break: BreakStrain = Field(
        description="Mean engineering strain at which a filament of the reference diameter breaks."
    )
    reference_diameter: PositiveDiameter = Field(
        default=Measured(value=0.03, estimated=True), description="Diameter of that filament, mm."
    )
    elongation_exponent: AnyNumber = Field(
        default=Measured(value=0.0, estimated=True),
        description="The elongation grows with the diameter to this power; 0 when it is not known.",
    )
    gauge_length: Gauge | None = Field(
        default=None, description="Length over which the elongation was measured, mm; null as for copper_soft."
    )
    resistivity: PositiveNumber = Field(
        default=Measured(value=0.017241, source="annealed copper, IACS (IEC 60028)"),
        description="Electrical resistivity, ohm mm2 per m.",
    )
    weibull_shape: Shape = Field(description="Weibull shape of the elongation at break (its scatter).")

    def elongation(self, diameter_mm: float) -> float:
        """Return the mean elongation at break of filaments of another diameter."""
        ratio = diameter_mm / self.reference_diameter.value
        return float(self.elongation_at_break.value * ratio**self.elongation_exponent.value)


COUPON_MATERIAL, COUPON_DIAMETER_MM, COUPON_GAUGE_MM = "copper_soft", 0.03, 200.0
"""What the wires of the paper's coupons are taken for: their limit was found on these."""


def strength_factor(material: WireMaterial, diameter_mm: float) -> float:
    """Return the elongation at break of filaments over that of the coupons', both on one gauge.

    An elongation measured over another length is converted by the weakest link of its own Weibull shape.
    """
    coupon = load_wire_material(COUPON_MATERIAL)
    gauge = coupon.gauge_length.value if coupon.gauge_length is not None else COUPON_GAUGE_MM
    measured = gauge if material.gauge_length is None else material.gauge_length.value
    own = on_gauge(
        material.elongation(diameter_mm), measured_mm=measured, gauge_mm=gauge, shape=material.weibull_shape.value
    )
    return own / coupon.elongation(COUPON_DIAMETER_MM)


def wire_numbers(wires: Wires) -> dict[str, float]:
    """Return what the wires of a case tell a failure criterion: filaments, their diameter, elongation and scatter."""
    material = load_wire_material(wires.material)
    return {
        "filaments": float(wires.filaments),
        "filament_diameter": wires.filament_diameter,
        "elongation_at_break": material.elongation(wires.filament_diameter),
        "weibull_shape": material.weibull_shape.value,
        "strength_factor": strength_factor(material, wires.filament_diameter),
    }


def load_wire_material(name: str | Path, *, folder: Path | None = None) -> WireMaterial:
    """Return the shipped wire material of that name or the one in a file; raises BadInput with all that is wrong."""
    path = catalogue.find("wire material", str(name), folder=folder)
    return _material(read_text(path), shown(path))


@lru_cache(maxsize=32)
def _material(text: str, file: str) -> WireMaterial:
    """Return the material written in `text`: a run asks for it some dozen times, and parsing takes 20 ms."""
    return validated(parse_document(text, file), WireMaterial)
