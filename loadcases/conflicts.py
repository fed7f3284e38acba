"""Values that are right each for itself but not together."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from pydantic_core import PydanticCustomError


@dataclass(frozen=True)
class Conflict:
    """What does not fit together; `keys` are routes below the section that was checked, the first is pointed at."""

    message: str
    keys: tuple[tuple[str, ...], ...]


def refuse(conflicts: Iterable[Conflict]) -> None:
    """Raise the pydantic error that carries all conflicts; does nothing when there are none."""
    found = tuple(conflicts)
    if found:
        text = "; ".join(f"{'.'.join(item.keys[0])}: {item.message}" for item in found)
        raise PydanticCustomError("conflicts", "{text}", {"text": text, "conflicts": found})
