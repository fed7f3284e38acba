"""Fabric files: weave geometry and the tensile law of its three truss families, shipped or written by `identify`."""

from __future__ import annotations

import math
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from etextile.lattice.weave import Weave
from etextile.units import shorten, to_number
from loadcases import catalogue
from loadcases.continuation import Continuation
from loadcases.dump import dump
from loadcases.measured import Measured, Stated
from loadcases.schema_numbers import (
    Number,
    Quantity,
    Share,
    Strict,
    Version,
)
from loadcases.validate import validated
from loadcases.yaml_text import parse_document, read_document, read_text, shown


FAMILIES = ("warp", "weft", "diagonal")
DEFAULT_FABRIC = "estimated_mid"
"""What lends weave and laws where none are given."""
Density = Annotated[float, Quantity("1/mm", at_least=1e-3, at_most=1e3)]
YarnLength = Annotated[float, Quantity("mm", at_least=1e-4, at_most=1e3)]
"""Cell and thickness."""
ParameterName = Literal["E", "sigma_y0", "H", "n"]
EndOfRange = Annotated[float, Quantity(at_least=-1.0, at_most=10.0)]
Matrix = tuple[tuple[Number, ...], ...]


class Covariance(Strict):
    """Covariance of identified parameters: of their mean, and optionally from specimen to specimen."""

    parameters: tuple[ParameterName, ...] = Field(min_length=1, description="Order of the rows and columns.")
    matrix: Matrix = Field(description="Covariance of the parameters, units as the parameters' own.")
    between_specimens: Matrix | None = Field(default=None, description="Covariance from one specimen to the next.")

    @model_validator(mode="after")
    def _is_covariance(self) -> Covariance:
        size = len(self.parameters)
        for matrix in (self.matrix, self.between_specimens or self.matrix):
            if len(matrix) != size or any(len(row) != size for row in matrix):
                raise ValueError(f"the matrix is not square with {size} rows, one for each of {list(self.parameters)}")
            largest = max(abs(value) for row in matrix for value in row)
            pairs = [(i, j) for i in range(size) for j in range(i)]
            if any(abs(matrix[i][j] - matrix[j][i]) > 1e-6 * largest for i, j in pairs):
                raise ValueError("the matrix is not symmetric, a covariance is")
            if any(matrix[i][i] < 0.0 for i in range(size)):
                raise ValueError("a variance is negative, the diagonal must be at least 0")
        return self


class Family(Strict):
    """Law of one truss family: sigma_y = sigma_y0 eps_p/(eps_p + e0) + H eps_p^n, true stress over Hencky strain."""

    E: Annotated[Measured, Stated(Quantity("MPa", at_least=1e-3, at_most=1e7))] = Field(
        description="Young's modulus, MPa."
    )
    sigma_y0: Annotated[Measured, Stated(Quantity("MPa", at_least=0.0, at_most=1e6))] = Field(
        description="Initial yield stress, MPa."
    )
    H: Annotated[Measured, Stated(Quantity("MPa", above=0.0, at_most=1e12))] = Field(
        description="Hardening factor, MPa."
    )
    n: Annotated[Measured, Stated(Quantity(at_least=0.01, at_most=20.0))] = Field(description="Hardening exponent.")
    e0: Annotated[float, Quantity(at_least=1e-6, at_most=1.0)] = Field(
        default=1e-3, description="Plastic strain over which sigma_y0 builds up."
    )
    compression_ratio: Share = Field(
        default=0.0,
        description="Force in compression over that in tension at the same strain (0: yarns buckle).",
    )
    strain_range: tuple[EndOfRange, EndOfRange] = Field(
        description="Engineering strains [from, to] the law is valid for."
    )
    rupture_strain: Annotated[Measured, Stated(Quantity(at_least=1e-4, at_most=10.0))] | None = Field(
        default=None, description="Engineering strain at which a yarn breaks, with spread and source; null: unknown."
    )
    beyond: Continuation = Field(
        default_factory=Continuation, description="Low and high continuation of the law beyond its range."
    )
    covariance: Covariance | None = Field(default=None, description="Covariance of the identified parameters.")
    residual: Annotated[float, Quantity("MPa", at_least=0.0, at_most=1e7)] | None = Field(
        default=None, description="Root mean square residual of the fit in fabric stress, MPa."
    )
    estimated: bool = Field(default=False, description="True for estimates, false for fits to measurements.")
    source: str = Field(default="", description="Where the numbers come from.")

    @field_validator("strain_range")
    @classmethod
    def _range_rises(cls, value: tuple[float, float]) -> tuple[float, float]:
        if not 0.0 <= value[0] < value[1]:
            raise ValueError(f"the range does not rise (got {shorten(list(value))}), must be 0 <= from < to")
        return value


