"""Force over the displacement of a punch: the primary loading of a record as it was logged, and the way back."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from etextile.diagnose.data.channel import Channel
from etextile.diagnose.data.checks import (
    MAX_FORCE,
    MIN_DISPLACEMENT,
    MIN_FORCE,
    check_count,
    check_displacement,
    check_size,
    lines_of,
    refused,
)
from etextile.importers.options import PLAIN, Options
from etextile.importers.records import (
    MIN_FALL,
    PAUSE,
    jitter_of,
    merged,
    point_noise,
    primary,
    reversals,
    single_note,
    single_readings,
    stands_still,
    where_broken,
)
from etextile.importers.table import FileTable, read_table
from etextile.types import Array


# Readings at one displacement differ by less than this share of the peak, those of two specimens by more.
REPEATED = 0.05


@dataclass(frozen=True)
class PunchForce(Channel):
    """Force over punch displacement of one specimen, (n,) each; `noise` is its standard deviation, N, if stated."""

    displacement: Array
    force: Array
    noise: float | None = None


def read_punch_force(path: Path, *, noise: float | None = None, options: Options = PLAIN) -> PunchForce:
    """Read `displacement_mm,force_N` of one specimen: the primary loading of a record as it was logged.

    Unloading and reloading are left out and said, jittering displacements are put in order, repeated ones averaged.
    """
    table = read_table(path, ("displacement_mm", "force_N"), options=options)
    _check_forward(table)
    table = _loading(table)
    displacement, force = table.numbers["displacement_mm"], table.numbers["force_N"]
    check_count(table)
    check_displacement(table, displacement, strictly=True)
    check_size(table, "force_N", force, limit=MAX_FORCE, remedy="mN? convert to N")
    row = int(np.abs(force).argmax())
    if abs(force[row]) < MIN_FORCE:
        raise refused(table, row, "force_N", f"peaks at {force[row]:.4g}", "kN? convert to N")
    if force[row] < 0.0:
        message = f"the largest magnitude is negative (got {force[row]:g})"
        raise refused(table, row, "force_N", message, "force is positive against the punch; change the sign")
    return PunchForce(table.file, displacement, force, noise, lines=lines_of(table), notes=table.notes)


def read_punch_unloading(path: Path, *, noise: float | None = None, options: Options = PLAIN) -> PunchForce:
    """Read `displacement_mm,force_N` of one specimen on the way back from its largest displacement.

    The rows after the largest displacement, down to the lowest that follows, in rising order of displacement.
    """
    table = read_table(path, ("displacement_mm", "force_N"), options=options)
    _check_forward(table)
    travel = table.numbers["displacement_mm"]
    top = len(travel) - 1 - int(np.argmax(travel[::-1]))
    bottom = top + int(np.argmin(travel[top:]))
    if travel[top] - travel[bottom] < MIN_DISPLACEMENT:
        message = f"never falls by {MIN_DISPLACEMENT:g} mm from its largest displacement, {travel[top]:g} mm"
        raise refused(table, top, "displacement_mm", message, "give the record of the way back in time order")
    distinct, force, rows = merged(travel[top : bottom + 1], table.numbers["force_N"][top : bottom + 1])
    table = table.where(top + rows)
    table = replace(table, numbers={"displacement_mm": distinct, "force_N": force})
    check_count(table)
    check_size(table, "force_N", force, limit=MAX_FORCE, remedy="mN? convert to N")
    return PunchForce(table.file, distinct, force, noise, lines=lines_of(table), notes=table.notes)


def _check_forward(table: FileTable) -> None:
    """Refuse a record whose displacement runs to the negative side, with the option that turns it."""
    travel = table.numbers["displacement_mm"]
    row = int(np.argmax(np.abs(travel)))
    if travel[row] < min(travel[0], 0.0) - MIN_DISPLACEMENT:
        both = table.numbers["force_N"][row] < 0.0
        remedy = "sign: -1 (--sign -1)" if both else "sign: {displacement: -1} (--sign displacement=-1)"
        message = f"runs to {travel[row]:.4g} mm, it must rise from where contact starts"
        raise refused(table, row, "displacement_mm", message, f"set {remedy}")


def _loading(table: FileTable) -> FileTable:
    """Return the rows of primary loading in the order of displacement, one per displacement, with notes.

    Single readings far off, what follows a break, and forces that relaxed while the punch was held are left out.

    Raises BadInput where the displacement falls by more than jitter over fewer rows than an unloading has, and where
    rows of one displacement differ as two specimens do.
    """
    table = _unbroken(_without_single(table))
    travel = table.numbers["displacement_mm"]
    falls = []
    for first, seen, last in reversals(travel, jitter_of(travel)):
        if last - first < MIN_FALL:
            message = f"falls from {travel[first]:g} to {travel[seen]:g}"
            raise refused(table, seen, "displacement_mm", message, "rows must be ordered by displacement")
        falls.append((first, last))
    notes = []
    if falls:
        keep = primary(travel, falls)
        start = falls[0][0]
        notes.append(
            f"{np.count_nonzero(~keep)} rows of unloading and reloading from line {table.line(start)} on "
            f"(displacement {travel[start]:.4g} mm) left out: the case only loads"
        )
        table = table.where(keep)
    table = _unrelaxed(table)
    travel = table.numbers["displacement_mm"]
    step = np.diff(travel)
    if np.all(step > 0.0):
        return table.where(np.arange(len(table)), *notes)
    distinct, force, first_rows = merged(travel, table.numbers["force_N"])
    apart = np.abs(table.numbers["force_N"] - np.interp(travel, distinct, force))
    if apart.max() > REPEATED * np.abs(force).max():
        row = int(np.flatnonzero(travel == travel[np.argmax(apart)])[-1])
        message = f"repeats {travel[row]:g} with another force"
        raise refused(table, row, "displacement_mm", message, "give every specimen a file of its own")
    if np.any(step < 0.0):
        back = float(-step.min())
        notes.append(f"the displacement jitters (back by {back:.2g} mm at most): rows put in its order")
    if len(distinct) < len(travel):
        notes.append(f"{len(travel) - len(distinct)} rows repeat a displacement: forces averaged")
    ordered = table.where(first_rows, *notes)
    return replace(ordered, numbers={"displacement_mm": distinct, "force_N": force})


def _without_single(table: FileTable) -> FileTable:
    """Leave out single readings of the force far from both neighbours."""
    off = single_readings(table.numbers["displacement_mm"], table.numbers["force_N"])
    return table.where(~off, single_note(table.lines[off])) if off.any() else table


def _unbroken(table: FileTable) -> FileTable:
    """Leave out what follows a puncture: a force that falls below half of its peak for good while the punch goes on."""
    travel, force = table.numbers["displacement_mm"], table.numbers["force_N"]
    row = where_broken(travel, force, back=jitter_of(travel))
    if row is None:
        return table
    peak = int(np.argmax(force))
    note = f"the specimen broke at {travel[peak]:.4g} mm: {len(force) - peak - 1} rows from line {table.line(row)} on"
    return table.where(np.arange(len(force)) <= peak, f"{note} left out")


def _unrelaxed(table: FileTable) -> FileTable:
    """Leave out forces that fell while the punch was held."""
    travel, force = table.numbers["displacement_mm"], table.numbers["force_N"]
    top = np.maximum.accumulate(force)
    least = max(3.0 * point_noise(force), PAUSE * float(force.max()))
    relaxed = stands_still(travel, force) & (top - force > least)
    held = np.flatnonzero(relaxed)
    if len(held) < MIN_FALL:
        return table
    note = f"held at {travel[held[0]]:.4g} mm: {len(held)} rows of relaxed force left out"
    return table.where(~relaxed, note)
