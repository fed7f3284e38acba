"""How long specimens lasted: reading lives of which most are known to lie between two inspections, or to go on.

A life file has a row per specimen and area: `cycles_low`, the last number of cycles at which it was whole, and
`cycles_high`, the first at which it had failed: equal when the cycle is known, empty when it never failed while it was
watched. A record of resistances (`etextile.life.events`) is turned into such lives by the event rule.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from etextile.errors import BadInput, Problem
from etextile.importers.sheet import Sheet, read_sheet
from etextile.importers.table import FileTable, table_of
from etextile.types import Array, IntArray


REQUIRED = ("specimen", "cycles_low", "cycles_high")
OPTIONAL = ("area", "event", "mode")
FAILED = ("1", "yes", "true", "failed", "failure", "fail", "event", "broken", "break", "open", "lost",
          "exact", "interval", "left")  # fmt: skip
CENSORED = ("0", "no", "false", "censored", "right", "runout", "run-out", "none", "survived", "suspended",
            "suspension", "whole", "intact", "stopped")  # fmt: skip
NEVER = ("", "inf", "+inf", "infinity")
WHOLE = "all"
"""The area of specimens for which none is named."""
MOST_PROBLEMS = 20


@dataclass(frozen=True)
class Lives:
    """Lives of n specimens: `low` < life <= `high` (n,) cycles; equal: known exactly; `high` infinite: goes on."""

    specimen: tuple[str, ...]
    area: tuple[str, ...]
    low: Array
    high: Array
    mode: tuple[str, ...]

    def __len__(self) -> int:
        """Return the number of lives."""
        return len(self.low)

    @property
    def failed(self) -> NDArray[np.bool_]:
        """(n,) True where the life ended while it was watched."""
        return np.asarray(np.isfinite(self.high))

    @property
    def areas(self) -> tuple[str, ...]:
        """The areas in the order in which they come first."""
        return tuple(dict.fromkeys(self.area))

    def of(self, area: str) -> Lives:
        """Return the lives of one area."""
        return self._take(np.flatnonzero([name == area for name in self.area]))

    def by_mode(self, mode: str) -> Lives:
        """Return the lives as one failure mode ends them: other failures stop the watch at `low` (competing risks)."""
        other = np.array([name != mode for name in self.mode])
        return replace(self, high=np.where(other, np.inf, self.high))

    def _take(self, rows: IntArray) -> Lives:
        def some(words: tuple[str, ...]) -> tuple[str, ...]:
            return tuple(words[row] for row in rows)

        return Lives(some(self.specimen), some(self.area), self.low[rows], self.high[rows], some(self.mode))


def read_lives(path: Path) -> Lives:
    """Read a life file; raises BadInput that names file, line, column and value of everything that is wrong."""
    sheet = read_sheet(path)
    names = (*REQUIRED, *(name for name in OPTIONAL if name in header(sheet)))
    table = _pointed(table_of(sheet, names, texts=names), sheet)
    problems: list[Problem] = []
    rows = [_row(table, row, problems) for row in range(len(table))]
    problems += _twice(table)
    if problems:
        raise BadInput(_few(problems, str(path)))
    low, high = np.array(rows, dtype=np.float64).reshape(-1, 2).T
    areas = tuple(word.strip() or WHOLE for word in _words(table, "area"))
    return Lives(_words(table, "specimen"), areas, low, high, tuple(word.strip() for word in _words(table, "mode")))


def header(sheet: Sheet) -> tuple[str, ...]:
    """Return the names of the columns as they are written."""
    return tuple(label.text for label in sheet.head)


def _pointed(table: FileTable, sheet: Sheet) -> FileTable:
    """Return the table with decimal points in its cycles, where the file has decimal commas."""
    if sheet.dialect.decimal == ".":
        return table
    pointed = {name: tuple(word.replace(",", ".") for word in table.texts[name]) for name in REQUIRED[1:]}
    return replace(table, texts={**table.texts, **pointed})


def _row(table: FileTable, row: int, problems: list[Problem]) -> tuple[float, float]:
    """Return low and high of a row; what is wrong with it is added to `problems`."""
    before = len(problems)
    low = _cycles(table, row, "cycles_low", problems)
    high = _cycles(table, row, "cycles_high", problems)
    if len(problems) > before:
        return 0.0, 0.0
    problems += [Problem(words, table.file, table.line(row), key=key) for key, words in _against(table, row, low, high)]
    return low, math.inf if _event(table, row) in CENSORED else high


def _against(table: FileTable, row: int, low: float, high: float) -> Iterator[tuple[str, str]]:
    """Yield column and words for numbers and event that do not fit together."""
    event = _event(table, row)
    if event is not None and event not in (*FAILED, *CENSORED):
        yield "event", f"unknown event (got {event!r}), write failed or censored"
    if high < low:
        yield "cycles_high", f"below cycles_low (got {high:g} < {low:g}); it is the first inspection after the failure"
    if high == 0.0:
        yield "cycles_high", "failed before the first cycle (got 0), a life is greater than 0; leave such specimens out"
    if low == 0.0 and high == math.inf:
        yield "cycles_low", "never failed and never flexed (got 0 cycles), leave the row out"
    if event in FAILED and high == math.inf:
        yield (
            "cycles_high",
            (
                "empty although the specimen failed; write the cycle of the inspection that found it, or cycles_low "
                "again when the failure was seen at that cycle"
            ),
        )
    if event in CENSORED and low < high < math.inf:
        yield (
            "event",
            (
                f"{event!r} although it failed between {low:g} and {high:g} cycles; leave cycles_high empty for a "
                "specimen that goes on, or write failed"
            ),
        )


def _event(table: FileTable, row: int) -> str | None:
    """Return the event of a row in small letters, None where nothing is said."""
    if "event" not in table.texts:
        return None
    return table.texts["event"][row].strip().lower() or None


def _cycles(table: FileTable, row: int, name: str, problems: list[Problem]) -> float:
    """Return a number of cycles, infinite for an empty `cycles_high`."""
    word = table.texts[name][row].strip()
    if name == "cycles_high" and word.lower() in NEVER:
        return _cycles(table, row, "cycles_low", []) if _event(table, row) == "exact" else math.inf
    if name == "cycles_low" and not word:
        return 0.0
    try:
        value = float(word) if word.isascii() and "_" not in word else math.nan
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value >= 0.0):
        remedy = ", or leave it empty when it never failed" if name == "cycles_high" else ""
        message = f"no number of cycles (got {word[:40]!r}), write one of 0 or more{remedy}"
        problems.append(Problem(message, table.file, table.line(row), key=name))
    return value


def _twice(table: FileTable) -> Iterator[Problem]:
    """Yield rows whose specimen and area stand in the file already."""
    seen: dict[tuple[str, str], int] = {}
    for row, key in enumerate(zip(_words(table, "specimen"), _words(table, "area"), strict=True)):
        if key in seen:
            where = f" of area {key[1]!r}" if key[1] else ""
            message = f"specimen {key[0]!r}{where} stands in line {seen[key]} already; one life for each"
            yield Problem(message, table.file, table.line(row), key="specimen")
        seen.setdefault(key, table.line(row))


def _words(table: FileTable, name: str) -> tuple[str, ...]:
    return table.texts.get(name, ("",) * len(table))


def _few(problems: list[Problem], file: str) -> list[Problem]:
    """Return the first problems in the order of the file, and how many more there are."""
    problems = sorted(problems, key=lambda problem: problem.line or 0)
    more = len(problems) - MOST_PROBLEMS
    return problems if more <= 0 else [*problems[:MOST_PROBLEMS], Problem(f"and {more} more problems", file)]
