"""Checks that readers of measured channels share: counts, order and size of what they are measured over, units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.errors import BadInput
from etextile.importers.table import FileTable
from etextile.types import Array


MIN_POINTS = 5
# Beyond these a value is in another unit: punch tests reach some 70 mm and 10 kN, fabrics strain to about one.
MAX_LENGTH, MAX_FORCE, MAX_STRAIN = 1000.0, 1e5, 2.0
MIN_DISPLACEMENT, MIN_FORCE = 0.5, 0.5
# deg: a joint bends by no more; a flexion that ends below the least is in another unit.
MAX_ANGLE, LEAST_ANGLE = 180.0, 5.0
# Readings before contact may carry an offset of the datum.
MIN_START = -20.0


@dataclass(frozen=True)
class Load:
    """What a channel is measured over: word, unit, and the values beyond which it is in another unit."""

    word: str
    unit: str
    start: float
    zero: str
    most: float
    too_large: str
    least: float
    too_small: str


LOADS = {
    "displacement_mm": Load(
        "displacement", "mm", MIN_START, "set it to 0 where contact starts", MAX_LENGTH, "um? convert to mm",
        MIN_DISPLACEMENT, "m? convert to mm",
    ),
    "angle_deg": Load(
        "angle", "deg", 0.0, "count flexion from the straight limb", MAX_ANGLE, "count flexion from the straight limb",
        LEAST_ANGLE, "rad? convert to deg",
    ),
}  # fmt: skip
"""First columns of channels of several points per load."""


def check_count(table: FileTable, *, minimum: int = MIN_POINTS) -> None:
    """A curve of a few points is a broken file."""
    if len(table) < minimum:
        points = "1 point" if len(table) == 1 else f"{len(table)} points"
        raise refused(table, len(table) - 1, "", f"only {points}", f"at least {minimum} are needed")


def check_displacement(table: FileTable, displacement: Array, *, strictly: bool, name: str = "displacement_mm") -> None:
    """Rows are ordered by displacement in mm, or by the angle of a joint in deg."""
    load = LOADS[name]
    step = np.diff(displacement)
    for row in np.flatnonzero(step <= 0.0 if strictly else step < 0.0)[:1] + 1:
        same = displacement[row] == displacement[row - 1]
        change = "repeats" if same else f"falls from {displacement[row - 1]:g} to"
        remedy = f"rows must be ordered by {load.word}; leave out unloading"
        if same:
            remedy = f"one row per {load.word}; give every specimen a file of its own"
        raise refused(table, int(row), name, f"{change} {displacement[row]:g}", remedy)
    if displacement[0] < load.start:
        raise refused(table, 0, name, f"starts at {displacement[0]:g}", load.zero)
    check_size(table, name, displacement, limit=load.most, remedy=load.too_large)
    if displacement[-1] < load.least:
        raise refused(table, len(table) - 1, name, f"ends at {displacement[-1]:g}", load.too_small)


def check_rising(table: FileTable, name: str, *, remedy: str = "leave out repeats and unloading") -> None:
    """The column that a curve runs over rises from row to row."""
    for row in np.flatnonzero(np.diff(table.numbers[name]) <= 0.0)[:1] + 1:
        raise refused(table, int(row), name, "does not rise", remedy)


def check_size(table: FileTable, name: str, values: Array, *, limit: float, remedy: str) -> None:
    """Refuse magnitudes that only another unit explains."""
    row = int(np.argmax(np.abs(values)))
    if abs(values[row]) > limit:
        message = f"wrong units? {values[row]:.4g} is beyond {limit:g}"
        raise refused(table, row, name, message, remedy)


def check_above(table: FileTable, name: str, values: Array, *, low: float, reason: str) -> None:
    """Refuse values that cannot be."""
    for row in np.flatnonzero(values <= low)[:1]:
        raise refused(table, int(row), name, f"impossible value {values[row]:g}", reason)


def lines_of(table: FileTable) -> tuple[int, ...]:
    """Return the line of each row."""
    return tuple(int(line) for line in table.lines)


def refused(table: FileTable, row: int, key: str, message: str, remedy: str) -> BadInput:
    """Return the error for one row, with its remedy."""
    return BadInput.of(f"{message}; {remedy}", file=table.file, line=table.line(row), key=key)
