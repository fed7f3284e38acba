"""A snapshot as named arrays and back, so that a run can go on in another process with the same digits.

The nest of dataclasses and tuples is not written down: the model's own virgin snapshot is the template that is filled,
so a contribution may keep any state of arrays, numbers and nests of them without telling the restart about it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from etextile.errors import EtextileError
from etextile.mechanics.model import Model
from etextile.solve.path import Snapshot, start


def to_arrays(snapshot: Snapshot) -> dict[str, NDArray[Any]]:
    """Return all arrays and numbers of a snapshot by dotted name (`states.1.anchor`); numbers are 0-d arrays."""
    return {name: np.array(leaf) for name, leaf in _leaves(snapshot, "")}


def from_arrays(model: Model, arrays: Mapping[str, NDArray[Any]]) -> Snapshot:
    """Return the snapshot of `model` that holds these arrays: `advance` goes on from it with the same digits.

    A missing name, a name too many or another shape raises EtextileError: the arrays belong to another model.
    """
    template = start(model)
    known = to_arrays(template)
    if odd := ", ".join(sorted(set(known) ^ set(arrays))):
        raise EtextileError(f"the stored state does not belong to this model: {odd} on one side only")
    for name, values in known.items():
        found = np.shape(arrays[name])
        if found != values.shape:
            raise EtextileError(f"the stored state does not belong to this model: {name} {found}, not {values.shape}")
    filled: Snapshot = _filled(template, "", arrays)
    return filled


def _parts(tree: Any) -> Iterator[tuple[str, Any]] | None:
    """Return the named parts of a nest, None for a leaf."""
    if is_dataclass(tree):
        return ((entry.name, getattr(tree, entry.name)) for entry in fields(tree))
    if isinstance(tree, tuple):
        return ((str(number), part) for number, part in enumerate(tree))
    return None


def _leaves(tree: Any, name: str) -> Iterator[tuple[str, Any]]:
    parts = _parts(tree)
    if parts is None:
        if tree is not None:
            yield name, tree
        return
    for part, value in parts:
        yield from _leaves(value, f"{name}.{part}" if name else part)


def _filled(tree: Any, name: str, arrays: Mapping[str, NDArray[Any]]) -> Any:
    parts = _parts(tree)
    if tree is None:
        return None
    if parts is None:
        stored = np.asarray(arrays[name])
        return np.array(stored, dtype=tree.dtype) if isinstance(tree, np.ndarray) else type(tree)(stored.item())
    filled = {part: _filled(value, f"{name}.{part}" if name else part, arrays) for part, value in parts}
    return tuple(filled.values()) if isinstance(tree, tuple) else replace(tree, **filled)
