"""When a conductor has failed: a resistance beyond a limit, confirmed, not one bad reading.

Supplier and user agree on a limit and on how many readings in a row must lie beyond it. From a record of readings the
life then lies between the last reading within the limit and the first of the readings that confirm the failure:

    low = cycle of the last reading within the limit before the event,  high = cycle of its first reading beyond it.

A reading beyond the limit that the next ones do not confirm (a contact of the clamp, a spike) is no event; what is
beyond the limit at the very end without enough readings to confirm it is no event either, and is told.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from etextile.errors import BadInput
from etextile.importers.sheet import read_sheet
from etextile.importers.table import header_of, table_of
from etextile.life.lives import WHOLE, Lives, header
from etextile.types import Array


RECORD = ("specimen", "cycle", "resistance_ohm")


@dataclass(frozen=True)
class EventRule:
    """A resistance limit, in ohm (`limit_ohm`) or as a multiple of the first reading (`limit_ratio`), and readings."""

    limit_ohm: float | None = None
    limit_ratio: float | None = None
    confirm: int = 3

    def __post_init__(self) -> None:
        """Refuse rules that say nothing or too much."""
        if (self.limit_ohm is None) == (self.limit_ratio is None):
            raise BadInput.of("give either a limit in ohm or one as a multiple of the first reading", key="limit")
        if self.confirm < 1:
            raise BadInput.of(f"at least 1 reading confirms an event (got {self.confirm})", key="confirm")

    def limit(self, first_ohm: float) -> float:
        """Return the limit in ohm for a specimen whose first reading is `first_ohm`."""
        return self.limit_ohm if self.limit_ohm is not None else float(self.limit_ratio or 0.0) * first_ohm

    def words(self) -> str:
        """Say the rule."""
        limit = f"{self.limit_ohm:g} ohm" if self.limit_ohm is not None else f"{self.limit_ratio:g} times the first"
        return (
            f"resistance above {limit}, confirmed by {self.confirm} reading{'s' if self.confirm > 1 else ''} in a row"
        )

    def life(self, cycle: Array, ohm: Array) -> tuple[float, float, bool]:
        """Return low and high of a life and whether it ends with readings that could not be confirmed.

        cycle, ohm: (n,) in the order of the cycles; an infinite resistance is an open circuit.
        """
        beyond = ohm > self.limit(float(ohm[0]))
        run = 0
        for reading, over in enumerate(beyond):
            run = run + 1 if over else 0
            if run == self.confirm:
                first = reading - run + 1
                return (float(cycle[first - 1]) if first else 0.0), float(cycle[first]), False
        last = len(beyond) - run
        return (float(cycle[last - 1]) if last else 0.0), math.inf, run > 0


def is_record(path: Path) -> bool:
    """Tell whether a file holds readings of resistance rather than lives."""
    return "resistance_ohm" in header_of(path)


def read_record(path: Path, rule: EventRule) -> tuple[Lives, tuple[str, ...]]:
    """Read specimen, cycle, resistance_ohm (and area) and return the lives by a rule, with remarks.

    Rows may come in any order; an empty or infinite resistance is an open circuit. Raises BadInput.
    """
    sheet = read_sheet(path)
    names = (*RECORD, *(name for name in ("area",) if name in header(sheet)))
    table = table_of(sheet, names, texts=tuple(name for name in names if name != "cycle"))
    ohm = np.array([_ohm(word, str(path), table.line(row)) for row, word in enumerate(table.texts["resistance_ohm"])])
    areas = tuple(word.strip() or WHOLE for word in table.texts.get("area", ("",) * len(table)))
    keys = list(zip(table.texts["specimen"], areas, strict=True))
    cycle, found, remarks = table.numbers["cycle"], [], []
    for key in dict.fromkeys(keys):
        rows = np.array([row for row, own in enumerate(keys) if own == key])
        rows = rows[np.argsort(cycle[rows], kind="stable")]
        _check(cycle[rows], ohm[rows], path, table.line(int(rows[0])), key[0])
        low, high, pending = rule.life(cycle[rows], ohm[rows])
        if pending:
            remarks.append(f"specimen {key[0]} ends beyond the limit without enough readings to confirm it: censored")
        if low == 0.0 and high == math.inf:
            remarks.append(f"specimen {key[0]} was left out: no reading within the limit and none confirmed beyond it")
            continue
        found.append((key[0], key[1], low, high))
    if not found:
        raise BadInput.of("no specimen has a life by this rule", file=str(path), key="resistance_ohm")
    specimens, where, lows, highs = zip(*found, strict=True)
    return Lives(specimens, where, np.array(lows), np.array(highs), ("",) * len(found)), tuple(remarks)


def _ohm(word: str, file: str, line: int) -> float:
    word = word.strip().lower()
    if word in ("", "inf", "open", "ol"):
        return math.inf
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not value >= 0.0:
        message = f"no resistance (got {word[:40]!r}), write ohm, or open for an open circuit"
        raise BadInput.of(message, file=file, line=line, key="resistance_ohm")
    return value


def _check(cycle: Array, ohm: Array, path: Path, line: int, specimen: str) -> None:
    if (cycle < 0.0).any() or (np.diff(cycle) <= 0.0).any():
        message = f"cycles of specimen {specimen} must be 0 or more and each read once"
        raise BadInput.of(message, file=str(path), line=line, key="cycle")
    if not math.isfinite(ohm[0]):
        message = f"specimen {specimen} starts with an open circuit; leave it out, it was never whole"
        raise BadInput.of(message, file=str(path), line=line, key="resistance_ohm")
