"""Effects of users: a class in a Python file named in the case, or in an installed package (entry point).

The file is run as Python code, as any import is: use files you trust. In a package, list the class under the entry
point group `etextile.effects`, with the effect's id as its name.
"""

from __future__ import annotations

import inspect
from dataclasses import fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from typing import get_args

from etextile.effects.base import QUANTITIES, Card, Channel, Effect
from etextile.errors import BadInput, nearest
from etextile.plugins import installed, own_objects, run_file


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
    own = [item for item in own_objects(run_file(file)) if inspect.isclass(item) and not inspect.isabstract(item)]
    effects = [_checked(item, Path(file).name) for item in own if issubclass(item, Effect)]
    return {item.card.id: item for item in effects}


@lru_cache(maxsize=1)
def from_entry_points() -> dict[str, type[Effect]]:
    """Return the effects of installed packages by name; raises BadInput for one that cannot be loaded."""
    return {name: _checked(item, place) for name, place, item in installed(GROUP)}


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
    known = get_args(Channel)
    for shown in card.signature:
        if shown.channel not in known:
            message = f"its signature names the channel {shown.channel!r}, known are {', '.join(known)}"
            raise BadInput.of(f"{place}: class {item.__name__}: {message}{nearest(shown.channel, known)}", key="file")
    for entry in card.undetermined:
        known = QUANTITIES.get(entry.channel, ())
        if entry.quantity not in known:
            message = f"nothing of a quantity {entry.quantity!r} of {entry.channel!r} is measured"
            wanted = "; ".join(f"{name}: {', '.join(found)}" for name, found in QUANTITIES.items())
            raise BadInput.of(f"{place}: class {item.__name__}: {message}, known are {wanted}", key="file")
    return item
