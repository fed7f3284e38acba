"""The force of a test that goes back and forth: the whole record in time order, with its turning points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from etextile.diagnose.data.channel import Channel
from etextile.errors import BadInput
from etextile.importers.options import PLAIN, Options
from etextile.importers.records import jitter_of, reversals
from etextile.importers.table import FileTable, read_table
from etextile.types import Array, IntArray


MAX_LENGTH, MAX_FORCE = 1000.0, 1e6
"""Beyond these a value is in another unit, mm and N."""
FEWEST, MOST_TURNS = 10, 100
EARLY = 0.02
"""A record starts at no more than this share of its range from where the force begins."""


@dataclass(frozen=True)
class CyclicForce(Channel):
    """Force of a punch or of a pulled clamp in time order, (n,) mm and N, over a motion there and back.

    path: displacements visited in turn from 0 on, mm; branch (n,): which of its parts each reading belongs to.
    """

    displacement: Array
    force: Array
    path: tuple[float, ...]
    branch: IntArray
    noise: float | None = None

    @cached_property
    def travelled(self) -> Array:
        """How far (n,) mm the motion has come along its path at each reading."""
        turns = np.array([0.0, *self.path])
        before = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(turns)))])
        low, high = np.minimum(turns[:-1], turns[1:]), np.maximum(turns[:-1], turns[1:])
        at = np.clip(self.displacement, low[self.branch], high[self.branch])
        return np.asarray(before[self.branch] + np.abs(at - turns[self.branch]))


def read_cyclic_force(path: Path, *, noise: float | None = None, options: Options = PLAIN) -> CyclicForce:
    """Read `displacement_mm,force_N` in time order: loading, the way back, loading again, as it was logged.

    A fall by more than jitter is a way back; displacements count from where the force begins.
    """
    table = read_table(path, ("displacement_mm", "force_N"), options=options)
    travel, force = table.numbers["displacement_mm"], table.numbers["force_N"]
    for name, values, limit in (("displacement_mm", travel, MAX_LENGTH), ("force_N", force, MAX_FORCE)):
        row = int(np.abs(values).argmax())
        if abs(values[row]) > limit:
            raise _refused(table, row, name, f"{values[row]:.4g} is beyond {limit:g}", "another unit? convert")
    if len(travel) < FEWEST:
        raise _refused(table, 0, "", f"only {len(travel)} rows", f"at least {FEWEST} are needed")
    jitter = jitter_of(travel)
    if travel[0] > max(EARLY * float(np.ptp(travel)), jitter) or travel.min() < -jitter:
        row = int(travel.argmin())
        wrong = f"does not go from 0 (starts at {travel[0]:.4g}, lowest {travel[row]:.4g})"
        raise _refused(table, row, "displacement_mm", wrong, "count from where the force begins")
    turns, branch = turns_of(travel, jitter)
    if len(turns) < 2:
        message = "never goes back"
        raise _refused(table, 0, "displacement_mm", message, "a record that only loads is punch_force or clamp_force")
    if len(turns) > MOST_TURNS:
        message = f"turns {len(turns)} times, at most {MOST_TURNS} are run"
        raise _refused(table, 0, "displacement_mm", message, "give the first cycles, or filter its noise")
    return CyclicForce(
        table.file, np.maximum(travel, 0.0), force, turns, branch, noise, lines=tuple(table.lines.tolist()),
        notes=table.notes,
    )  # fmt: skip


def turns_of(travel: Array, jitter: float) -> tuple[tuple[float, ...], IntArray]:
    """Return the displacements at which a motion (n,) turns, its end too, and the branch (n,) of each reading."""
    ends: list[int] = []
    for high, _, low in reversals(travel, jitter):
        ends += [high, low]
    if not ends or travel[ends[-1] :].max() > travel[ends[-1]] + jitter:
        after = ends[-1] if ends else 0
        ends.append(after + int(travel[after:].argmax()))
    turns = tuple(max(float(travel[end]), 0.0) for end in ends)
    branch = np.searchsorted(np.array(ends), np.arange(len(travel)), side="left")
    return turns, np.minimum(branch, len(turns) - 1).astype(np.int64)


def _refused(table: FileTable, row: int, key: str, wrong: str, remedy: str) -> BadInput:
    return BadInput.of(f"{wrong}; {remedy}", file=table.file, line=table.line(row), key=key)
