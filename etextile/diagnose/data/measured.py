"""Measured channels of a test as frozen arrays, read strictly from their column files.

Coordinates: specimen centre, x along warp, y along weft, z up; `warp0`, `weft0` are material (undeformed) coordinates.
Strains are engineering strains, lengths mm, forces N. Every refusal names file and line; what is accepted here needs no
further checks later: finite, ordered by displacement, no point measured twice, units plausible.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from etextile.diagnose.data.bent import MomentCurvature
from etextile.diagnose.data.channel import Channel
from etextile.diagnose.data.checks import (
    LOADS,
    MAX_LENGTH,
    MAX_STRAIN,
    MIN_POINTS,
    check_above,
    check_count,
    check_displacement,
    check_size,
    lines_of,
    refused,
)
from etextile.diagnose.data.cyclic import CyclicForce
from etextile.diagnose.data.inflated import DisplacementField, JointMoment, PressureHeight
from etextile.diagnose.data.marks import MarkSlip
from etextile.diagnose.data.pulled import ClampForce
from etextile.diagnose.data.punched import PunchForce
from etextile.identify.curves import TensileCurve
from etextile.importers.options import PLAIN, Options
from etextile.importers.sheet import read_sheet
from etextile.importers.table import FileTable, read_table
from etextile.types import Array, IntArray
from etextile.vocabulary import BEND, CYCLE, FIELD, FORCE, HEIGHT, MOMENT, PULL, SLIP, STATES


# A free edge that is pushed up may dip by this length, mm, and by this share of all its heights.
DIP, DIP_SHARE = 1.0, 0.25


@dataclass(frozen=True)
class FreeEdge(Channel):
    """Position of points of the free edge, (n,) each, ordered by displacement."""

    displacement: Array
    warp0: Array
    warp: Array
    weft: Array
    height: Array
    noise: float | None = None


@dataclass(frozen=True)
class StrainField(Channel):
    """Engineering strain along warp and weft at material points, (n,) each, ordered by displacement."""

    displacement: Array
    warp0: Array
    weft0: Array
    strain_warp: Array
    strain_weft: Array
    noise: float | None = None


@dataclass(frozen=True)
class ClampLine(Channel):
    """Slip out of the clamp along the clamp line, (n,) each, ordered by displacement."""

    displacement: Array
    weft0: Array
    slip: Array
    noise: float | None = None


@dataclass(frozen=True)
class WireStates(Channel):
    """State of wires at loops, (n,) each, ordered by displacement (or angle, as `unit` says).

    `state` counts up `STATES`.
    """

    displacement: Array
    wire: IntArray
    warp0: Array
    state: IntArray
    unit: str = "mm"


@dataclass(frozen=True)
class MeasuredTest:
    """A test beside the first: its name, what of the case is other in it (`key.path=value`), and its channels.

    `without`: effects that cannot act in it, such as friction under a lubricated punch.
    """

    name: str
    case: tuple[str, ...]
    measured: Measurements
    without: tuple[str, ...] = ()


@dataclass(frozen=True)
class Measurements:
    """All that was measured in one test series; a channel that was not measured is empty or None.

    `tensile` holds specimens by direction ('warp', 'weft', 'bias'); `file` is the one in `folder` that names them all;
    `punch_unloading`: forces on the way back, in rising order of displacement; `tests`: further tests,
    the last of them described in the folder `latest`.
    """

    title: str
    folder: str
    punch_force: tuple[PunchForce, ...] = ()
    free_edge: FreeEdge | None = None
    tensile: Mapping[str, tuple[TensileCurve, ...]] = field(default_factory=dict)
    strain_field: StrainField | None = None
    clamp_line: ClampLine | None = None
    wires: WireStates | None = None
    pressure_height: tuple[PressureHeight, ...] = ()
    displacement_field: tuple[DisplacementField, ...] = ()
    joint_moment: tuple[JointMoment, ...] = ()
    mark_slip: MarkSlip | None = None
    clamp_force: tuple[ClampForce, ...] = ()
    moment_curvature: tuple[MomentCurvature, ...] = ()
    cyclic_force: tuple[CyclicForce, ...] = ()
    centre: tuple[float, float] = (0.0, 0.0)
    file: str = ""
    punch_unloading: tuple[PunchForce, ...] = ()
    tests: tuple[MeasuredTest, ...] = ()
    latest: str = ""

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that were measured."""
        names = (
            "punch_force", "punch_unloading", "free_edge", "tensile", "strain_field", "clamp_line", "wires",
            PULL, HEIGHT, FIELD, MOMENT, BEND, CYCLE, SLIP,
        )  # fmt: skip
        return tuple(name for name in names if getattr(self, name))

    @property
    def notes(self) -> tuple[str, ...]:
        """How the files were read and what was left out, each with the name of its file."""
        one = (self.free_edge, self.strain_field, self.clamp_line, self.mark_slip, self.wires)
        curves = (curve for specimens in self.tensile.values() for curve in specimens)
        many = (FORCE, "punch_unloading", HEIGHT, FIELD, MOMENT, PULL, BEND, CYCLE)
        items = (
            *(item for name in many for item in getattr(self, name)),
            *(item for item in one if item is not None),
            *curves,
        )
        return tuple(f"{Path(item.file).name}: {note}" for item in items for note in item.notes)


