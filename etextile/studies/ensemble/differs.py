"""What sets two designs apart, key by key: so that a comparison says what it compares."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from loadcases.schema import Case


ASIDE = ("schema_version", "title", "description", "outputs", "sources")
"""Sections that change no answer."""
NAMED = ("name", "id")
"""Keys by which the items of a list are told apart."""


def differences(first: Case, second: Case) -> list[dict[str, Any]]:
    """Return every key in which two cases differ, with both values (None where a design does not have it).

    Items of a list go by their name where they have one (`wires.paths.VCC.crimp`).
    """
    ours, theirs = (dict(_leaves(case.model_dump(by_alias=True, exclude=set(ASIDE)))) for case in (first, second))
    keys = list(dict.fromkeys([*ours, *theirs]))
    return [{"key": key, "A": ours.get(key), "B": theirs.get(key)} for key in keys if ours.get(key) != theirs.get(key)]


def _leaves(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """Yield dotted keys and values of nested data."""
    if isinstance(value, dict) and value:
        for name, item in value.items():
            yield from _leaves(item, f"{key}.{name}" if key else str(name))
    elif isinstance(value, (list, tuple)) and any(isinstance(item, dict) for item in value):
        for number, item in enumerate(value):
            name = next((item[known] for known in NAMED if isinstance(item, dict) and item.get(known)), number)
            yield from _leaves(item, f"{key}.{name}")
    else:
        yield key, list(value) if isinstance(value, tuple) else value


def words(found: Mapping[str, Any]) -> str:
    """Return one difference in words."""
    return f"{found['key']}: {_shown(found['A'])} in A, {_shown(found['B'])} in B"


def _shown(value: Any) -> str:
    if value is None:
        return "nothing"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)
