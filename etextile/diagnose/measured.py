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

from etextile.errors import BadInput
from etextile.identify.curves import TensileCurve
from etextile.identify.table import Table, read_table
from etextile.types import Array, IntArray


STATES = ("intact", "plastic", "partial", "open")
MIN_POINTS = 5
# Beyond these a value is in another unit: punch tests reach some 70 mm and 10 kN, fabrics strain to about one.
MAX_LENGTH, MAX_FORCE, MAX_STRAIN = 1000.0, 1e5, 2.0
MIN_DISPLACEMENT, MIN_FORCE = 0.5, 0.5
# Readings before contact may carry an offset of the datum.
MIN_START = -20.0


@dataclass(frozen=True)
class PunchForce:
    """Force over punch displacement of one specimen, (n,) each; `noise` is its standard deviation, N, if stated."""

    file: str
    displacement: Array
    force: Array
    noise: float | None = None


@dataclass(frozen=True)
class FreeEdge:
    """Position of points of the free edge, (n,) each, ordered by displacement."""

    file: str
    displacement: Array
    warp0: Array
    warp: Array
    weft: Array
    height: Array
    noise: float | None = None


@dataclass(frozen=True)
class StrainField:
    """Engineering strain along warp and weft at material points, (n,) each, ordered by displacement."""

    file: str
    displacement: Array
    warp0: Array
    weft0: Array
    strain_warp: Array
    strain_weft: Array
    noise: float | None = None


@dataclass(frozen=True)
class ClampLine:
    """Slip out of the clamp along the clamp line, (n,) each, ordered by displacement."""

    file: str
    displacement: Array
    weft0: Array
    slip: Array
    noise: float | None = None


@dataclass(frozen=True)
class WireStates:
    """State of wires at loops, (n,) each, ordered by displacement; `state` counts up `STATES`."""

    file: str
    displacement: Array
    wire: IntArray
    warp0: Array
    state: IntArray


