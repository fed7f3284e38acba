"""The force of a test that goes back and forth: the whole record in time order, with its turning points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from etextile.diagnose.data.channel import Channel
from etextile.diagnose.data.checks import MAX_FORCE, MAX_LENGTH, check_count, check_size, lines_of, refused
from etextile.importers.options import PLAIN, Options
from etextile.importers.records import jitter_of, reversals
from etextile.importers.table import read_table
from etextile.types import Array, IntArray


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
    check_count(table, minimum=FEWEST)
    check_size(table, "displacement_mm", travel, limit=MAX_LENGTH, remedy="um? convert to mm")
    check_size(table, "force_N", force, limit=MAX_FORCE, remedy="mN? convert to N")
    jitter = jitter_of(travel)
    if travel[0] > max(EARLY * float(np.ptp(travel)), jitter) or travel.min() < -jitter:
        row = int(travel.argmin())
        wrong = f"does not go from 0 (starts at {travel[0]:.4g}, lowest {travel[row]:.4g})"
        raise refused(table, row, "displacement_mm", wrong, "count from where the force begins")
    turns, branch = turns_of(travel, jitter)
    if len(turns) < 2:
        message = "never goes back"
        raise refused(table, 0, "displacement_mm", message, "a record that only loads is punch_force or clamp_force")
    if len(turns) > MOST_TURNS:
        message = f"turns {len(turns)} times, at most {MOST_TURNS} are run"
        raise refused(table, 0, "displacement_mm", message, "give the first cycles, or filter its noise")
    return CyclicForce(
        table.file, np.maximum(travel, 0.0), force, turns, branch, noise, lines=lines_of(table),
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
