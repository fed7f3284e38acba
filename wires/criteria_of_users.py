"""Failure criteria of a user's own: from a Python file that the case names, or from an installed package.

A file defines an object (or a class that can be made without arguments) with `name`, `summary`, `parameters` and
`evaluate`, as `wires.damage.Criterion` says; a package offers it under the entry point group `etextile.criteria`.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

from etextile.errors import BadInput, nearest
from etextile.plugins import installed, own_objects, run_file
from etextile.registry import Registry
from wires.damage import Criterion, CriterionParameter


GROUP = "etextile.criteria"


class Criteria(Registry[Criterion]):
    """The registry of criteria, which finds those of installed packages by itself and loads those of files."""

    def __init__(self) -> None:
        super().__init__("failure criterion")
        self._searched = False
        self._files: dict[str, ModuleType] = {}

    def load(self, name: str, file: str | Path | None) -> Criterion:
        """Return the criterion of that name, from a Python file if one is given; raises BadInput."""
        if file is None:
            return self[name]
        module = run_file(file, key="failure.file")
        if self._files.get(name) is module:
            return self._items[name]
        if name in self and name not in self._files:
            message = f"the criterion {name!r} is known already, give your own another name"
            raise BadInput.of(message, key="failure.criterion")
        self._items[name] = _from_module(module, name, Path(file))
        self._files[name] = module
        return self._items[name]

    def __getitem__(self, name: str) -> Criterion:
        """Return the criterion of that name; raises BadInput when there is none."""
        if not super().__contains__(name):
            self._search()
        return super().__getitem__(name)

    def __contains__(self, name: object) -> bool:
        """Tell whether a name is known."""
        if not super().__contains__(name):
            self._search()
        return super().__contains__(name)

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names, those of packages last."""
        self._search()
        return super().__iter__()

    def _search(self) -> None:
        """Register what installed packages offer, once."""
        if self._searched:
            return
        self._searched = True
        for _, place, item in installed(GROUP):
            found = _checked(item, place)
            if not Registry.__contains__(self, found.name):
                self.register(found.name, found)


def _from_module(module: ModuleType, name: str, path: Path) -> Criterion:
    """Return the criterion called `name` among the module's own objects and classes."""
    found = {item.name: item for item in own_objects(module) if isinstance(getattr(item, "name", None), str)}
    if name in found:
        return _checked(found[name], str(path))
    known = ", ".join(found) or "none"
    message = (
        f"defines no criterion {name!r} (an object or class with that `name`), found: {known}{nearest(name, found)}"
    )
    raise BadInput.of(message, file=str(path))


def _checked(item: Any, place: str) -> Criterion:
    """Return a criterion, made from its class if need be; BadInput says what it lacks."""
    if isinstance(item, type):
        item = item()
    lacks = [part for part in ("name", "summary", "parameters", "evaluate") if not hasattr(item, part)]
    if lacks:
        raise BadInput.of(f"the criterion lacks {', '.join(lacks)}", file=place)
    if not all(isinstance(parameter, CriterionParameter) for parameter in item.parameters) or not callable(
        item.evaluate
    ):
        message = "`parameters` must be a tuple of etextile.CriterionParameter and `evaluate` a function"
        raise BadInput.of(message, file=place)
    criterion: Criterion = item
    return criterion