@dataclass(frozen=True)
class Measurements:
    """All that was measured in one test series; a channel that was not measured is empty or None.

    `tensile` holds specimens by direction ('warp', 'weft', 'bias').
    """

    title: str
    folder: str
    punch_force: tuple[PunchForce, ...] = ()
    free_edge: FreeEdge | None = None
    tensile: Mapping[str, tuple[TensileCurve, ...]] = field(default_factory=dict)
    strain_field: StrainField | None = None
    clamp_line: ClampLine | None = None
    wires: WireStates | None = None

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels that were measured."""
        names = ("punch_force", "free_edge", "tensile", "strain_field", "clamp_line", "wires")
        return tuple(name for name in names if getattr(self, name))


def read_punch_force(path: Path, *, noise: float | None = None) -> PunchForce:
    """Read `displacement_mm,force_N` of one specimen; the displacement must rise from row to row."""
    table = read_table(path, ("displacement_mm", "force_N"))
    displacement, force = table.numbers["displacement_mm"], table.numbers["force_N"]
    _check_count(table)
    _check_displacement(table, displacement, strictly=True)
    _check_size(table, "force_N", force, limit=MAX_FORCE, remedy="mN? convert to N")
    if force.max() < MIN_FORCE:
        raise _refused(table, int(force.argmax()), "force_N", f"peaks at {force.max():.4g}", "kN? convert to N")
    return PunchForce(table.file, displacement, force, noise)


def read_free_edge(path: Path, *, noise: float | None = None) -> FreeEdge:
    """Read `displacement_mm,warp0_mm,warp_mm,weft_mm,height_mm`, the current position of edge points."""
    names = ("displacement_mm", "warp0_mm", "warp_mm", "weft_mm", "height_mm")
    table = _field(path, names, point=("warp0_mm",))
    for name in names[1:]:
        _check_size(table, name, table.numbers[name], limit=MAX_LENGTH, remedy="um? convert to mm")
    return FreeEdge(
        table.file,
        displacement=table.numbers["displacement_mm"],
        warp0=table.numbers["warp0_mm"],
        warp=table.numbers["warp_mm"],
        weft=table.numbers["weft_mm"],
        height=table.numbers["height_mm"],
        noise=noise,
    )


def read_strain_field(path: Path, *, noise: float | None = None) -> StrainField:
    """Read `displacement_mm,warp0_mm,weft0_mm,strain_warp,strain_weft`."""
    names = ("displacement_mm", "warp0_mm", "weft0_mm", "strain_warp", "strain_weft")
    table = _field(path, names, point=("warp0_mm", "weft0_mm"))
    for name in names[3:]:
        _check_size(table, name, table.numbers[name], limit=MAX_STRAIN, remedy="percent? write 0.07 for 7 %")
        _check_above(table, name, table.numbers[name], low=-1.0, reason="an engineering strain stays above -1")
    return StrainField(
        table.file,
        displacement=table.numbers["displacement_mm"],
        warp0=table.numbers["warp0_mm"],
        weft0=table.numbers["weft0_mm"],
        strain_warp=table.numbers["strain_warp"],
        strain_weft=table.numbers["strain_weft"],
        noise=noise,
    )


def read_clamp_line(path: Path, *, noise: float | None = None) -> ClampLine:
    """Read `displacement_mm,weft0_mm,slip_mm`."""
    names = ("displacement_mm", "weft0_mm", "slip_mm")
    table = _field(path, names, point=("weft0_mm",))
    _check_size(table, "slip_mm", table.numbers["slip_mm"], limit=MAX_LENGTH, remedy="um? convert to mm")
    return ClampLine(
        table.file,
        displacement=table.numbers["displacement_mm"],
        weft0=table.numbers["weft0_mm"],
        slip=table.numbers["slip_mm"],
        noise=noise,
    )


def read_wires(path: Path) -> WireStates:
    """Read `displacement_mm,wire,warp0_mm,state` with the states intact, plastic, partial, open; none heals."""
    names = ("displacement_mm", "wire", "warp0_mm", "state")
    table = _field(path, names, point=("wire", "warp0_mm"), texts=("state",), minimum=1)
    wire = table.numbers["wire"]
    for odd in np.flatnonzero(wire != np.round(wire))[:1]:
        raise _refused(table, int(odd), "wire", f"not a whole number (got {wire[odd]:g})", "number the wires")
    for row, word in enumerate(table.texts["state"]):
        if word not in STATES:
            raise _refused(table, row, "state", f"unknown (got {word!r})", f"must be one of {', '.join(STATES)}")
    state = np.array([STATES.index(word) for word in table.texts["state"]], dtype=np.int64)
    found = WireStates(
        table.file, table.numbers["displacement_mm"], wire.astype(np.int64), table.numbers["warp0_mm"], state
    )
    _check_no_healing(table, found)
    return found


def _field(
    path: Path, names: Sequence[str], *, point: Sequence[str], texts: Sequence[str] = (), minimum: int = MIN_POINTS
) -> Table:
    """Read a channel of several points per displacement, ordered by displacement, no point twice at one."""
    table = read_table(path, names, texts=texts)
    _check_count(table, minimum=minimum)
    displacement = table.numbers["displacement_mm"]
    _check_displacement(table, displacement, strictly=False)
    seen: dict[tuple[float, ...], int] = {}
    for row, key in enumerate(zip(displacement, *(table.numbers[name] for name in point), strict=True)):
        if key in seen:
            place = ", ".join(f"{name} {value:g}" for name, value in zip(point, key[1:], strict=True))
            message = f"measured twice at displacement {key[0]:g} ({place}), first in line {table.line(seen[key])}"
            raise _refused(table, row, "", message, "keep one of the rows")
        seen[key] = row
    return table


def _check_count(table: Table, *, minimum: int = MIN_POINTS) -> None:
    """A curve of a few points is a broken file."""
    if len(table) < minimum:
        points = "1 point" if len(table) == 1 else f"{len(table)} points"
        raise _refused(table, len(table) - 1, "", f"only {points}", f"at least {minimum} are needed")


def _check_displacement(table: Table, displacement: Array, *, strictly: bool) -> None:
    """Rows are ordered by displacement, which is in mm."""
    step = np.diff(displacement)
    for row in np.flatnonzero(step <= 0.0 if strictly else step < 0.0)[:1] + 1:
        same = displacement[row] == displacement[row - 1]
        change = "repeats" if same else f"falls from {displacement[row - 1]:g} to"
        remedy = "rows must be ordered by displacement; leave out unloading"
        if same:
            remedy = "one row per displacement; give every specimen a file of its own"
        raise _refused(table, int(row), "displacement_mm", f"{change} {displacement[row]:g}", remedy)
    if displacement[0] < MIN_START:
        raise _refused(
            table, 0, "displacement_mm", f"starts at {displacement[0]:g}", "set it to 0 where contact starts"
        )
    _check_size(table, "displacement_mm", displacement, limit=MAX_LENGTH, remedy="um? convert to mm")
    if strictly and displacement[-1] < MIN_DISPLACEMENT:
        message = f"ends at {displacement[-1]:g}"
        raise _refused(table, len(table) - 1, "displacement_mm", message, "m? convert to mm")


def _check_size(table: Table, name: str, values: Array, *, limit: float, remedy: str) -> None:
    """Refuse magnitudes that only another unit explains."""
    row = int(np.argmax(np.abs(values)))
    if abs(values[row]) > limit:
        message = f"wrong units? {values[row]:.4g} is beyond {limit:g}"
        raise _refused(table, row, name, message, remedy)


def _check_above(table: Table, name: str, values: Array, *, low: float, reason: str) -> None:
    """Refuse values that cannot be."""
    for row in np.flatnonzero(values <= low)[:1]:
        raise _refused(table, int(row), name, f"impossible value {values[row]:g}", reason)


def _check_no_healing(table: Table, wires: WireStates) -> None:
    """A wire that was seen broken does not become whole at a larger displacement."""
    last: dict[tuple[int, float], int] = {}
    for row, key in enumerate(zip(wires.wire.tolist(), wires.warp0.tolist(), strict=True)):
        state = int(wires.state[row])
        if state < last.get(key, 0):
            message = f"{STATES[state]} after {STATES[last[key]]} at wire {key[0]}, warp0_mm {key[1]:g}"
            raise _refused(table, row, "state", message, "damage cannot heal")
        last[key] = state


def _refused(table: Table, row: int, key: str, message: str, remedy: str) -> BadInput:
    """Return the error for one row, with its remedy."""
    return BadInput.of(f"{message}; {remedy}", file=table.file, line=table.line(row), key=key)
