"""What user and supplier agree on before a life is tested: it belongs beside every number of cycles in a report.

The words are those of the field's standards for conductive tracks on textiles (EN 16812: linear electrical resistance;
ISO 139: conditioning): without the critical area, the parameter that is relevant for the function, the event rule and
the conditioning, two numbers of cycles cannot be compared.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from etextile.errors import BadInput
from loadcases import catalogue
from loadcases.schema_numbers import Count, Quantity, Strict
from loadcases.validate import validated
from loadcases.yaml_text import read_document


class Agreement(Strict):
    """The terms of a life test; what is left out is reported as not agreed."""

    title: str | None = Field(default=None, description="One line on product and test.")
    critical_area: str | None = Field(default=None, description="Where on the product it is judged, as elbow, outside.")
    parameter: str | None = Field(
        default=None, description="Functionally relevant parameter, as linear electrical resistance, ohm/m."
    )
    event: str | None = Field(default=None, description="Event rule with its confirmation, as R > 2 R0 in 3 readings.")
    cycle: str | None = Field(default=None, description="What one cycle is: arc, speed, load.")
    conditioning: str | None = Field(default=None, description="Climate and treatment before and during the test.")
    sample_size: Count | None = Field(default=None, description="Specimens per critical area.")
    required_cycles: Annotated[float, Quantity(above=0.0)] | None = Field(
        default=None, description="Cycles that the product must last."
    )
    between: str | None = Field(default=None, description="User and supplier who agreed, and when.")


WORDS = {
    "critical_area": "critical area",
    "parameter": "functionally relevant parameter",
    "event": "event (failure) rule",
    "cycle": "one cycle",
    "conditioning": "conditioning",
    "sample_size": "sample size",
    "required_cycles": "required cycles",
    "between": "agreed between user and supplier",
}
"""The terms as they are written in reports, in their order."""


def read_agreement(path: Path) -> Agreement:
    """Return the terms in a YAML file; raises BadInput with everything that is wrong."""
    if not path.is_file():
        raise BadInput.of("no such file, give a YAML file with what was agreed (or leave it out)", file=str(path))
    document, _ = read_document(catalogue.find("case", str(path.absolute())))
    return validated(document, Agreement)


def terms(agreement: Agreement) -> list[tuple[str, str]]:
    """Return the terms as pairs of words, `not given` for what is open."""
    values = {name: getattr(agreement, name) for name in WORDS}
    return [
        (WORDS[name], "not given" if value is None else f"{value:g}" if isinstance(value, float) else str(value))
        for name, value in values.items()
    ]
