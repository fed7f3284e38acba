"""The reader of result files: a frozen `Results` whose arrays are fetched when asked for.

Nothing is kept open, so a file can be read while the run is still writing it, and `Results` can be sent to another
process. Only the number of steps, the curves and the piece itself are read on opening.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from etextile.contact.skinning import DUAL, LINEAR, SkinnedMesh
from etextile.errors import BadInput, nearest
from etextile.results import integrity, layout
from etextile.results.layout import BodySurface, CaseRecord, UndeformedGrid
from etextile.results.vtkhdf import read_counters
from etextile.results.wire_history import WireHistory
from etextile.results.wire_layout import WireLayout


REMEDY = "copy it again, go on with `etextile run CASE --resume`, or repeat the run"
FAULTS = (
    KeyError,
    OSError,
    RuntimeError,
    ValueError,
    TypeError,
    IndexError,
    AttributeError,
    OverflowError,
)
"""What h5py and numpy raise over a damaged file."""

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]


@dataclass(frozen=True)
class Curves:
    """One row per increment or per output step: every array has the same length; units stand in `layout.INCREMENTS`."""

    displacement_mm: Floats
    travel_mm: Floats
    punch_force_N: Floats
    clamp_force_N: Floats
    max_penetration_mm: Floats
    external_work: Floats
    stored_energy: Floats
    plastic_work: Floats
    friction_work: Floats
    contact_energy: Floats
    work_doubt: Floats
    softening: Integers
    converged: NDArray[np.bool_]
    iterations: Integers
    linear_solves: Integers
    cut_backs: Integers
    residual_N: Floats
    tolerance_N: Floats
    worst_node: Integers
    wall_s: Floats
    step: Integers
    reason: tuple[str, ...]
    sentence: tuple[str, ...]

    def rows(self, chosen: NDArray[np.bool_]) -> Curves:
        """Return the rows where `chosen` is true."""
        picked: dict[str, Any] = {}
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(value, tuple):
                picked[entry.name] = tuple(text for text, keep in zip(value, chosen, strict=True) if keep)
            else:
                picked[entry.name] = value[chosen]
        return Curves(**picked)


@dataclass(frozen=True)
class PartRecord:
    """Parts on the fabric: names (P,), middles and extents of their lands (P, 2) along warp and weft, mm."""

    names: tuple[str, ...]
    at_mm: Floats
    size_mm: Floats


@dataclass(frozen=True)
class Results:
    """A result file: `steps` output steps, the piece `grid`, curves per step and, on demand, the fields.

    `increments` has a row for every converged increment, `curves` for those whose fields were written.
    """

    path: Path
    steps: int
    completed: bool
    ending: str
    case: CaseRecord = field(repr=False)
    case_sha256: str
    grid: UndeformedGrid = field(repr=False)
    body: BodySurface | None = field(repr=False)
    increments: Curves = field(repr=False)
    curves: Curves = field(repr=False)

    @property
    def case_text(self) -> str:
        """The case file, verbatim."""
        return self.case.text

    @property
    def fingerprint(self) -> str:
        """Hash of all increments but the time they took: what was made from these results names it."""
        found = hashlib.sha256()
        for entry in fields(Curves):
            value = getattr(self.increments, entry.name)
            if entry.name != "wall_s":
                found.update(
                    repr(value).encode() if isinstance(value, tuple) else np.ascontiguousarray(value).tobytes()
                )
        return found.hexdigest()

    @property
    def displacement_mm(self) -> Floats:
        """Punch displacement of every step, (S,) mm."""
        return self.curves.displacement_mm

    @property
    def cells(self) -> Integers:
        """End points of the trusses, (m, 2)."""
        return self.grid.cells

    @property
    def family(self) -> NDArray[np.int8]:
        """0 warp, 1 weft, 2 diagonal, 3 wire, (m,)."""
        return self.grid.family

    def points(self, step: int) -> Floats:
        """Return the deformed points of a step (negative counts from the end), (n, 3) mm."""
        moved: Floats = self.grid.reference + self.array("displacement", step)
        return moved

    def array(self, name: str, step: int) -> NDArray[Any]:
        """Return a point or cell array of a step; an unknown name or step raises BadInput with what there is."""
        place = self._place(name)
        number = self.step_index(step)
        with _open(self.path) as file:
            return integrity.block(file, place, number)

    def step_index(self, step: int) -> int:
        """Return a step number counted from the start; out of range raises BadInput."""
        if not -self.steps <= step < self.steps:
            what = f"steps 0 to {self.steps - 1}" if self.steps else "no steps yet"
            raise BadInput.of(f"step {step} asked for, the file holds {what}", file=str(self.path))
        return step % self.steps

    def unit(self, name: str) -> str:
        """Return the unit of a point or cell array."""
        table = (*layout.POINT_ARRAYS, *layout.CELL_ARRAYS)
        self._place(name)
        return next(entry.unit for entry in table if entry.name == name)

    @cached_property
    def wires(self) -> WireHistory | None:
        """What the wires went through, the flat fabric before all output steps; None when the case has no wires."""
        static = self._wire_arrays
        if static is None:
            return None
        with _open(self.path) as file:
            series = {
                name: integrity.blocks(file, f"etextile/histories/{name}", self.steps).astype(np.float64)
                for name in layout.names(layout.HISTORIES)
            }
            elements = {name: static.get(name) for name in layout.names(layout.ELEMENTS)}
            wires = WireLayout.of_arrays(static)
            return WireHistory.from_flat(self.displacement_mm, series, layout=wires, elements=elements)

    @property
    def parts(self) -> PartRecord | None:
        """Parts on the fabric, None where there are none."""
        return None if self._wire_arrays is None else _parts(self._wire_arrays)

    @cached_property
    def _wire_arrays(self) -> dict[str, Any] | None:
        """The arrays of wires, loops, elements and parts, None without wires; files of version 1.0 lack some."""
        with _open(self.path) as file:
            group = file["etextile"].get("wires")
            if group is None:
                return None
            known = [name for name in layout.names(layout.WIRES) if name not in layout.WIRES_SINCE_1_1]
            known += [name for name in layout.WIRES_SINCE_1_1 if name in group]
            static: dict[str, Any] = {name: integrity.static(group, name) for name in known}
        static |= {"loop_halved": static["loop_halved"].astype(bool), "symmetric": bool(static["symmetric"])}
        if "names" in static:
            static["names"] = tuple(name.decode() for name in static["names"].tolist())
        return static

    def restart(self) -> dict[str, NDArray[Any]] | None:
        """Return the state of the last increment as named arrays for `restart.rebuild`, or None when none was kept."""
        with _open(self.path) as file:
            counters = read_counters(file)
            if counters.restart_slot < 0:
                return None
            return integrity.state(file, counters.restart_slot, counters.increments)

    def _place(self, name: str) -> str:
        points, cells = layout.names(layout.POINT_ARRAYS), layout.names(layout.CELL_ARRAYS)
        if name in points:
            return f"VTKHDF/PointData/{name}"
        if name in cells:
            return f"VTKHDF/CellData/{name}"
        known = (*points, *cells)
        raise BadInput.of(f"no array {name!r}{nearest(name, known)}; there are {', '.join(known)}", file=str(self.path))


def open_results(path: str | Path) -> Results:
    """Open a result file, or the one in an output folder; anything else raises BadInput that says what it is."""
    place = Path(path)
    place = place / layout.FILE_NAME if place.is_dir() else place
    if not place.exists():
        raise BadInput.of("there is no result file", file=str(place))
    with _open(place) as file:
        extra = _checked(file, place)
        integrity.refuse_foreign(file, place.stat().st_size)
        return _read(file, extra, place)


def _read(file: h5py.File, extra: h5py.Group, place: Path) -> Results:
    if integrity.CHECK in extra.attrs and integrity.record_crc(extra) != int(extra.attrs[integrity.CHECK]):
        raise integrity.Damaged("the case or its origin is not as it was written")
    counters = read_counters(file)
    increments = _curves(integrity.rows(extra, counters.increments))
    if np.count_nonzero(increments.step >= 0) != counters.steps:
        raise integrity.Damaged(f"{counters.steps} steps are counted, the table of increments has another number")
    return Results(
        path=place,
        steps=counters.steps,
        completed=bool(extra.attrs["completed"]),
        ending=extra["ending"][0].decode(),
        case=_case(extra),
        case_sha256=str(extra.attrs["case_sha256"]),
        grid=_grid(file),
        body=_body(extra),
        increments=increments,
        curves=increments.rows(increments.step >= 0),
    )


@contextmanager
def _open(path: Path) -> Iterator[h5py.File]:
    """Open for reading without a lock; what cannot be read or is not as it was written raises BadInput."""
    if path.exists() and not path.is_file():
        raise BadInput.of("not a result file (not an ordinary file)", file=str(path))
    try:
        file = h5py.File(path, "r", locking=False)
    except (OSError, RuntimeError, ValueError) as error:
        raise BadInput.of(_why(path, str(error)), file=str(path)) from None
    try:
        with file:
            yield file
    except integrity.Damaged as error:
        raise BadInput.of(f"the result file is damaged: {error}; {REMEDY}", file=str(path)) from None
    except FAULTS as error:
        what = str(error.args[0] if error.args else type(error).__name__)[:160]
        raise BadInput.of(f"an incomplete result file, or a damaged one ({what}): {REMEDY}", file=str(path)) from None


def _why(path: Path, error: str) -> str:
    """Say in words why HDF5 could not open a file."""
    if "truncated" in error:
        return f"the file is truncated ({path.stat().st_size} bytes are left): copy it again or repeat the run"
    if "signature" in error:
        return "not a result file (not HDF5)"
    return f"cannot be read: {error}"


def _checked(file: h5py.File, path: Path) -> h5py.Group:
    """Return the group `/etextile` of a file of our format and version."""
    extra = file.get("etextile")
    if extra is None or extra.attrs.get("format") != layout.FORMAT:
        raise BadInput.of("an HDF5 file, but not a result file of etextile", file=str(path))
    major, minor = (int(number) for number in extra.attrs["version"])
    if major != layout.VERSION[0]:
        ours = f"{layout.VERSION[0]}.{layout.VERSION[1]}"
        raise BadInput.of(f"format version {major}.{minor}, this etextile reads {ours}: repeat the run", file=str(path))
    return extra


def _case(extra: h5py.Group) -> CaseRecord:
    return CaseRecord(
        text=extra["case"].asstr()[()],
        effective=extra["case_effective"].asstr()[()],
        sha256=str(extra.attrs["case_effective_sha256"]),
        source=str(extra.attrs["source"]),
        overrides=tuple(extra["overrides"].asstr()[:]),
        versions={str(name): str(version) for name, version in extra["versions"].attrs.items()},
        seed=int(extra.attrs["seed"]),
        travel_unit=str(extra.attrs.get("travel_unit", "mm")),
        created=str(extra.attrs["created"]),
    )


def _grid(file: h5py.File) -> UndeformedGrid:
    piece = {name: integrity.static(file["etextile/lattice"], name) for name in layout.names(layout.LATTICE)}
    labels = {name: integrity.static(file["VTKHDF/CellData"], name) for name in layout.names(layout.CELL_LABELS)}
    mirror = piece["symmetry"].astype(bool)
    return UndeformedGrid(
        reference=piece["reference"],
        cells=piece["cells"],
        family=labels["family"],
        wire=labels["wire"],
        quads=piece["quads"] if len(piece["quads"]) else None,
        clamped=piece["clamped"].astype(bool),
        symmetry=(bool(mirror[0]), bool(mirror[1])),
        warp_angle_deg=float(piece["warp_angle"]),
    )


def _body(extra: h5py.Group) -> BodySurface | None:
    if "body" not in extra:
        return None
    body = BodySurface(**{name: integrity.static(extra["body"], name) for name in layout.names(layout.BODY)})
    if "skin" not in extra:
        return body
    rest, weight, flexion, dual = (integrity.static(extra["skin"], name) for name in layout.names(layout.SKIN))
    kind = DUAL if dual[0] else LINEAR
    return replace(body, skin=SkinnedMesh(rest, body.faces, weight, float(np.radians(flexion[0])), kind))


def _curves(rows: Mapping[str, NDArray[Any]]) -> Curves:
    columns: dict[str, Any] = {}
    for name, values in rows.items():
        columns[name] = tuple(text.decode() for text in values) if values.dtype.kind == "S" else values
    columns["converged"] = columns["converged"].astype(bool)
    return Curves(**columns)


def _parts(static: Mapping[str, Any]) -> PartRecord | None:
    """Return the parts among the arrays of the wires, None where there are none."""
    if not len(static.get("part_names", ())):
        return None
    names = tuple(name.decode() for name in static["part_names"].tolist())
    return PartRecord(names, static["part_at_mm"], static["part_size_mm"])
