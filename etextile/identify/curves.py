"""Tensile test files in, curves of engineering strain and fabric engineering stress out; nothing is guessed.

Two kinds of file: `strain,stress_MPa`, or `displacement_mm,force_N` with the coupon's width, thickness and gauge
length. Rows are in time order. What looks like another unit is refused here: a strain in percent would pass every later
step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from etextile.errors import BadInput
from etextile.identify.table import Table, header_of, read_table
from etextile.types import Array, IntArray


STRAIN_STRESS = ("strain", "stress_MPa")
DISPLACEMENT_FORCE = ("displacement_mm", "force_N")
MIN_POINTS = 10
# What a woven fabric can show; outside it is another unit. Bias tests reach 0.5, aramid weaves some 1000 MPa.
STRAIN_PEAK = (1e-3, 1.0)
STRESS_PEAK = (0.05, 3000.0)


@dataclass(frozen=True)
class CouponSize:
    """Dimensions of a coupon, mm: they turn force and displacement into stress and strain."""

    width: float
    thickness: float
    gauge_length: float


@dataclass(frozen=True)
class TensileCurve:
    """One specimen: engineering strain (n,) and fabric engineering stress (n,) in MPa, in time order.

    `lines` (n,) are the lines of `file` the points stand in; `thickness` (mm) the one the stress refers to, if known;
    `size` the coupon's, where it was needed.
    """

    file: str
    strain: Array
    stress: Array
    lines: IntArray
    thickness: float | None = None
    size: CouponSize | None = None

    @property
    def name(self) -> str:
        """Short name of the specimen: the file's stem."""
        return Path(self.file).stem

    @classmethod
    def of(cls, name: str, strain: Array, stress: Array) -> TensileCurve:
        """Return the curve of arrays that come from no file."""
        return cls(name, np.asarray(strain, float), np.asarray(stress, float), np.arange(1, len(strain) + 1))


def read_curve(path: Path, *, size: CouponSize | None = None, columns: Sequence[str] = ()) -> TensileCurve:
    """Read one tensile curve.

    `size` is needed for force and displacement. `columns` names the columns of a file that has no header line.
    Raises BadInput with file and line: what `read_table` refuses, fewer than 10 points, suspicious units.
    """
    kind = _kind(tuple(columns) if columns else header_of(path))
    table = read_table(path, kind, headerless=columns)
    if len(table) < MIN_POINTS:
        points = "1 point" if len(table) == 1 else f"{len(table)} points"
        message = f"only {points}: a tensile curve needs at least {MIN_POINTS}"
        raise BadInput.of(message, file=table.file, line=table.line(len(table) - 1))
    if kind == STRAIN_STRESS:
        strain, stress, thickness = table.numbers["strain"], table.numbers["stress_MPa"], None
    else:
        strain, stress, thickness = _from_force(table, size)
    _check_units(table, strain, stress, kind=kind)
    return TensileCurve(table.file, strain, stress, table.lines, thickness, None if kind == STRAIN_STRESS else size)


def _kind(names: tuple[str, ...]) -> tuple[str, str]:
    """Tell from the column names which of the two kinds of file this is."""
    shared = [sum(name in names for name in kind) for kind in (STRAIN_STRESS, DISPLACEMENT_FORCE)]
    by_force = any("displacement" in name.lower() for name in names)
    return DISPLACEMENT_FORCE if shared[1] > shared[0] or (shared[0] == shared[1] and by_force) else STRAIN_STRESS


def _from_force(table: Table, size: CouponSize | None) -> tuple[Array, Array, float]:
    """Convert displacement and force with the coupon's dimensions."""
    if size is None:
        message = "force and displacement need the coupon's width, thickness and gauge_length"
        raise BadInput.of(message, file=table.file, line=table.line(0))
    strain = table.numbers["displacement_mm"] / size.gauge_length
    return strain, table.numbers["force_N"] / (size.width * size.thickness), size.thickness


def _check_units(table: Table, strain: Array, stress: Array, *, kind: tuple[str, str]) -> None:
    """Refuse peaks of strain and stress that no woven fabric shows."""
    from_force = kind == DISPLACEMENT_FORCE
    remedies = {
        "strain": ("check displacement_mm and gauge_length are both mm", "percent? write 0.07 for 7 %"),
        "tiny strain": ("check displacement_mm and gauge_length are both mm", "strain is a fraction: 0.07 for 7 %"),
        "stress": ("check force_N, width and thickness are N and mm", "kPa, Pa or psi? convert to MPa"),
        "tiny stress": ("check force_N is in N, width and thickness in mm", "GPa? convert to MPa"),
    }

    def refuse(row: int, key: str, value: float, limits: tuple[float, float], remedy: str) -> BadInput:
        place = f"{'computed ' if from_force else ''}{key} peaks at {value:.4g}"
        message = f"wrong units? {place}, outside {limits[0]:g} to {limits[1]:g}; {remedies[remedy][not from_force]}"
        return BadInput.of(message, file=table.file, line=table.line(row))

    row = int(np.argmax(strain))
    if not STRAIN_PEAK[0] <= strain[row] <= STRAIN_PEAK[1]:
        remedy = "strain" if strain[row] > STRAIN_PEAK[1] else "tiny strain"
        raise refuse(row, "strain", strain[row], STRAIN_PEAK, remedy)
    row = int(np.argmax(stress))
    if not STRESS_PEAK[0] <= stress[row] <= STRESS_PEAK[1]:
        remedy = "stress" if stress[row] > STRESS_PEAK[1] else "tiny stress"
        raise refuse(row, "stress in MPa", stress[row], STRESS_PEAK, remedy)
