"""Effects of users: a class in a Python file named in the case, or in an installed package (entry point).

The file is run as Python code, as any import is: use files you trust. In a package, list the class under the entry
point group `etextile.effects`, with the effect's id as its name.
"""

from __future__ import annotations

import hashlib
import importlib.util
import inspect
import sys
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from importlib.machinery import SourceFileLoader
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any

from etextile.effects.base import QUANTITIES, Card, Effect
from etextile.errors import BadInput, nearest


GROUP = "etextile.effects"
NOTHING = "no class derived from etextile.effects.base.Effect"


def from_file(file: str | Path, name: str) -> type[Effect]:
    """Return the effect with id `name` from a Python file; raises BadInput saying what the file holds instead."""
    found = all_from_file(file)
    if name in found:
        return found[name]
    held = ", ".join(found) or NOTHING
    raise BadInput.of(f"{Path(file).name} has no effect {name!r}, it holds {held}{nearest(name, found)}", key="id")


def all_from_file(file: str | Path) -> dict[str, type[Effect]]:
    """Return all effects in a Python file by id; raises BadInput for a file that is missing or cannot be run."""
    path = Path(file).expanduser().resolve()
    if path.suffix != ".py" or not path.is_file():
        raise BadInput.of(f"no such Python file (got {str(file)!r})", key="file")
    return _effects_in(path, hashlib.sha256(path.read_bytes()).hexdigest())


@lru_cache(maxsize=1)
def from_entry_points() -> dict[str, type[Effect]]:
    """Return the effects of installed packages by name; raises BadInput for one that cannot be loaded."""
    found: dict[str, type[Effect]] = {}
    for entry in entry_points(group=GROUP):
        try:
            item = entry.load()
        except Exception as error:  # foreign code may raise anything
            raise BadInput.of(f"the effect {entry.name!r} of {entry.value} cannot be loaded: {error}") from error
        found[entry.name] = _checked(item, entry.value)
    return found


@lru_cache(maxsize=32)
def _effects_in(path: Path, content: str) -> dict[str, type[Effect]]:
    """Return the effects defined in a file by id, run once per content."""
    module = _run(path, f"etextile_user_effect_{content[:16]}")
    own = [item for item in vars(module).values() if inspect.isclass(item) and item.__module__ == module.__name__]
    effects = [_checked(item, path.name) for item in own if issubclass(item, Effect) and not inspect.isabstract(item)]
    return {item.card.id: item for item in effects}


class _AsItIs(SourceFileLoader):
    """Runs a file as it is now: kept bytecode, dated to the second, can hide a change, and clutters users' folders."""

    def path_stats(self, path: str) -> Mapping[str, Any]:
        """Raise OSError, by which the import system knows that there is no date to keep bytecode by."""
        raise OSError(path)


def _run(path: Path, name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, path, loader=_AsItIs(name, str(path)))
    if spec is None or spec.loader is None:
        raise BadInput.of(f"cannot be read as Python (got {str(path)!r})", key="file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses look their module up
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # foreign code may raise anything
        del sys.modules[name]
        raise BadInput.of(f"{path.name} cannot be run: {type(error).__name__}: {error}", key="file") from error
    return module


def _checked(item: object, place: str) -> type[Effect]:
    """Return the class if it is a usable effect, with a card whose parameters are its fields; else raise BadInput."""
    if not (inspect.isclass(item) and issubclass(item, Effect)):
        raise BadInput.of(f"{place}: an effect is a class derived from etextile.effects.base.Effect", key="file")
    card = getattr(item, "card", None)
    if not isinstance(card, Card):
        raise BadInput.of(f"{place}: class {item.__name__} has no card", key="file")
    own: set[str] = {entry.name for entry in fields(item)} if is_dataclass(item) else set()
    names = {parameter.name for parameter in card.parameters}
    if own != names:
        message = f"class {item.__name__}: fields {sorted(own)} and parameters of its card {sorted(names)} differ"
        raise BadInput.of(f"{place}: {message}, make them equal and the class a frozen dataclass", key="file")
    for entry in card.undetermined:
        known = QUANTITIES.get(entry.channel, ())
        if entry.quantity not in known:
            message = f"nothing of a quantity {entry.quantity!r} of {entry.channel!r} is measured"
            wanted = "; ".join(f"{name}: {', '.join(found)}" for name, found in QUANTITIES.items())
            raise BadInput.of(f"{place}: class {item.__name__}: {message}, known are {wanted}", key="file")
    return item
