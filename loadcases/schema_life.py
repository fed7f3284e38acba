"""The section `failure.cyclic` of the case file: a strain-life law of the user's, its scatter, the required cycles."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

from pydantic import Field, model_validator

from etextile.units import shorten
from loadcases.agreement import Agreement
from loadcases.conflicts import Conflict, refuse
from loadcases.schema_numbers import Quantity, Strict


Strain = Annotated[float, Quantity(above=0.0, at_most=10.0)]
Number = Annotated[float, Quantity(above=0.0)]


class LifeTable(Strict):
    """Strain ranges of a cycle, rising, and cycles to failure, falling; straight between them on logarithms."""

    strain_range: tuple[Strain, ...] = Field(min_length=2, description="Strain ranges, peak to valley, rising.")
    cycles: tuple[Number, ...] = Field(min_length=2, description="Cycles to failure at these ranges, falling.")

    @model_validator(mode="after")
    def _a_curve(self) -> LifeTable:
        ranges, cycles = self.strain_range, self.cycles
        if len(ranges) != len(cycles):
            message = f"{len(ranges)} strain ranges but {len(cycles)} numbers of cycles, give as many of both"
            refuse([Conflict(message, (("cycles",), ("strain_range",)))])
        if any(after <= before for before, after in pairwise(ranges)):
            refuse([Conflict(f"must rise (got {shorten(list(ranges))})", (("strain_range",),))])
        if any(after >= before for before, after in pairwise(cycles)):
            refuse([Conflict(f"must fall as the strain ranges rise (got {shorten(list(cycles))})", (("cycles",),))])
        return self


class Cyclic(Strict):
    """Life under repeated loading: strain range / 2 = coefficient (2 cycles)^exponent (Coffin, Manson), or a table."""

    exponent: Annotated[float, Quantity(above=-2.0, below=0.0)] | None = Field(
        default=None, description="Fatigue ductility exponent, negative (thin copper: -0.5 to -0.7)."
    )
    coefficient: Annotated[float, Quantity(above=0.0)] | None = Field(
        default=None, description="Fatigue ductility coefficient, a strain."
    )
    table: LifeTable | None = Field(default=None, description="Strain-life table, instead of the two coefficients.")
    source: str = Field(min_length=1, description="Where the numbers come from.")
    scatter: Annotated[float, Quantity(above=0.0, at_most=5.0)] | None = Field(
        default=None, description="Standard deviation of the logarithm of lives; null takes 0.5, an estimate."
    )
    required_cycles: Annotated[float, Quantity(above=0.0)] | None = Field(
        default=None, description="Cycles that the wires must last; the report gives P(life below it)."
    )
    agreed: Agreement = Field(default=Agreement(), description="What user and supplier agreed on, for the report.")

    @model_validator(mode="after")
    def _one_law(self) -> Cyclic:
        both = self.exponent is not None and self.coefficient is not None
        some = self.exponent is not None or self.coefficient is not None
        if self.table is not None and some:
            message = "a table and coefficients of Coffin and Manson are two laws, keep one of them"
            refuse([Conflict(message, (("table",), ("exponent",)))])
        if self.table is None and not both:
            message = "no strain-life law, give exponent and coefficient, or a table"
            missing = "coefficient" if self.exponent is not None else "exponent"
            refuse([Conflict(message, ((missing,), ("table",)))])
        agreed = self.agreed.required_cycles
        if agreed is not None and self.required_cycles is not None and agreed != self.required_cycles:
            message = f"{self.required_cycles:g} cycles here but {agreed:g} in agreed, give one of them"
            refuse([Conflict(message, (("required_cycles",), ("agreed", "required_cycles")))])
        return self

    @property
    def required(self) -> float | None:
        """The required cycles, as given here or among the agreed terms."""
        return self.agreed.required_cycles if self.required_cycles is None else self.required_cycles