def read_free_edge(path: Path, *, noise: float | None = None, options: Options = PLAIN) -> FreeEdge:
    """Read `displacement_mm,warp0_mm,warp_mm,weft_mm,height_mm`, the current position of edge points."""
    names = ("displacement_mm", "warp0_mm", "warp_mm", "weft_mm", "height_mm")
    table = _field(path, names, options, point=("warp0_mm",))
    for name in names[1:]:
        check_size(table, name, table.numbers[name], limit=MAX_LENGTH, remedy="um? convert to mm")
    _check_up(table, table.numbers["height_mm"], noise or 0.0)
    return FreeEdge(
        table.file,
        displacement=table.numbers["displacement_mm"],
        warp0=table.numbers["warp0_mm"],
        warp=table.numbers["warp_mm"],
        weft=table.numbers["weft_mm"],
        height=table.numbers["height_mm"],
        noise=noise,
        lines=lines_of(table),
        notes=table.notes,
    )


def read_strain_field(path: Path, *, noise: float | None = None, options: Options = PLAIN) -> StrainField:
    """Read `displacement_mm,warp0_mm,weft0_mm,strain_warp,strain_weft`."""
    names = ("displacement_mm", "warp0_mm", "weft0_mm", "strain_warp", "strain_weft")
    table = _field(path, names, options, point=("warp0_mm", "weft0_mm"))
    for name in names[3:]:
        check_size(table, name, table.numbers[name], limit=MAX_STRAIN, remedy="percent? write 0.07 for 7 %")
        check_above(table, name, table.numbers[name], low=-1.0, reason="an engineering strain stays above -1")
    return StrainField(
        table.file,
        displacement=table.numbers["displacement_mm"],
        warp0=table.numbers["warp0_mm"],
        weft0=table.numbers["weft0_mm"],
        strain_warp=table.numbers["strain_warp"],
        strain_weft=table.numbers["strain_weft"],
        noise=noise,
        lines=lines_of(table),
        notes=table.notes,
    )


def read_clamp_line(path: Path, *, noise: float | None = None, options: Options = PLAIN) -> ClampLine:
    """Read `displacement_mm,weft0_mm,slip_mm`."""
    names = ("displacement_mm", "weft0_mm", "slip_mm")
    table = _field(path, names, options, point=("weft0_mm",))
    check_size(table, "slip_mm", table.numbers["slip_mm"], limit=MAX_LENGTH, remedy="um? convert to mm")
    return ClampLine(
        table.file,
        displacement=table.numbers["displacement_mm"],
        weft0=table.numbers["weft0_mm"],
        slip=table.numbers["slip_mm"],
        noise=noise,
        lines=lines_of(table),
        notes=table.notes,
    )


