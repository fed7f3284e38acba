"""Patch files: effects that a diagnosis found, with where they come from and where they hold, for `run --patch`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field, model_validator

from etextile.errors import BadInput, Problem
from loadcases import catalogue
from loadcases.dump import dump
from loadcases.names import resolve_effects
from loadcases.schema_numbers import NonNegativeLength, Number, Quantity, Strict, Version
from loadcases.schema_parts import Effect
from loadcases.validate import validated
from loadcases.yaml_text import read_document


class Base(Strict):
    """The case a patch was made for."""

    title: str = Field(default="", description="Title of the base case.")
    sha256: str = Field(pattern="^[0-9a-f]{64}$", description="Hash of the base case.")


class Interval(Strict):
    """A 95 % interval of one effect parameter."""

    effect: str = Field(min_length=1, description="Effect the parameter belongs to.")
    parameter: str = Field(min_length=1, description="Name of the parameter.")
    low: Number = Field(description="Lower end, in the parameter's unit.")
    high: Number = Field(description="Upper end.")
    unit: str = Field(default="", description="Unit of both ends.")

    @model_validator(mode="after")
    def _rises(self) -> Interval:
        if self.low > self.high:
            raise ValueError(f"the interval falls (got {self.low:g} to {self.high:g}), low must not exceed high")
        return self


class Validity(Strict):
    """The range of data the patch was found in; beyond it the effects extrapolate."""

    displacement: tuple[NonNegativeLength, NonNegativeLength] = Field(description="Displacements [from, to], mm.")
    strain: Annotated[float, Quantity(at_least=0.0)] | None = Field(
        default=None, description="Largest engineering strain in the data."
    )


class Patch(Strict):
    """Effects to add to a case, found by `etextile diagnose`."""

    schema_version: Version
    title: str = Field(min_length=1, description="One line on what was found.")
    base: Base | None = Field(default=None, description="The case that was diagnosed; null applies to any.")
    effects: tuple[Effect, ...] = Field(description="Effects with their parameters, as in a case file.")
    intervals: tuple[Interval, ...] = Field(default=(), description="95 % intervals of the parameters.")
    valid: Validity | None = Field(default=None, description="Where the effects were found to hold.")


def read_patch(path: str | Path) -> Patch:
    """Return the patch in a file with its effects' parameters as numbers; raises BadInput with all that is wrong."""
    if not Path(path).is_file():
        raise BadInput.of("no such patch file, `etextile diagnose` writes one as patch.yaml", file=str(path))
    document, _ = read_document(catalogue.find("case", str(Path(path).absolute())))
    patch = validated(document, Patch)
    effects, problems = resolve_effects(patch.effects, document)
    if problems:
        raise BadInput(problems)
    return patch.model_copy(update={"effects": effects})


def dump_patch(patch: Patch) -> str:
    """Return a patch as YAML text that `read_patch` reads back to the same patch."""
    return dump(patch, unset=False)


def misfit(patch: Patch, sha256: str) -> Problem | None:
    """Say that a patch was made for another case than the one with this hash, if so."""
    if patch.base is None or patch.base.sha256 == sha256:
        return None
    return Problem(f"the patch was made for another case ({patch.base.title or patch.base.sha256[:12]})")
