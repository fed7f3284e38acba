"""What a person may say about a measured file; everything left out is found in the file itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


WHITESPACE = " "
DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t", "bar": "|", "space": WHITESPACE, "whitespace": WHITESPACE}
"""Words for the marks between columns; `space` stands for any number of spaces and tabs."""
DECIMALS = {"point": ".", "dot": ".", "comma": ","}
FIRST = "first"
"""Zero: the reading of the first row."""


@dataclass(frozen=True)
class Source:
    """Where a quantity stands in a file: name of the column or its number from 1, its unit if the file is silent."""

    column: str | int
    unit: str | None = None


@dataclass(frozen=True)
class Options:
    """How to read one file; None and empty: as found in the file.

    `names`: quantities of all columns in their order, with units (`force_kN`), None for a column to leave out.
    `sources`: quantity to column. `sign`: +1 or -1 by quantity, '' for all that are counted the other way. `zero`: what
    is taken off a quantity (a number in its unit, or `first`).
    """

    delimiter: str | None = None
    decimal: str | None = None
    encoding: str | None = None
    skip_rows: int | None = None
    names: tuple[str | None, ...] = ()
    sources: Mapping[str, Source] = field(default_factory=dict)
    sign: Mapping[str, int] = field(default_factory=dict)
    zero: Mapping[str, float | str] = field(default_factory=dict)


PLAIN = Options()
"""Nothing said: everything is found in the file."""


def delimiter_of(text: str) -> str:
    """Return the mark a person named; raises ValueError that lists what is allowed."""
    mark = DELIMITERS.get(text.strip().lower(), text) if text.strip() else text
    mark = {"\\t": "\t"}.get(mark, mark)
    if mark not in DELIMITERS.values():
        allowed = "',', ';', tab, '|' or space"
        raise ValueError(f"not a mark between columns (got {text!r}), must be {allowed}")
    return mark


def decimal_of(text: str) -> str:
    """Return the decimal mark a person named; raises ValueError that lists what is allowed."""
    mark = DECIMALS.get(text.strip().lower(), text.strip())
    if mark not in DECIMALS.values():
        raise ValueError(f"not a decimal mark (got {text!r}), must be '.' or ','")
    return mark


def encoding_of(text: str) -> str:
    """Return the name of a text encoding as Python knows it; raises ValueError for an unknown one."""
    import codecs

    try:
        found = codecs.lookup(text)
        "0".encode(found.name)
        b"".decode(found.name)
    except (LookupError, ValueError, TypeError):
        known = "utf-8, utf-16, latin-1, cp1252"
        raise ValueError(f"unknown encoding (got {text!r}), such as {known}") from None
    return found.name


def column_map(text: str) -> tuple[tuple[str | None, ...], dict[str, Source]]:
    """Return names or sources from `displacement_mm,force_N` or `force_N=Load,displacement_mm=2`."""
    parts = [part.strip() for part in text.split(",")]
    if not any("=" in part for part in parts):
        return tuple(None if part in ("", "-", "_") else part for part in parts), {}
    sources = {}
    for part in parts:
        name, mark, column = (piece.strip() for piece in part.partition("="))
        if not (name and mark and column):
            raise ValueError(f"every part must be NAME=COLUMN (got {part!r})")
        sources[name] = Source(int(column) if column.isdigit() else column)
    return (), sources
