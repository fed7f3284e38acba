"""The lattice error of shipped cases, measured once, so that every run of one can say it without repeating anything.

The numbers belong to the case as shipped: fabric, lattice, body, motion and contact. What does not touch the mechanics
(title, judgement, outputs) may differ. With two lattices whose cells differ by a factor of 1.5 and an error of
second order in the cell, the coarser one is 1 / (1 - 1 / 1.5^2) = 1.8 times the change away from the limit.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from etextile.errors import BadInput
from loadcases import catalogue
from loadcases.reader import load_case
from loadcases.schema import Case
from loadcases.schema_numbers import Positive, Quantity, Strict, Version
from loadcases.validate import validated
from loadcases.yaml_text import read_document


FILE = catalogue.ROOT / "data" / "lattice_error" / "shipped.yaml"
MECHANICS = ("fabric", "wires", "supports", "body", "motion", "contact", "effects")
Share = Annotated[float, Quantity(at_least=0.0)]


class Known(Strict):
    """Coarsening of a case and of the finer lattice, and how much force and wire strain change between them."""

    coarsening: Positive = Field(description="Fabric cells per lattice cell, as shipped.")
    finer: Positive = Field(description="The same of the finer lattice.")
    force_change: Share = Field(description="Change of the force at the end, over the force.")
    wire_strain_change: Share = Field(description="Largest change of a wire's greatest span strain.")

    @property
    def force_error(self) -> float:
        """Estimated distance of the force from that of an infinitely fine lattice, as a share."""
        return self.force_change / (1.0 - (self.finer / self.coarsening) ** 2)

    def as_dict(self) -> dict[str, Any]:
        """Return the block `lattice_estimate` of report.json."""
        return {**self.model_dump(), "force_error": self.force_error, "origin": "measured once for the case as shipped"}

    @property
    def sentence(self) -> str:
        """The finding in words."""
        return (
            f"the lattice makes an error of about {100 * self.force_error:.1f} % in the force at the end and of "
            f"{self.wire_strain_change:.3f} in the strain under loops (measured for this case at coarsening "
            f"{self.coarsening:g} and {self.finer:g})"
        )


class _Table(Strict):
    schema_version: Version
    cases: dict[str, Known]


def known_error(case: Case, source: Path | None) -> Known | None:
    """Return the measured lattice error of a shipped case whose mechanics are as shipped, else None."""
    if source is None or source.parent != catalogue.ROOT:
        return None
    document, _ = read_document(FILE)
    found = validated(document, _Table).cases.get(source.stem)
    if found is None:
        return None
    try:
        shipped = load_case(source.stem).case
    except BadInput:
        return None
    same = all(getattr(case, name) == getattr(shipped, name) for name in MECHANICS)
    return found if same else None
