"""Tensile test files in, curves of engineering strain and fabric engineering stress out; nothing is guessed.

Three kinds of file: `strain,stress_MPa`, or with the coupon's dimensions `displacement_mm,force_N` or `strain,force_N`.
Rows are in time order. What looks like another unit, another sign or an absolute position is refused here: a strain in
percent would pass every later step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from etextile.errors import BadInput
from etextile.importers.columns import is_stated, offers
from etextile.importers.options import PLAIN, Options
from etextile.importers.sheet import Sheet, read_sheet
from etextile.importers.table import FileTable, table_of
from etextile.types import Array, IntArray


STRAIN_STRESS = ("strain", "stress_MPa")
DISPLACEMENT_FORCE = ("displacement_mm", "force_N")
STRAIN_FORCE = ("strain", "force_N")
KINDS = (STRAIN_STRESS, DISPLACEMENT_FORCE, STRAIN_FORCE)
AGREE = 0.02
"""Share of the largest value within which two ways to the same curve agree."""
MIN_POINTS = 10
FAR_START, NO_LOAD = 0.2, 0.05
"""A record begins far along without load: shares of how far it runs and of the largest load."""
# What a woven fabric can show; outside it is another unit. Bias tests reach 0.5, aramid weaves some 1000 MPa.
STRAIN_PEAK = (1e-3, 1.0)
STRESS_PEAK = (0.05, 3000.0)


@dataclass(frozen=True)
class CouponSize:
    """Dimensions of a coupon, mm: they turn force and displacement into stress and strain.

    `machine_stiffness`: N/mm, of frame, load cell and grips; what they give is taken off the crosshead's travel.
    """

    width: float
    thickness: float
    gauge_length: float
    machine_stiffness: float | None = None


@dataclass(frozen=True)
class TensileCurve:
    """One specimen: engineering strain (n,) and fabric engineering stress (n,) in MPa, in time order.

    `lines` (n,) are the lines of `file` the points stand in; `thickness` (mm) the one the stress refers to, if known;
    `size` the coupon's, where it was needed; `notes`: how the file was read where that is worth a word; `on_specimen`:
    strain was measured on the specimen, or the machine's share was taken off it.
    """

    file: str
    strain: Array
    stress: Array
    lines: IntArray
    thickness: float | None = None
    size: CouponSize | None = None
    notes: tuple[str, ...] = ()
    on_specimen: bool = False

    @property
    def name(self) -> str:
        """Short name of the specimen: the file's stem."""
        return Path(self.file).stem

    @classmethod
    def of(cls, name: str, strain: Array, stress: Array) -> TensileCurve:
        """Return the curve of arrays that come from no file."""
        return cls(name, np.asarray(strain, float), np.asarray(stress, float), np.arange(1, len(strain) + 1))


def read_curve(
    path: Path,
    *,
    size: CouponSize | None = None,
    columns: Sequence[str | None] = (),
    options: Options = PLAIN,
    on_specimen: bool = False,
) -> TensileCurve:
    """Read one tensile curve.

    `size` is needed for force. `columns` names all columns of a file in their order, `options` says more about it.
    `on_specimen`: strain, or displacement, was measured on the specimen.
    Raises BadInput with file and line: what `read_table` refuses, fewer than 10 points, suspicious units, a turned
    sign, an absolute position, and strain that a file gives in two ways that differ.
    """
    sheet = read_sheet(path, replace(options, names=tuple(columns)) if columns else options)
    kind, *others = _kinds(sheet)
    curve = _curve(sheet, kind, size)
    for other in others if sheet.body else ():
        if size is not None or other == STRAIN_STRESS:
            _check_same(sheet, curve, _curve(sheet, other, size), kind=kind, other_kind=other)
    return replace(curve, on_specimen=on_specimen or curve.on_specimen)


def _kinds(sheet: Sheet) -> list[tuple[str, str]]:
    """Return the kinds a file can be, the one to take first; the likeliest alone when it is none."""
    names = sheet.options.names or tuple(label.text for label in sheet.head)
    whole = [kind for kind in KINDS if all(offers(sheet, name) for name in kind)]
    told = [kind for kind in whole if sheet.options.sources and all(is_stated(sheet, name) for name in kind)]
    if told:
        return told[:1]
    plain = [kind for kind in whole if all(name in names for name in kind)]
    if whole:
        return plain[:1] if len(plain) == 1 else whole
    by_force = any("displacement" in str(name).lower() for name in names)
    shared = [sum(offers(sheet, name) for name in kind) for kind in KINDS[:2]]
    return [DISPLACEMENT_FORCE if shared[1] > shared[0] or (shared[0] == shared[1] and by_force) else STRAIN_STRESS]


