"""Folders of measurements: `measured.yaml` read strictly, then every channel's files; all that is wrong at once.

    title: punch test
    channels:
      punch_force: {files: [punch_1.csv, punch_2.csv], noise: 2 N}
      tensile: {warp: [warp_1.csv], weft: [weft_1.csv], bias: [bias_1.csv]}

Tensile files of force and displacement need `width`, `thickness` and `gauge_length`, for all specimens in `tensile` or
for one in the list (`{file: warp_3.csv, width: 28 mm}`); `columns` names the columns of files without a header line.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, TypeVar

import numpy as np
from pydantic import Discriminator, Field, Tag, field_validator, model_validator

from etextile.diagnose.data.measured import (
    Measurements,
    PunchForce,
    WireStates,
    odd_specimens,
    read_clamp_line,
    read_free_edge,
    read_punch_force,
    read_strain_field,
    read_wires,
)
from etextile.errors import BadInput, Problem, nearest
from etextile.identify.curves import CouponSize, TensileCurve, read_curve
from etextile.types import Array
from loadcases.messages import problem_at
from loadcases.schema_numbers import PositiveLength, Quantity, Strict
from loadcases.validate import checked, in_order
from loadcases.yaml_text import Document, Route, read_document, shown


NAME = "measured.yaml"
DIRECTIONS = ("warp", "weft", "bias")
READINGS = {"free_edge": ("warp", "weft", "height"), "strain_field": ("strain_warp", "strain_weft")}
"""What is compared with its stated noise; the slip of a clamp that holds is nothing but noise."""
LOUD = 0.5
"""Share of the readings' root mean square beyond which a stated noise is in another unit, or hides the channel."""
Column = Literal["strain", "stress_MPa", "displacement_mm", "force_N"]
FileName = Annotated[str, Field(min_length=1, description="Name of a CSV file in the folder.")]
NoiseForce = Annotated[float, Quantity("N", above=0.0)]
NoiseLength = Annotated[float, Quantity("mm", above=0.0)]
NoiseStrain = Annotated[float, Quantity(above=0.0)]
Read = TypeVar("Read")


class PunchForceFiles(Strict):
    """Force over punch displacement, one file per specimen."""

    files: tuple[FileName, ...] = Field(
        min_length=1, description="CSV files displacement_mm,force_N, one per specimen."
    )
    noise: NoiseForce | None = Field(default=None, description="Standard deviation of the force, N.")


class LengthFile(Strict):
    """A file of lengths with its noise."""

    file: FileName = Field(description="CSV file in the folder.")
    noise: NoiseLength | None = Field(default=None, description="Standard deviation of the lengths, mm.")


class StrainFile(Strict):
    """A file of strains with its noise."""

    file: FileName = Field(description="CSV file displacement_mm,warp0_mm,weft0_mm,strain_warp,strain_weft.")
    noise: NoiseStrain | None = Field(default=None, description="Standard deviation of the strains.")


class WiresFile(Strict):
    """A file of wire states."""

    file: FileName = Field(description="CSV file displacement_mm,wire,warp0_mm,state.")


class Size(Strict):
    """Dimensions of coupons and the columns of their files."""

    width: PositiveLength | None = Field(default=None, description="Width of the coupon, mm.")
    thickness: PositiveLength | None = Field(default=None, description="Thickness of the coupon, mm.")
    gauge_length: PositiveLength | None = Field(default=None, description="Gauge length, mm.")
    columns: tuple[Column, ...] | None = Field(
        default=None, min_length=2, description="Columns of files without a header line, in order."
    )


class Specimen(Size):
    """One tensile file with dimensions of its own."""

    file: FileName = Field(description="CSV file in the folder.")


def _specimen_kind(value: Any) -> str:
    """Tell the two forms of a specimen apart."""
    return "section" if isinstance(value, (dict, Specimen)) else "name"


AnySpecimen = Annotated[
    Annotated[FileName, Tag("name")] | Annotated[Specimen, Tag("section")], Discriminator(_specimen_kind)
]


class TensileFiles(Size):
    """Tensile curves by direction, in time order, loading then unloading; one file per specimen."""

    warp: tuple[AnySpecimen, ...] = Field(default=(), description="CSV files of coupons pulled along the warp.")
    weft: tuple[AnySpecimen, ...] = Field(default=(), description="CSV files of coupons pulled along the weft.")
    bias: tuple[AnySpecimen, ...] = Field(default=(), description="CSV files of coupons pulled at 45 degrees.")

    @model_validator(mode="after")
    def _some(self) -> TensileFiles:
        if not any((self.warp, self.weft, self.bias)):
            raise ValueError("no specimens, name files under warp, weft or bias")
        return self


class Channels(Strict):
    """What was measured; every channel is optional, one is needed."""

    punch_force: PunchForceFiles | None = Field(default=None, description="Force over punch displacement.")
    free_edge: LengthFile | None = Field(
        default=None, description="displacement_mm,warp0_mm,warp_mm,weft_mm,height_mm."
    )
    tensile: TensileFiles | None = Field(default=None, description="Tensile curves.")
    strain_field: StrainFile | None = Field(default=None, description="Strain at material points.")
    clamp_line: LengthFile | None = Field(default=None, description="displacement_mm,weft0_mm,slip_mm.")
    wires: WiresFile | None = Field(default=None, description="State of the wires.")

    @model_validator(mode="after")
    def _some(self) -> Channels:
        if not any(getattr(self, name) for name in type(self).model_fields):
            raise ValueError(f"no channel, give at least one of {', '.join(type(self).model_fields)}")
        return self