class Fabric(Strict):
    """A woven fabric: its cell, what one cell stands for, its yarn densities and the laws of warp, weft, diagonal."""

    schema_version: Version
    title: str = Field(min_length=1, description="One line that names the fabric.")
    description: str = Field(default="", description="What the numbers are, free text.")
    source: str = Field(default="", description="Where the geometry comes from.")
    cell: tuple[YarnLength, YarnLength] = Field(
        description="Fabric cell [along warp, along weft], mm. Left out: from yarn to yarn by the densities."
    )
    thickness: YarnLength = Field(description="Nominal thickness to which fabric stress refers, mm.")
    truss_area: Annotated[float, Quantity("mm**2", at_least=1e-6, at_most=1e6)] = Field(
        description="Area of one truss at coarsening 1, mm2, to which the laws' stresses refer; any value will do that "
        "is kept, for the laws belong to it. Left out: trusses that hold as much material as the fabric, which is the "
        "cell's area times the thickness over the length of its trusses."
    )
    warp_density: Density = Field(description="Warp yarns per mm of weft direction.")
    weft_density: Density = Field(description="Weft yarns per mm of warp direction.")
    warp: Family = Field(description="Law of the warp trusses; identify finds it.")
    weft: Family = Field(description="Law of the weft trusses; identify finds it.")
    diagonal: Family = Field(description="Law of the diagonal trusses; identify finds it.")

    @model_validator(mode="before")
    @classmethod
    def _derived(cls, value: Any) -> Any:
        """Fill in cell and truss area from densities and thickness where these are numbers."""
        if not isinstance(value, dict) or ("cell" in value and "truss_area" in value):
            return value
        try:
            warp, weft = (to_number(value[f"{name}_density"], "1/mm") for name in ("warp", "weft"))
            thickness = to_number(value["thickness"], "mm")
            along, across = (to_number(item, "mm") for item in value.get("cell", (1.0 / weft, 1.0 / warp)))
            trusses = along + across + 2.0 * math.hypot(along, across)
            return {"cell": (along, across), "truss_area": along * across * thickness / trusses, **value}
        except (KeyError, ValueError, TypeError, ZeroDivisionError):
            return value

    @property
    def area_ratios(self) -> dict[str, float]:
        """Fabric cross-section that one truss of a family stands for over the area of the truss."""
        weave = Weave(*self.cell, self.thickness, self.truss_area, self.warp_density, self.weft_density)
        return {name: area / self.truss_area for name, area in zip(FAMILIES, weave.nominal_area, strict=True)}


def load_fabric(name: str | Path, *, folder: Path | None = None) -> Fabric:
    """Return the shipped fabric of that name or the one in a file; raises BadInput with all that is wrong."""
    path = catalogue.find("fabric", str(name), folder=folder)
    return _fabric(read_text(path), shown(path))


@lru_cache(maxsize=32)
def _fabric(text: str, file: str) -> Fabric:
    """Return the fabric written in `text`: a run asks for it several times, and parsing takes 30 ms."""
    return validated(parse_document(text, file), Fabric)


def load_base(name: str | Path) -> Fabric:
    """Return a fabric to identify laws for: one that has laws, or a file of weave alone (densities and thickness).

    A file without laws takes those of `DEFAULT_FABRIC`, scaled to carry the same fabric stress, until they are found.
    """
    document, _ = read_document(catalogue.find("fabric", str(name)))
    if any(family in document.data for family in FAMILIES):
        return validated(document, Fabric)
    donor = load_fabric(DEFAULT_FABRIC)
    document.data.update({family: getattr(donor, family).model_dump(exclude_unset=True) for family in FAMILIES})
    fabric = validated(document, Fabric)
    laws = {}
    for family in FAMILIES:
        law: Family = getattr(fabric, family)
        factor = fabric.area_ratios[family] / donor.area_ratios[family]
        stresses = {
            key: getattr(law, key).model_copy(update={"value": float(f"{factor * getattr(law, key).value:.6g}")})
            for key in ("E", "sigma_y0", "H")
        }
        source = f"no law in the file: the fabric stress of {DEFAULT_FABRIC}"
        laws[family] = law.model_copy(update={**stresses, "estimated": True, "source": source})
    return fabric.model_copy(update=laws)


def has_laws(name: str | Path) -> bool:
    """Tell whether a fabric file holds laws, not the weave alone."""
    document, _ = read_document(catalogue.find("fabric", str(name)))
    return any(family in document.data for family in FAMILIES)


def dump_fabric(fabric: Fabric) -> str:
    """Return a fabric as YAML text that `load_fabric` reads back to the same fabric."""
    return dump(fabric, unset=False)
