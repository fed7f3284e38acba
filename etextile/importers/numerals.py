"""Numbers as they are written: decimal mark, groups of thousands, exponents; nothing that merely looks like one.

Digits are ASCII; `1_000`, digits of other scripts and words are no numbers. A group of thousands has three digits and
the number does not start with zero, so `0,125` can only be a decimal comma while `1,125` can be either.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from etextile.types import Array


_MISSING = (
    "nan -nan +nan na n/a n.a. #n/a #n/v #nv - -- --- . null none nan(ind) -nan(ind) nan(snan) 1.#ind -1.#ind 1.#qnan "
    "-1.#qnan 1.#snan"
)
MISSING = frozenset(("", *_MISSING.split()))
"""How programs write that nothing was measured (lower case)."""
INFINITE = frozenset(("inf", "+inf", "-inf", "infinity", "+infinity", "-infinity", "1.#inf", "-1.#inf"))
STANDS_FOR_NONE = re.compile(r"-9{3,6}(?:[.,]0*)?|[+]?9[.,]9e[+]?37", re.IGNORECASE)
"""Numbers that programs write where nothing was measured, when they lie far beyond all others of a column."""
SPREADSHEET = re.compile(r"#(?:DIV/0!|REF!|BEZUG!|VALUE!|WERT!|NAME\?|NUM!|ZAHL!|NULL!|N/A|NV)", re.IGNORECASE)
"""Errors in the cells of spreadsheets."""
GROUPS = {".": ",'’ \u00a0\u202f", ",": ".'’ \u00a0\u202f"}
"""Marks between thousands that go with a decimal mark."""
MINUS = str.maketrans("\u2212", "-")
EXPONENT = str.maketrans("dD", "ee")
"""Fortran writes `1.0D+02`."""


@lru_cache(maxsize=8)
def _plain(decimal: str, *, column: bool) -> re.Pattern[str]:
    """Return the pattern of a number without groups, or of a whole column of them, one a line."""
    mark = re.escape(decimal)
    trailing = "[0-9]*" if decimal == "." else "[0-9]+"
    number = rf"[+-]?(?:[0-9]+(?:{mark}{trailing})?|{mark}[0-9]+)(?:[eE][+-]?[0-9]+|[dD][+-][0-9]+)?"
    return re.compile(rf"(?:{number}\n)*" if column else number)


@lru_cache(maxsize=8)
def _grouped(decimal: str) -> re.Pattern[str]:
    """Return the pattern of a number in groups of thousands."""
    return re.compile(
        rf"[+-]?[1-9][0-9]{{0,2}}(?P<mark>[{GROUPS[decimal]}])[0-9]{{3}}(?:(?P=mark)[0-9]{{3}})*(?:{re.escape(decimal)}[0-9]+)?"
    )


def value_of(cell: str, decimal: str) -> float | None:
    """Return the number in a cell, NaN for `nothing measured`, an infinity for itself, None for anything else."""
    text = cell.translate(MINUS)
    if _plain(decimal, column=False).fullmatch(text):
        return float(text.replace(decimal, ".").translate(EXPONENT))
    if match := _grouped(decimal).fullmatch(text):
        return float(text.replace(match["mark"], "").replace(decimal, "."))
    lower = text.lower()
    if lower in MISSING:
        return math.nan
    return math.inf if lower in INFINITE else None


def is_number(cell: str, decimal: str) -> bool:
    """Tell whether a cell holds a number or the word for one that is missing; an empty cell does not."""
    return cell != "" and value_of(cell, decimal) is not None


def column_of(cells: Sequence[str], decimal: str) -> tuple[Array, list[int]]:
    """Return values (n,), NaN where nothing was measured, and the rows that hold no finite number."""
    joined = "\n".join(cells) + "\n"
    if _plain(decimal, column=True).fullmatch(joined):
        plain = (joined if decimal == "." else joined.replace(decimal, ".")).translate(EXPONENT)
        values = np.array(plain.split("\n")[:-1], dtype=np.float64)
        return values, np.flatnonzero(np.isinf(values)).tolist()
    found = [value_of(cell, decimal) for cell in cells]
    wrong = [i for i, value in enumerate(found) if value is None or math.isinf(value)]
    return np.array([math.nan if value is None else value for value in found]), wrong


def without_stand_ins(values: Array, cells: Sequence[str]) -> Array:
    """Return values (n,) with NaN for numbers such as -9999 that lie beyond all others by more than their range."""
    if np.isnan(values).all() or max(-np.nanmin(values), np.nanmax(values)) < 999.0:
        return values
    stands = np.array([STANDS_FOR_NONE.fullmatch(cell) is not None for cell in cells])
    rest = values[~stands & ~np.isnan(values)]
    if not stands.any() or not len(rest):
        return values
    reach = max(float(np.ptp(rest)), float(np.abs(rest).max()))
    beyond = stands & ((values < rest.min() - reach) | (values > rest.max() + reach))
    return np.where(beyond, np.nan, values)


def fault(cell: str) -> str:
    """Say what is wrong with a cell that is no finite number."""
    shown = repr(cell if len(cell) <= 40 else f"{cell[:37]}...")
    if cell.lower() in INFINITE:
        return f"not a finite number (got {cell})"
    if not cell.isascii() and any(char.isdecimal() and not char.isascii() for char in cell):
        return f"digits of another script (got {shown}), write 0 to 9"
    if re.fullmatch(r"[+-]?[0-9][0-9_]*_[0-9_.]*[0-9]", cell):
        return f"underscores in a number (got {shown}), write the digits alone"
    if SPREADSHEET.match(cell):
        return f"an error of a spreadsheet (got {shown})"
    return f"text in a column of numbers (got {shown})"
