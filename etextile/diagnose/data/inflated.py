"""Channels of pieces that are inflated or seen by cameras: height over pressure, and the motion of material points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from etextile.diagnose.data.channel import Channel
from etextile.errors import BadInput
from etextile.importers.options import PLAIN, Options
from etextile.importers.sheet import read_sheet
from etextile.importers.table import read_table, table_of
from etextile.motion.diaphragm import Diaphragm, faults
from etextile.types import Array


LOADS = {"pressure_bar": "bar", "displacement_mm": "mm"}
"""First column of a displacement field, and the unit of the travel of a case it belongs to."""
MAX_PRESSURE, MAX_LENGTH = 500.0, 1000.0
"""Beyond these a value is in another unit, bar and mm."""
MAX_ANGLE, MAX_MOMENT = 180.0, 1e7
"""deg, N mm: a joint bends by no more, and 10 kN m is another unit."""
LEAST_ANGLE = 5.0
"""A flexion that ends below this, deg, is in another unit."""
FEWEST = 3


@dataclass(frozen=True)
class PressureHeight(Channel):
    """Height of the highest point over pressure of one specimen, (n,) bar and mm.

    `diaphragm`: file of a diaphragm whose pressure was taken off, empty without one.
    """

    pressure: Array
    height: Array
    noise: float | None = None
    diaphragm: str = ""


@dataclass(frozen=True)
class DisplacementField(Channel):
    """Positions of material points of one specimen, (n,) each, ordered by load.

    load: bar or mm, as `unit` says; warp0, weft0: material coordinates; warp, weft, height: where the points are, mm.
    """

    unit: str
    load: Array
    warp0: Array
    weft0: Array
    warp: Array
    weft: Array
    height: Array
    noise: float | None = None

    @property
    def places(self) -> Array:
        """Material coordinates (n, 2), mm."""
        return np.stack([self.warp0, self.weft0], axis=1)

    @property
    def motion(self) -> Array:
        """Displacements (n, 3) along warp, weft and up, mm."""
        return np.stack([self.warp - self.warp0, self.weft - self.weft0, self.height], axis=1)


@dataclass(frozen=True)
class JointMoment(Channel):
    """Moment that a worn piece takes to bend a joint over the angle, of one specimen, (n,) deg and N mm."""

    angle: Array
    moment: Array
    noise: float | None = None


def read_joint_moment(path: Path, *, noise: float | None = None, options: Options = PLAIN) -> JointMoment:
    """Read `angle_deg,moment_Nmm` of one specimen: the first flexion from the straight limb, what the bare limb takes
    off; the angle must rise from row to row.
    """
    table = read_table(path, ("angle_deg", "moment_Nmm"), options=options)
    angle, moment = table.numbers["angle_deg"], table.numbers["moment_Nmm"]
    for row in np.flatnonzero(np.diff(angle) <= 0.0)[:1] + 1:
        raise _refused(path, table.line(int(row)), "angle_deg", "does not rise", "leave out repeats and the way back")
    for row in np.flatnonzero(angle < 0.0)[:1]:
        raise _refused(path, table.line(int(row)), "angle_deg", "is below 0", "count flexion from the straight limb")
    _check(path, "angle_deg", angle, limit=MAX_ANGLE, remedy="count flexion from the straight limb", line=table.line)
    if angle.max() < LEAST_ANGLE:
        row = int(angle.argmax())
        raise _refused(path, table.line(row), "angle_deg", f"ends at {angle[row]:.4g}", "rad? convert to deg")
    _check(path, "moment_Nmm", moment, limit=MAX_MOMENT, remedy="another unit? convert to N mm", line=table.line)
    if len(angle) < FEWEST:
        raise _refused(path, None, "angle_deg", f"only {len(angle)} rows", f"at least {FEWEST} are needed")
    return JointMoment(table.file, angle, moment, noise, lines=tuple(table.lines.tolist()), notes=table.notes)


def read_pressure_height(path: Path, *, noise: float | None = None, options: Options = PLAIN) -> PressureHeight:
    """Read `pressure_bar,height_mm` of one specimen; the pressure must rise from row to row."""
    table = read_table(path, ("pressure_bar", "height_mm"), options=options)
    pressure, height = table.numbers["pressure_bar"], table.numbers["height_mm"]
    for row in np.flatnonzero(np.diff(pressure) <= 0.0)[:1] + 1:
        raise _refused(path, table.line(int(row)), "pressure_bar", "does not rise", "leave out repeats and unloading")
    _check(path, "pressure_bar", pressure, limit=MAX_PRESSURE, remedy="kPa? convert to bar", line=table.line)
    _check(path, "height_mm", height, limit=MAX_LENGTH, remedy="um? convert to mm", line=table.line)
    if len(pressure) < FEWEST:
        raise _refused(path, None, "pressure_bar", f"only {len(pressure)} rows", f"at least {FEWEST} are needed")
    return PressureHeight(table.file, pressure, height, noise, lines=tuple(table.lines.tolist()), notes=table.notes)


def read_diaphragm(path: Path, *, options: Options = PLAIN) -> PressureHeight:
    """Read `pressure_bar,height_mm` of a burst tester's diaphragm alone, as the case of a run does."""
    table = read_table(path, ("pressure_bar", "height_mm"), options=options)
    pressure, height = table.numbers["pressure_bar"], table.numbers["height_mm"]
    for row, text in faults(height, pressure):
        raise BadInput.of(text, file=str(path), line=table.line(row), key="diaphragm")
    return PressureHeight(table.file, pressure, height, lines=tuple(table.lines.tolist()), notes=table.notes)