class MeasuredFolder(Strict):
    """The file `measured.yaml`."""

    title: str = Field(min_length=1, description="One line that names the measurements.")
    description: str = Field(default="", description="What was measured and how, free text.")
    channels: Channels = Field(description="What was measured.")

    @field_validator("title")
    @classmethod
    def _one_line(cls, value: str) -> str:
        return " ".join(value.split())


def load_measurements(path: str | Path) -> Measurements:
    """Return the measurements in a folder (or behind its measured.yaml).

    Raises BadInput with everything that is wrong in measured.yaml and in the files it names.
    """
    file = _find(Path(path))
    document, _ = read_document(file)
    spec, problems = checked(document, MeasuredFolder)
    if spec is None:
        raise BadInput(in_order(problems))
    reading = _Reading(file, document, problems)
    result = reading.measurements(spec)
    if problems:
        raise BadInput(in_order(problems))
    return result


def _find(path: Path) -> Path:
    """Return the measured.yaml of a folder."""
    file = path / NAME if path.is_dir() else path
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

    def measurements(self, spec: MeasuredFolder) -> Measurements:
        """Return all channels; a channel that cannot be read is left out and its problem noted."""
        named = spec.channels
        force = named.punch_force
        return Measurements(
            spec.title,
            str(self.folder),
            punch_force=() if force is None else self._punch_force(force),
            free_edge=self._one("free_edge", named.free_edge, read_free_edge),
            tensile={} if named.tensile is None else self._tensile(named.tensile),
            strain_field=self._one("strain_field", named.strain_field, read_strain_field),
            clamp_line=self._one("clamp_line", named.clamp_line, read_clamp_line),
            wires=self._wires(named.wires),
            file=shown(self.file),
        )

    def _punch_force(self, spec: PunchForceFiles) -> tuple[PunchForce, ...]:
        route: Route = ("channels", "punch_force", "files")
        found = [
            self._read(name, (*route, i), lambda path: read_punch_force(path, noise=spec.noise))
            for i, name in enumerate(spec.files)
        ]
        curves = tuple(item for item in found if item is not None)
        if len(curves) == len(found):
            self.problems.extend(odd_specimens(curves))
            self._check_noise("punch_force", spec.noise, [curve.force for curve in curves], " N")
        return curves

    def _one(self, channel: str, spec: LengthFile | StrainFile | None, reader: Callable[..., Read]) -> Read | None:
        if spec is None:
            return None
        found = self._read(spec.file, ("channels", channel, "file"), lambda path: reader(path, noise=spec.noise))
        if found is not None and channel in READINGS:
            readings = [getattr(found, name) for name in READINGS[channel]]
            self._check_noise(channel, spec.noise, readings, "" if isinstance(spec, StrainFile) else " mm")
        return found

    def _check_noise(self, channel: str, noise: float | None, readings: Sequence[Array], unit: str) -> None:
        """Refuse a stated noise that the readings hardly reach themselves."""
        size = float(np.sqrt(np.mean(np.square(np.concatenate(readings)))))
        if noise is not None and noise > LOUD * size:
            message = (
                f"more than half of what was read (got {noise:g}{unit}, the root mean square of the readings is "
                f"{size:.4g}{unit}); are noise and readings in the units they should be? without a noise to state, "
                "leave it out"
            )
            self.problems.append(problem_at(("channels", channel, "noise"), message, self.document))

    def _wires(self, spec: WiresFile | None) -> WireStates | None:
        return None if spec is None else self._read(spec.file, ("channels", "wires", "file"), read_wires)

    def _tensile(self, spec: TensileFiles) -> dict[str, tuple[TensileCurve, ...]]:
        curves = {}
        for direction in DIRECTIONS:
            specimens = getattr(spec, direction)
            found = [self._curve(item, spec, ("channels", "tensile", direction, i)) for i, item in enumerate(specimens)]
            if found:
                curves[direction] = tuple(item for item in found if item is not None)
        return curves

    def _curve(self, item: str | Specimen, common: TensileFiles, route: Route) -> TensileCurve | None:
        own = item if isinstance(item, Specimen) else Specimen(file=item)
        sizes = [getattr(own, name) or getattr(common, name) for name in ("width", "thickness", "gauge_length")]
        if any(sizes) and not all(sizes):
            message = "width, thickness and gauge_length belong together, give all three"
            self.problems.append(problem_at(route, message, self.document))
            return None
        size = CouponSize(*sizes) if all(sizes) else None
        columns = own.columns or common.columns or ()
        return self._read(own.file, route, lambda path: read_curve(path, size=size, columns=columns))

    def _read(self, name: str, route: Route, reader: Callable[[Path], Read]) -> Read | None:
        """Read one file; a missing file and one named twice are problems of measured.yaml."""
        path = self.folder / name
        message = ""
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
