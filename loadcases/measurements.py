"""Folders of measurements: `measured.yaml` read strictly, then every channel's files; all that is wrong at once.

    title: punch test
    channels:
      punch_force: {files: [punch_1.csv, punch_2.csv], noise: 2 N}
      tensile: {warp: [warp_1.csv], weft: [weft_1.csv], bias: [bias_1.csv]}

Tensile files of force and displacement need `width`, `thickness` and `gauge_length`, for all specimens in `tensile` or
for one in the list (`{file: warp_3.csv, width: 28 mm}`). How a file is read is found in it; every entry may say more
(`delimiter`, `decimal`, `encoding`, `skip_rows`, `columns`, `sign`, `zero`).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from etextile.diagnose.data.bent import read_moment_curvature
from etextile.diagnose.data.cyclic import read_cyclic_force
from etextile.diagnose.data.inflated import (
    PressureHeight,
    read_diaphragm,
    read_displacement_field,
    read_joint_moment,
    read_pressure_height,
    without_diaphragm,
)
from etextile.diagnose.data.measured import (
    MeasuredTest,
    Measurements,
    WireStates,
    read_clamp_line,
    read_free_edge,
    read_mark_slip,
    read_strain_field,
    read_wires,
)
from etextile.diagnose.data.pulled import ClampForce, read_clamp_force
from etextile.diagnose.data.punched import PunchForce, read_punch_force, read_punch_unloading
from etextile.diagnose.data.specimens import odd_specimens
from etextile.errors import BadInput, Problem, nearest
from etextile.identify.curves import CouponSize, TensileCurve, read_curve
from etextile.importers.options import Options
from etextile.types import Array
from loadcases.messages import problem_at
from loadcases.schema_measured import (
    BendFiles,
    Channels,
    ClampForceFiles,
    CyclicFiles,
    EdgeFile,
    FieldFiles,
    HeightFiles,
    MarkFile,
    MeasuredFolder,
    MomentFiles,
    PunchFile,
    PunchForceFiles,
    SlipFile,
    Specimen,
    StrainFile,
    TensileFiles,
    WiresFile,
)
from loadcases.shipped import measured_folder
from loadcases.validate import checked, in_order
from loadcases.yaml_text import Document, Route, read_document, shown


NAME = "measured.yaml"
DIRECTIONS = ("warp", "weft", "bias")
READINGS = {"free_edge": ("warp", "weft", "height"), "strain_field": ("strain_warp", "strain_weft")}
"""What is compared with its stated noise; the slip of a clamp that holds is nothing but noise."""
LOUD = 0.9
"""Share of the readings' root mean square beyond which a stated noise is in another unit, or hides the channel."""
TABLE = (
    f"a {NAME} (or its folder) is expected, which says what was tested and names files like this one (etextile schema "
    "measured); etextile inspect FILE shows how it would be read, and identify takes tensile curves by --warp FILE, "
    "--weft FILE or --bias FILE"
)
Read = TypeVar("Read")


def load_measurements(path: str | Path) -> Measurements:
    """Return the measurements in a folder (or behind its measured.yaml), with those that they are added to.

    Raises BadInput with everything that is wrong in measured.yaml and in the files it names.
    """
    return _loaded(Path(path), ())


def _loaded(path: Path, before: tuple[Path, ...]) -> Measurements:
    """Return the measurements of a folder; `before`: the files that led to it by `after`."""
    file = _find(path)
    spec, document, problems = _spec(file)
    reading = _Reading(file, document, problems)
    result = reading.measurements(spec)
    if spec.after is not None and file.resolve() in before:
        problems.append(problem_at(("after",), "leads back to this folder, name the first measurements", document))
    if problems:
        raise BadInput(in_order(problems))
    if spec.after is None:
        return result
    own = file.parent / spec.after
    first = _loaded(own if own.exists() else measured_folder(spec.after), (*before, file.resolve()))
    return replace(first, tests=(*first.tests, *result.tests), latest=str(file.parent))


def measured_spec(path: str | Path) -> MeasuredFolder:
    """Return what the measured.yaml of a folder says; the files that it names are not looked at."""
    return _spec(_find(Path(path)))[0]


def _spec(file: Path) -> tuple[MeasuredFolder, Document, list[Problem]]:
    """Return what a measured.yaml says and what is wrong in it; raises BadInput where nothing can be made of it."""
    document, _ = read_document(file)
    spec, problems = checked(document, MeasuredFolder)
    if spec is None:
        raise BadInput(in_order(problems))
    return spec, document, problems


def changes(case: Mapping[str, Any], path: str = "") -> Iterator[str]:
    """Yield what a test changes in the case as texts `key.path=value`, from key paths or nested keys."""
    for key, value in case.items():
        if isinstance(value, Mapping) and value:
            yield from changes(value, f"{path}{key}.")
        else:
            yield f"{path}{key}={value if isinstance(value, str) else json.dumps(value)}"