def without_diaphragm(curve: PressureHeight, rubber: PressureHeight) -> PressureHeight:
    """Return heights over the pressure that the fabric bears alone; raises BadInput where nothing is left for it."""
    taken = Diaphragm(rubber.height, rubber.pressure).at(np.maximum(curve.height, 0.0))
    pressure = curve.pressure - taken
    for row in np.flatnonzero((np.diff(pressure, prepend=-np.inf) <= 0.0) | (pressure < 0.0))[:1]:
        wrong = f"the diaphragm takes {taken[row]:.4g} of {curve.pressure[row]:.4g} bar, the rest for the fabric falls"
        remedy = "is it the diaphragm of this test, and counted from the same zero?"
        raise _refused(Path(curve.file), curve.line(int(row)), "pressure_bar", wrong, remedy)
    beyond = float(curve.height.max()) > float(rubber.height[-1])
    more = f", beyond {rubber.height[-1]:.4g} mm on with its last slope" if beyond else ""
    note = f"the diaphragm's pressure was taken off, {taken.max():.3g} of {curve.pressure.max():.4g} bar at most{more}"
    return replace(curve, pressure=pressure, diaphragm=rubber.file, notes=(*curve.notes, note))


def read_displacement_field(path: Path, *, noise: float | None = None, options: Options = PLAIN) -> DisplacementField:
    """Read `pressure_bar` or `displacement_mm`, then `warp0_mm,weft0_mm,warp_mm,weft_mm,height_mm` (positions)."""
    names = ("warp0_mm", "weft0_mm", "warp_mm", "weft_mm", "height_mm")
    sheet = read_sheet(path, options)
    there = {label.text for label in sheet.head} | set(options.sources)
    first = "displacement_mm" if "displacement_mm" in there else "pressure_bar"
    table = table_of(sheet, (first, *names))
    load = table.numbers[first]
    for row in np.flatnonzero(np.diff(load) < 0.0)[:1] + 1:
        raise _refused(path, table.line(int(row)), first, "falls", "order the rows by load, leave out unloading")
    limit = MAX_PRESSURE if first == "pressure_bar" else MAX_LENGTH
    _check(path, first, load, limit=limit, remedy="another unit? convert", line=table.line)
    for name in names:
        _check(path, name, table.numbers[name], limit=MAX_LENGTH, remedy="um? convert to mm", line=table.line)
    if len(load) < FEWEST:
        raise _refused(path, None, first, f"only {len(load)} rows", f"at least {FEWEST} are needed")
    warp0, weft0, warp, weft, height = (table.numbers[name] for name in names)
    return DisplacementField(
        table.file,
        LOADS[first],
        load,
        warp0,
        weft0,
        warp,
        weft,
        height,
        noise,
        lines=tuple(table.lines.tolist()),
        notes=table.notes,
    )


def _check(path: Path, name: str, values: Array, *, limit: float, remedy: str, line: Callable[[int], int]) -> None:
    """Refuse magnitudes that only another unit explains."""
    row = int(np.abs(values).argmax())
    if abs(values[row]) > limit:
        raise _refused(path, line(row), name, f"{values[row]:.4g} is beyond {limit:g}", remedy)


def _refused(path: Path, line: int | None, key: str, wrong: str, remedy: str) -> BadInput:
    return BadInput.of(f"{wrong}; {remedy}", file=str(path), line=line, key=key)
