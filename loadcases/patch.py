"""Patch files: effects that a diagnosis found, with where they come from and where they hold, for `run --patch`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from etextile.errors import BadInput, Problem
from loadcases import catalogue
from loadcases.dump import dump
from loadcases.names import resolve_effects
from loadcases.reader import LoadedCase, case_sha256
from loadcases.schema_numbers import NonNegative, NonNegativeLength, Number, Quantity, Strict, Version
from loadcases.schema_parts import Effect
from loadcases.validate import validated
from loadcases.yaml_text import read_document


FABRIC_BESIDE = "fabric.yaml"
"""The fabric identified from the coupons, which a diagnosis leaves beside its patch."""
MARGIN = 1.01
"""Strains up to 1 % beyond those of the data are not worth a word."""


class PatchedCase(Strict):
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


class Strains(Strict):
    """Largest engineering strain of every truss family."""

    warp: NonNegative = Field(description="Largest engineering strain along the warp.")
    weft: NonNegative = Field(description="Largest engineering strain along the weft.")
    diagonal: NonNegative = Field(description="Largest engineering strain of the diagonals, which carry the shear.")


def _of_each_family(value: Any) -> Any:
    """Take one number for all families, as patches of earlier versions have it."""
    if value is None or isinstance(value, (dict, Strains)):
        return value
    return dict.fromkeys(Strains.model_fields, Quantity(at_least=0.0).read(value))


class Validity(Strict):
    """The range of data the patch was found in; beyond it the effects extrapolate."""

    displacement: tuple[NonNegativeLength, NonNegativeLength] = Field(description="Displacements [from, to], mm.")
    strain: Annotated[Strains | None, BeforeValidator(_of_each_family)] = Field(
        default=None,
        description="Largest engineering strains with the effects within these displacements, or one for all families.",
    )


class Patch(Strict):
    """Effects to add to a case, found by `etextile diagnose`."""

    schema_version: Version
    title: str = Field(min_length=1, description="One line on what was found.")
    base: PatchedCase | None = Field(default=None, description="The case that was diagnosed; null applies to any.")
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


def misfit(patch: Patch, loaded: LoadedCase, path: Path) -> Problem | None:
    """Say that a patch was made for another case than this one, and what differs as far as that can be known.

    `path`: the file of the patch; a fabric that lies beside it is tried in the case.
    """
    base = patch.base
    if base is None or base.sha256 == loaded.sha256:
        return None
    fabric, beside = path.parent / FABRIC_BESIDE, None
    if fabric.is_file():
        part = loaded.case.fabric.model_copy(update={"set": str(fabric.resolve())})
        beside = case_sha256(loaded.case.model_copy(update={"fabric": part}))
    if beside == base.sha256:
        return Problem(f"the patch was found on another fabric than the case has, add --set fabric.set={fabric}")
    if base.title != loaded.case.title:
        return Problem(f"the patch was made for another case ({base.title or base.sha256[:12]})")
    if beside == loaded.sha256:
        return Problem("the patch was made for a case of this title and fabric, but another value differs")
    message = "the patch was made for a case of this title, but the fabric or another value differs"
    return Problem(message if beside is None else f"{message}; the diagnosis ran with --set fabric.set={fabric}")


def beyond(patch: Patch, reached: Mapping[str, float]) -> str | None:
    """Say which strains of a run go beyond those the patch was fitted to; `reached`: largest one by family."""
    known = patch.valid.strain if patch.valid is not None else None
    if known is None:
        return None
    limits = {name: float(getattr(known, name)) for name in Strains.model_fields}
    found = [
        f"up to {limit:.3g} {name} strain, this run reaches {reached[name]:.3g}"
        for name, limit in limits.items()
        if reached[name] > MARGIN * limit
    ]
    return f"the patch was fitted {'; '.join(found)}" if found else None
