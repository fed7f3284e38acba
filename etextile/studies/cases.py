"""A case from wherever it comes: a shipped name, a file, text changed in Python; and the model that is built of it."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from etextile import foreign_code
from loadcases import build as building
from loadcases.build import Built
from loadcases.reader import LoadedCase, as_loaded, load_case
from loadcases.schema import Case


AnyCase: TypeAlias = LoadedCase | Case | str | Path
"""What studies take for a case: as loaded, as made in Python, or the name or path of one."""


def load(name: str | Path, changes: Mapping[str, Any] | Sequence[str] = (), *, allow_code: bool = False) -> LoadedCase:
    """Return the shipped case of that name or the one in a file, with changes laid over it.

    `changes`: values by key path, `{"motion.total": "25 mm", "wires": None}`, or texts `key.path=value` as the command
    line takes them. `allow_code`: run the Python files that the case names; those named in `changes` are the caller's
    own. Raises BadInput with everything that is wrong.
    """
    with foreign_code.trusting(allow_code):
        return load_case(name, overrides=overrides_of(changes))


def loaded_case(case: AnyCase) -> LoadedCase:
    """Return a case in the form that studies take; raises BadInput for a name or file that is none."""
    if isinstance(case, LoadedCase):
        return case
    return as_loaded(case) if isinstance(case, Case) else load(case)


def build(case: AnyCase) -> Built:
    """Return the model of a case, nothing run yet; raises BadInput for what cannot be built."""
    loaded = loaded_case(case)
    with loaded.locating():
        return building.build(loaded.case)


def overrides_of(changes: Mapping[str, Any] | Sequence[str]) -> tuple[str, ...]:
    """Return changes as texts `key.path=value`; text values are read as YAML, others stand as they are."""
    if isinstance(changes, Mapping):
        return tuple(f"{key}={_written(value)}" for key, value in changes.items())
    return tuple(changes)


def _written(value: Any) -> str:
    """Write a value as YAML reads it back."""
    if isinstance(value, str | Path):
        return str(value)
    return json.dumps(value, default=_plain)


def _plain(value: Any) -> Any:
    """Return arrays as lists, numpy numbers as Python's, paths as text; raises TypeError for what no case can hold."""
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"a case holds numbers, texts, lists and mappings, not {type(value).__name__}")