def _find(path: Path) -> Path:
    """Return the measured.yaml of a folder."""
    file = path / NAME if path.is_dir() else path
    if path.is_file() and path.suffix.lower() not in (".yaml", ".yml"):
        raise BadInput.of(TABLE, file=shown(path))
    if file.is_file():
        return file
    if path.is_dir():
        found = sorted(item.name for item in path.iterdir() if item.suffix in (".yaml", ".yml", ".csv"))[:5]
        inside = f", it holds {', '.join(found)}" if found else ", it is empty"
        raise BadInput.of(f"no {NAME} in this folder{inside}{nearest(NAME, found)}", file=shown(path))
    near = nearest(path.name, [item.name for item in path.parent.iterdir()]) if path.parent.is_dir() else ""
    raise BadInput.of(f"no such folder of measurements, it must hold {NAME}{near}", file=shown(path))


class _Reading:
    """Reads the files that a measured.yaml names and collects what is wrong with them."""

    def __init__(self, file: Path, document: Document, problems: list[Problem]) -> None:
        self.file, self.folder, self.document, self.problems = file, file.parent, document, problems
        self.seen: dict[Path, Route] = {}
        self.at: Route = ("channels",)

    def measurements(self, spec: MeasuredFolder) -> Measurements:
        """Return all channels; a channel that cannot be read is left out and its problem noted."""
        tests = tuple(
            MeasuredTest(
                test.name, tuple(changes(test.case)),
                self._channels(spec.title, test.channels, ("tests", i, "channels")), test.without,
            )
            for i, test in enumerate(spec.tests)
        )  # fmt: skip
        if spec.channels is None:
            return Measurements(spec.title, str(self.folder), file=shown(self.file), tests=tests)
        return replace(self._channels(spec.title, spec.channels, ("channels",)), tests=tests)

    def _channels(self, title: str, named: Channels, at: Route) -> Measurements:
        """Return the channels of one test, which stand at a place of measured.yaml."""
        self.at = at
        force, back = named.punch_force, named.punch_unloading
        return Measurements(
            title,
            str(self.folder),
            punch_force=() if force is None else self._punch_force(force),
            punch_unloading=() if back is None else self._unloading(back),
            free_edge=self._one("free_edge", named.free_edge, read_free_edge),
            tensile={} if named.tensile is None else self._tensile(named.tensile),
            strain_field=self._one("strain_field", named.strain_field, read_strain_field),
            clamp_line=self._one("clamp_line", named.clamp_line, read_clamp_line),
            wires=self._wires(named.wires),
            pressure_height=self._heights(named.pressure_height),
            joint_moment=self._specimens("joint_moment", named.joint_moment, read_joint_moment),
            cyclic_force=self._specimens("cyclic_force", named.cyclic_force, read_cyclic_force),
            moment_curvature=self._specimens("moment_curvature", named.moment_curvature, read_moment_curvature),
            mark_slip=self._one("mark_slip", named.mark_slip, read_mark_slip),
            displacement_field=self._specimens("displacement_field", named.displacement_field, read_displacement_field),
            clamp_force=() if named.clamp_force is None else self._clamp_force(named.clamp_force),
            centre=(0.0, 0.0) if named.displacement_field is None else named.displacement_field.centre,
            file=shown(self.file),
        )

    def _punch_force(self, spec: PunchForceFiles) -> tuple[PunchForce, ...]:
        route: Route = (*self.at, "punch_force", "files")
        found = [self._punch(item, spec, (*route, i)) for i, item in enumerate(spec.files)]
        curves = tuple(item for item in found if item is not None)
        if len(curves) == len(found):
            self.problems.extend(odd_specimens(curves))
            self._check_noise("punch_force", spec.noise, [curve.force for curve in curves], " N")
        return curves

    def _unloading(self, spec: PunchForceFiles) -> tuple[PunchForce, ...]:
        """Return the ways back; their records may be those whose loading is another channel."""
        found = [self._back(item, spec, (*self.at, "punch_unloading", "files", i)) for i, item in enumerate(spec.files)]
        return tuple(item for item in found if item is not None)

    def _back(self, item: str | PunchFile, common: PunchForceFiles, route: Route) -> PunchForce | None:
        own = (item if isinstance(item, PunchFile) else PunchFile(file=item)).over(common)
        path = (self.folder / own.file).resolve()
        loading = self.seen.pop(path, None) if self.seen.get(path, ())[-3:-2] == ("punch_force",) else None
        found = self._read(
            own.file, route, lambda path: read_punch_unloading(path, noise=common.noise, options=own.options())
        )
        if loading is not None:
            self.seen[path] = route
        return found

    def _punch(self, item: str | PunchFile, common: PunchForceFiles, route: Route) -> PunchForce | None:
        own = (item if isinstance(item, PunchFile) else PunchFile(file=item)).over(common)
        return self._read(
            own.file, route, lambda path: read_punch_force(path, noise=common.noise, options=own.options())
        )

    def _one(
        self, channel: str, spec: EdgeFile | SlipFile | StrainFile | MarkFile | None, reader: Callable[..., Read]
    ) -> Read | None:
        if spec is None:
            return None
        route, options = (*self.at, channel, "file"), spec.options()
        found = self._read(spec.file, route, lambda path: reader(path, noise=spec.noise, options=options))
        if found is not None and channel in READINGS:
            readings = [getattr(found, name) for name in READINGS[channel]]
            self._check_noise(channel, spec.noise, readings, "" if isinstance(spec, StrainFile) else " mm")
        return found

    def _specimens(
        self,
        channel: str,
        spec: HeightFiles | FieldFiles | MomentFiles | BendFiles | CyclicFiles | ClampForceFiles | None,
        reader: Callable[..., Read],
    ) -> tuple[Read, ...]:
        """Return the specimens of a channel whose files are all of one kind."""
        if spec is None:
            return ()
        routes: list[tuple[str, Route]] = [(name, (*self.at, channel, "files", i)) for i, name in enumerate(spec.files)]
        options = spec.options()
        found = [
            self._read(name, route, lambda path: reader(path, noise=spec.noise, options=options))
            for name, route in routes
        ]
        return tuple(item for item in found if item is not None)

    def _heights(self, spec: HeightFiles | None) -> tuple[PressureHeight, ...]:
        """Return heights over the pressure that the fabric bears: what a diaphragm bears of it is taken off."""
        curves = self._specimens("pressure_height", spec, read_pressure_height)
        if spec is None or spec.diaphragm is None:
            return curves
        route = (*self.at, "pressure_height", "diaphragm")
        rubber = self._read(spec.diaphragm, route, lambda path: read_diaphragm(path, options=spec.options()))
        try:
            return curves if rubber is None else tuple(without_diaphragm(curve, rubber) for curve in curves)
        except BadInput as error:
            self.problems.extend(error.problems)
            return curves

    def _clamp_force(self, spec: ClampForceFiles) -> tuple[ClampForce, ...]:
        def reader(path: Path, *, noise: float | None, options: Options) -> ClampForce:
            return read_clamp_force(path, noise=noise, strips=spec.strips, options=options)

        return self._specimens("clamp_force", spec, reader)

    def _check_noise(self, channel: str, noise: float | None, readings: Sequence[Array], unit: str) -> None:
        """Refuse a stated noise that the readings hardly reach themselves."""
        size = float(np.sqrt(np.mean(np.square(np.concatenate(readings)))))
        if noise is not None and noise > LOUD * size:
            message = (
                f"as large as what was read (got {noise:g}{unit}, the root mean square of the readings is "
                f"{size:.4g}{unit}); are noise and readings in the units they should be? without a noise to state, "
                "leave it out"
            )
            self.problems.append(problem_at((*self.at, channel, "noise"), message, self.document))

    def _wires(self, spec: WiresFile | None) -> WireStates | None:
        if spec is None:
            return None
        return self._read(spec.file, (*self.at, "wires", "file"), lambda path: read_wires(path, options=spec.options()))

    def _tensile(self, spec: TensileFiles) -> dict[str, tuple[TensileCurve, ...]]:
        curves = {}
        for direction in DIRECTIONS:
            specimens = getattr(spec, direction)
            found = [self._curve(item, spec, (*self.at, "tensile", direction, i)) for i, item in enumerate(specimens)]
            if found:
                curves[direction] = tuple(item for item in found if item is not None)
        return curves

    def _curve(self, item: str | Specimen, common: TensileFiles, route: Route) -> TensileCurve | None:
        own = (item if isinstance(item, Specimen) else Specimen(file=item)).over(common)
        sizes = [getattr(own, name) or getattr(common, name) for name in ("width", "thickness", "gauge_length")]
        if any(sizes) and not all(sizes):
            message = "width, thickness and gauge_length belong together, give all three"
            self.problems.append(problem_at(route, message, self.document))
            return None
        stiffness = own.machine_stiffness or common.machine_stiffness
        if stiffness is not None and not all(sizes):
            message = "machine_stiffness is for displacement and force: give width, thickness and gauge_length too"
            self.problems.append(problem_at(route, message, self.document))
            return None
        width, thickness, gauge_length = sizes
        size = CouponSize(width, thickness, gauge_length, stiffness) if all(sizes) else None
        on_specimen = (own.strain_from or common.strain_from) == "specimen"

        def read(path: Path) -> TensileCurve:
            return read_curve(path, size=size, options=own.options(), on_specimen=on_specimen)

        return self._read(own.file, route, read)

    def _read(self, name: str, route: Route, reader: Callable[[Path], Read]) -> Read | None:
        """Read one file; a missing file and one named twice are problems of measured.yaml."""
        path = self.folder / name
        message = ""
        if "\x00" in name:
            self.problems.append(problem_at(route, f"no name of a file (got {name!r}): it holds a NUL", self.document))
            return None
        if path.resolve() in self.seen:
            message = f"this file is named twice (got {name!r}), every specimen and channel has its own"
        elif not path.is_file():
            near = nearest(name, [item.name for item in self.folder.iterdir()])
            message = f"no such file in the folder (got {name!r}){near}"
        if message:
            self.problems.append(problem_at(route, message, self.document))
            return None
        self.seen[path.resolve()] = route
        try:
            return reader(Path(shown(path)))
        except BadInput as error:
            self.problems.extend(error.problems)
            return None
