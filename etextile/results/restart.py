"""The state of a run as named arrays, so that any nest of dataclasses, tuples and dictionaries can be kept in a file.

The structure itself is not stored: on reading, a state freshly made from the same case is the template that is filled.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from etextile.errors import EtextileError


Tree = TypeVar("Tree")


def flatten(tree: object) -> dict[str, NDArray[Any]]:
    """Return the arrays and numbers of a state by dotted name (`states.0.anchor`); None holds nothing."""
    return dict(_leaves(tree, ""))


def rebuild(template: Tree, arrays: Mapping[str, NDArray[Any]]) -> Tree:
    """Return a copy of the template with its arrays and numbers replaced.

    A missing name, a name too many or another shape raises EtextileError: the state belongs to another model.
    """
    known = flatten(template)
    if set(known) != set(arrays):
        odd = ", ".join(sorted(set(known) ^ set(arrays)))
        raise EtextileError(f"the stored state does not belong to this model: {odd} on one side only")
    for name, values in known.items():
        if values.shape != arrays[name].shape:
            found = arrays[name].shape
            raise EtextileError(f"the stored state does not belong to this model: {name} {found}, not {values.shape}")
    filled: Tree = _fill(template, "", arrays)
    return filled


def _parts(tree: object) -> Iterator[tuple[str, Any]] | None:
    """Return the named parts of a nest, or None for a leaf."""
    if is_dataclass(tree) and not isinstance(tree, type):
        return ((entry.name, getattr(tree, entry.name)) for entry in fields(tree))
    if isinstance(tree, Mapping):
        return ((str(name), part) for name, part in tree.items())
    if isinstance(tree, tuple):
        return ((str(number), part) for number, part in enumerate(tree))
    return None


def _leaves(tree: object, name: str) -> Iterator[tuple[str, NDArray[Any]]]:
    parts = _parts(tree)
    if parts is None:
        if tree is not None:
            yield name, np.asarray(tree)
        return
    for part, value in parts:
        yield from _leaves(value, f"{name}.{part}" if name else part)


def _fill(tree: Any, name: str, arrays: Mapping[str, NDArray[Any]]) -> Any:
    parts = _parts(tree)
    if parts is None:
        if tree is None or isinstance(tree, np.ndarray):
            return tree if tree is None else np.array(arrays[name], dtype=tree.dtype)
        return type(tree)(arrays[name].item())
    filled = {part: _fill(value, f"{name}.{part}" if name else part, arrays) for part, value in parts}
    if isinstance(tree, tuple):
        return tuple(filled.values())
    if isinstance(tree, Mapping):
        return filled
    return replace(tree, **filled)
