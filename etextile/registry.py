"""Named choices (bodies, effects, criteria, solvers): a dictionary filled by explicit imports."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeVar

from etextile.errors import BadInput, nearest


T = TypeVar("T")


class Registry(Mapping[str, T]):
    """Mapping from name to item; an unknown name raises `BadInput` that lists the known ones."""

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self._items: dict[str, T] = {}

    def register(self, name: str, item: T) -> T:
        """Add `item` under `name` and return it; a name can be given once."""
        if name in self._items:
            raise ValueError(f"{self.kind} {name!r} is registered already")
        self._items[name] = item
        return item

    def __getitem__(self, name: str) -> T:
        """Return the item called `name`; raises BadInput when there is none."""
        try:
            return self._items[name]
        except KeyError:
            known = ", ".join(self._items) or "none"
            raise BadInput.of(f"unknown {self.kind} {name!r}, known: {known}{nearest(name, self._items)}") from None

    def __contains__(self, name: object) -> bool:
        """Tell whether `name` is registered."""
        return name in self._items

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names in the order of registration."""
        return iter(self._items)

    def __len__(self) -> int:
        """Return the number of registered items."""
        return len(self._items)
