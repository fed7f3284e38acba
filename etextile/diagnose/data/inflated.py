"""Channels of pieces that are inflated or seen by cameras: height over pressure, and the motion of material points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from etextile.diagnose.data.channel import Channel
from etextile.diagnose.data.checks import (
    MAX_LENGTH,
    check_count,
    check_displacement,
    check_rising,
    check_size,
    lines_of,
    refused,
)  # fmt: skip
from etextile.errors import BadInput
from etextile.importers.options import PLAIN, Options
from etextile.importers.sheet import read_sheet
from etextile.importers.table import read_table, table_of
from etextile.motion.diaphragm import Diaphragm, faults
from etextile.types import Array


LOADS = {"pressure_bar": "bar", "displacement_mm": "mm"}
"""First column of a displacement field, and the unit of the travel of a case it belongs to."""
MAX_PRESSURE, MAX_MOMENT = 500.0, 1e7
"""Beyond these a value is in another unit, bar and N mm."""
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
    check_displacement(table, angle, strictly=True, name="angle_deg")
    check_size(table, "moment_Nmm", moment, limit=MAX_MOMENT, remedy="another unit? convert to N mm")
    check_count(table, minimum=FEWEST)
    return JointMoment(table.file, angle, moment, noise, lines=lines_of(table), notes=table.notes)


def read_pressure_height(path: Path, *, noise: float | None = None, options: Options = PLAIN) -> PressureHeight:
    """Read `pressure_bar,height_mm` of one specimen; the pressure must rise from row to row."""
    table = read_table(path, ("pressure_bar", "height_mm"), options=options)
    pressure, height = table.numbers["pressure_bar"], table.numbers["height_mm"]
    check_rising(table, "pressure_bar")
    check_size(table, "pressure_bar", pressure, limit=MAX_PRESSURE, remedy="kPa? convert to bar")
    check_size(table, "height_mm", height, limit=MAX_LENGTH, remedy="um? convert to mm")
    check_count(table, minimum=FEWEST)
    return PressureHeight(table.file, pressure, height, noise, lines=lines_of(table), notes=table.notes)


def read_diaphragm(path: Path, *, options: Options = PLAIN) -> PressureHeight:
    """Read `pressure_bar,height_mm` of a burst tester's diaphragm alone, as the case of a run does."""
    table = read_table(path, ("pressure_bar", "height_mm"), options=options)
    pressure, height = table.numbers["pressure_bar"], table.numbers["height_mm"]
    for row, text in faults(height, pressure):
        raise BadInput.of(text, file=str(path), line=table.line(row), key="diaphragm")
    return PressureHeight(table.file, pressure, height, lines=lines_of(table), notes=table.notes)


def without_diaphragm(curve: PressureHeight, rubber: PressureHeight) -> PressureHeight:
    """Return heights over the pressure that the fabric bears alone; raises BadInput where nothing is left for it."""
    taken = Diaphragm(rubber.height, rubber.pressure).at(np.maximum(curve.height, 0.0))
    pressure = curve.pressure - taken
    for row in np.flatnonzero((np.diff(pressure, prepend=-np.inf) <= 0.0) | (pressure < 0.0))[:1]:
        wrong = f"the diaphragm takes {taken[row]:.4g} of {curve.pressure[row]:.4g} bar, the rest for the fabric falls"
        remedy = "is it the diaphragm of this test, and counted from the same zero?"
        raise BadInput.of(f"{wrong}; {remedy}", file=curve.file, line=curve.line(int(row)), key="pressure_bar")
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
        raise refused(table, int(row), first, "falls", "order the rows by load, leave out unloading")
    limit = MAX_PRESSURE if first == "pressure_bar" else MAX_LENGTH
    check_size(table, first, load, limit=limit, remedy="another unit? convert")
    for name in names:
        check_size(table, name, table.numbers[name], limit=MAX_LENGTH, remedy="um? convert to mm")
    check_count(table, minimum=FEWEST)
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
        lines=lines_of(table),
        notes=table.notes,
    )