def _curve(sheet: Sheet, kind: tuple[str, str], size: CouponSize | None) -> TensileCurve:
    """Return the curve of one kind of file."""
    table = table_of(sheet, kind)
    if len(table) < MIN_POINTS:
        points = "1 point" if len(table) == 1 else f"{len(table)} points"
        message = f"only {points}: a tensile curve needs at least {MIN_POINTS}"
        raise BadInput.of(message, file=table.file, line=table.line(len(table) - 1))
    _check_signs(table, kind)
    if not sheet.options.zero:
        _check_start(table, kind)
    if kind == STRAIN_STRESS:
        strain, stress, thickness, used = table.numbers["strain"], table.numbers["stress_MPa"], None, None
    else:
        used = _size_needed(sheet, table, size)
        thickness = used.thickness
        strain = (
            table.numbers["strain"] if kind == STRAIN_FORCE else table.numbers["displacement_mm"] / used.gauge_length
        )
        stress = table.numbers["force_N"] / (used.width * used.thickness)
        if kind == DISPLACEMENT_FORCE and used.machine_stiffness is not None:
            strain = strain - table.numbers["force_N"] / (used.machine_stiffness * used.gauge_length)
    _check_units(table, strain, stress, kind=kind)
    known = used is not None and used.machine_stiffness is not None
    return TensileCurve(table.file, strain, stress, table.lines, thickness, used, table.notes, known)


def _size_needed(sheet: Sheet, table: FileTable, size: CouponSize | None) -> CouponSize:
    """Return the coupon's dimensions, or ask for them with what the file itself says."""
    if size is not None:
        return size
    message = "force and displacement need the coupon's width, thickness and gauge_length"
    said = [f"line {row.line}: {' '.join(row.cells)[:60]}" for row in sheet.block[:6]]
    raise BadInput.of(
        message + (f" (the file says in {'; '.join(said)})" if said else ""), file=table.file, line=table.line(0)
    )


def _check_signs(table: FileTable, kind: tuple[str, str]) -> None:
    """Refuse curves on the negative side and positions that start far from zero, with the option that mends it."""
    along, load = (table.numbers[name] for name in kind)
    row = int(np.argmax(np.abs(along)))
    spread = float(np.ptp(along))
    first = float(along[0])
    if abs(first) > 2.0 * spread > 0.0:
        message = (
            f"starts at {first:.6g} and moves by {spread:.4g}: an absolute position? set zero: first (--zero first)"
        )
        raise BadInput.of(message, file=table.file, line=table.line(0), key=kind[0])
    negative = [name for name in kind if table.numbers[name][np.argmax(np.abs(table.numbers[name]))] < 0.0]
    if kind[1] in negative:
        worst = int(np.argmax(np.abs(load)))
        message = (
            f"{' and '.join(negative)} {'are' if len(negative) > 1 else 'is'} negative on the whole (down to "
            f"{load[worst]:.4g}): compression counted positive? tension is positive here, set sign: -1 (--sign -1)"
        )
        raise BadInput.of(message, file=table.file, line=table.line(worst), key=kind[1])
    if negative:
        message = f"runs to {along[row]:.4g} while the force is positive: counted the other way?"
        message += f" set sign: {{{kind[0].partition('_')[0]}: -1}}"
        raise BadInput.of(message, file=table.file, line=table.line(row), key=kind[0])


def _check_start(table: FileTable, kind: tuple[str, str]) -> None:
    """Ask where a record begins far along without load: its zero was not set, or its rows run backwards."""
    along, load = (table.numbers[name] for name in kind)
    first, spread = float(along[0]), float(np.ptp(along))
    if first > FAR_START * spread > 0.0 and abs(load[0]) < NO_LOAD * float(load.max()):
        name = kind[0].partition("_")[0]
        message = (
            f"starts at {first:.4g} without load, the largest is {along.max():.4g}: set zero: first (--zero first) "
            f"where the specimen was straight there, zero: {{{name}: 0}} where it was slack until then, or put the "
            "rows in time order"
        )
        raise BadInput.of(message, file=table.file, line=table.line(0), key=kind[0])


def _check_same(
    sheet: Sheet, curve: TensileCurve, other: TensileCurve, *, kind: tuple[str, str], other_kind: tuple[str, str]
) -> None:
    """Ask when a file gives the same curve in two ways that differ."""
    if len(curve.strain) != len(other.strain):
        return
    pairs = (("strain", curve.strain, other.strain), ("stress", curve.stress, other.stress))
    for name, one, two in pairs:
        row = int(np.argmax(np.abs(one - two)))
        if abs(one[row] - two[row]) > AGREE * np.abs(one).max():
            ways = " or ".join(f"columns: {{{kind_[0]}: ..., {kind_[1]}: ...}}" for kind_ in (kind, other_kind))
            message = (
                f"two readings are possible: {name} {one[row]:.4g} from {' and '.join(kind)}, {two[row]:.4g} from "
                f"{' and '.join(other_kind)}; say which: {ways} in measured.yaml"
            )
            raise BadInput.of(message, file=sheet.file, line=int(curve.lines[row]))


def _check_units(table: FileTable, strain: Array, stress: Array, *, kind: tuple[str, str]) -> None:
    """Refuse peaks of strain and stress that no woven fabric shows."""
    from_force = kind != STRAIN_STRESS
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
