"""Labelled tables: named columns with units, as plain arrays always and as pandas frames where pandas is installed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray


if TYPE_CHECKING:
    from pandas import DataFrame

UNITS = ("mm", "N", "MPa", "kPa", "bar", "mm3", "deg", "Nmm", "ohm", "s")
"""Units as they stand behind the last underscore of a name; what has none is a share, a count or a word."""


@dataclass(frozen=True)
class Table:
    """Columns (n,) by name; `units` by name, empty for shares, counts and words. A missing number is nan.

    As of a frame, the length is the number of rows, and iteration goes over the names of the columns.
    """

    data: dict[str, NDArray[Any]]

    @classmethod
    def of_rows(cls, rows: Sequence[Mapping[str, Any]], columns: Sequence[str]) -> Table:
        """Return the table of some rows; what a row lacks is missing."""
        return cls({name: _column([row.get(name) for row in rows]) for name in columns})

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.data[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.data)

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(next(iter(self.data.values()), ()))

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(self.data)

    @property
    def units(self) -> dict[str, str]:
        """Unit of every column, taken from its name."""
        return {name: unit_of(name) for name in self.data}

    def frame(self) -> DataFrame:
        """Return the table as a pandas DataFrame, units in its `attrs`; ImportError without pandas."""
        from pandas import DataFrame

        found = DataFrame(dict(self.data))
        found.attrs["units"] = self.units
        return found

    def labelled(self) -> DataFrame | Table:
        """Return the frame where pandas is installed, the table itself elsewhere; both give columns by name."""
        try:
            return self.frame()
        except ImportError:
            return self


def unit_of(name: str) -> str:
    """Return the unit that ends the name of a column, empty when there is none."""
    _, _, last = name.rpartition("_")
    return last if last in UNITS and last != name else ""


def _column(values: Sequence[Any]) -> NDArray[Any]:
    """Return a column: numbers as floats with nan for what is missing, whole numbers and words as they are."""
    kinds = {type(value) for value in values if value is not None}
    if kinds <= {int} and None not in values and values:
        return np.array(values, dtype=np.int64)
    if kinds <= {int, float}:
        return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
    found = np.empty(len(values), dtype=object)
    found[:] = values
    return found
