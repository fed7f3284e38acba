"""The keys of the case file in words, for listings: name, default, meaning, origin of the default."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import get_args

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from loadcases.schema_body import BODIES, LIMBS, Placed
from loadcases.schema_bond import Slipping
from loadcases.schema_loops import Loops
from loadcases.schema_scatter import POSITIONAL, Scatter
from loadcases.schema_wires import Wires


@dataclass(frozen=True)
class CaseKey:
    """One key of a section: `default` as a case file would say it, `origin` where its number comes from."""

    section: str
    name: str
    default: str
    meaning: str
    origin: str = ""


def body_types() -> dict[str, str]:
    """Return the shape of every body type in a line."""
    shapes: tuple[type[BaseModel], ...] = (*BODIES, *LIMBS)
    return {_type(model): (model.__doc__ or "").strip().splitlines()[0] for model in shapes}


def body_keys() -> Iterator[CaseKey]:
    """Yield the keys of every body type, then those that all rigid ones share (section `every`)."""
    shared = Placed.model_fields
    for model in BODIES:
        yield from (key for key in _keys(_type(model), model) if key.name != "type" and key.name not in shared)
    for limb in LIMBS:
        yield from (key for key in _keys(_type(limb), limb) if key.name != "type")
    yield from _keys("every", Placed)


def wire_defaults() -> Iterator[CaseKey]:
    """Yield the keys of wires and loops whose default is a number with an origin."""
    for section, model in (("wires", Wires), ("wires.loops", Loops), ("wires.bond", Slipping)):
        yield from (key for key in _keys(section, model) if key.origin)


def scatter_defaults() -> Iterator[CaseKey]:
    """Yield the keys of the section `scatter`; those that wait for a whole specimen with what null stands for."""
    for key in _keys("scatter", Scatter):
        yield replace(key, default=f"{POSITIONAL[key.name]:g} (whole)") if key.name in POSITIONAL else key


def _type(model: type[BaseModel]) -> str:
    """Return the value of `type` that selects a body."""
    return str(get_args(model.model_fields["type"].annotation)[0])


def _keys(section: str, model: type[BaseModel]) -> Iterator[CaseKey]:
    """Yield the keys of a section."""
    for name, info in model.model_fields.items():
        extra = info.json_schema_extra if isinstance(info.json_schema_extra, dict) else {}
        yield CaseKey(section, name, _default(info), info.description or "", str(extra.get("origin", "")))


def _default(info: FieldInfo) -> str:
    """Return the default of a key as a case file would say it."""
    if info.is_required():
        return "required"
    default = list(info.default) if isinstance(info.default, tuple) else info.default
    return "null" if default is None else f"{default:g}" if isinstance(default, float) else str(default)