def read_mark_slip(path: Path, *, noise: float | None = None, options: Options = PLAIN) -> MarkSlip:
    """Read `angle_deg,warp0_mm,weft0_mm,slip_mm` of the first flexion from the straight limb."""
    names = ("angle_deg", "warp0_mm", "weft0_mm", "slip_mm")
    table = _field(path, names, options, point=("warp0_mm", "weft0_mm"))
    for name in names[1:]:
        check_size(table, name, table.numbers[name], limit=MAX_LENGTH, remedy="um? convert to mm")
    angle, warp0, weft0, slip = (table.numbers[name] for name in names)
    return MarkSlip(table.file, angle, warp0, weft0, slip, noise, lines=lines_of(table), notes=table.notes)


def read_wires(path: Path, *, options: Options = PLAIN) -> WireStates:
    """Read `displacement_mm,wire,warp0_mm,state` with the states intact, plastic, partial, open; none heals.

    Of a worn piece the first column is `angle_deg`.
    """
    sheet = read_sheet(path, options)
    there = {label.text for label in sheet.head} | {str(name) for name in (*options.names, *options.sources)}
    load = "angle_deg" if "angle_deg" in there and "displacement_mm" not in there else "displacement_mm"
    names = (load, "wire", "warp0_mm", "state")
    table = _field(path, names, options, point=("wire", "warp0_mm"), texts=("state",), minimum=1)
    wire = table.numbers["wire"]
    for odd in np.flatnonzero(wire != np.round(wire))[:1]:
        raise refused(table, int(odd), "wire", f"not a whole number (got {wire[odd]:g})", "number the wires")
    for row, word in enumerate(table.texts["state"]):
        if word not in STATES:
            raise refused(table, row, "state", f"unknown (got {word!r})", f"must be one of {', '.join(STATES)}")
    state = np.array([STATES.index(word) for word in table.texts["state"]], dtype=np.int64)
    found = WireStates(
        table.file, table.numbers[load], wire.astype(np.int64), table.numbers["warp0_mm"], state, LOADS[load].unit,
        lines=lines_of(table), notes=table.notes,
    )  # fmt: skip
    _check_no_healing(table, found)
    return found


def _field(
    path: Path,
    names: Sequence[str],
    options: Options,
    *,
    point: Sequence[str],
    texts: Sequence[str] = (),
    minimum: int = MIN_POINTS,
) -> FileTable:
    """Read a channel of several points per load, ordered by it, no point twice at one; the load's name comes first."""
    table = read_table(path, names, texts=texts, options=options)
    check_count(table, minimum=minimum)
    displacement = table.numbers[names[0]]
    check_displacement(table, displacement, strictly=False, name=names[0])
    seen: dict[tuple[float, ...], int] = {}
    for row, key in enumerate(zip(displacement, *(table.numbers[name] for name in point), strict=True)):
        if key in seen:
            place = ", ".join(f"{name} {value:g}" for name, value in zip(point, key[1:], strict=True))
            at = f"{LOADS[names[0]].word} {key[0]:g} ({place})"
            message = f"measured twice at {at}, first in line {table.line(seen[key])}"
            raise refused(table, row, "", message, "keep one of the rows")
        seen[key] = row
    return table


def _check_up(table: FileTable, height: Array, noise: float) -> None:
    """Refuse heights that are negative on the whole, by more than noise: z counted downwards."""
    row = int(height.argmin())
    if height[row] < -max(DIP, 3.0 * noise) and height.sum() < -DIP_SHARE * np.abs(height).sum():
        message = f"negative on the whole (down to {height[row]:g})"
        raise refused(table, row, "height_mm", message, "z is up, towards where the punch pushes; change the sign")


def _check_no_healing(table: FileTable, wires: WireStates) -> None:
    """A wire that was seen broken does not become whole at a larger displacement."""
    last: dict[tuple[int, float], int] = {}
    for row, key in enumerate(zip(wires.wire.tolist(), wires.warp0.tolist(), strict=True)):
        state = int(wires.state[row])
        if state < last.get(key, 0):
            message = f"{STATES[state]} after {STATES[last[key]]} at wire {key[0]}, warp0_mm {key[1]:g}"
            raise refused(table, row, "state", message, "damage cannot heal")
        last[key] = state
