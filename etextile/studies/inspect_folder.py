"""What would be read of a folder of measurements: every file in it, as `measured.yaml` says it is to be read."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from etextile.errors import BadInput, Problem
from etextile.identify.curves import CouponSize
from etextile.importers.options import Options
from etextile.studies.inspect import Inspection, as_json, inspect_table
from loadcases.measurements import DIRECTIONS, load_measurements, measured_spec
from loadcases.schema_measured import (
    Channels,
    HeightFiles,
    MeasuredFolder,
    PunchFile,
    PunchForceFiles,
    Specimen,
    TensileFiles,
)
from loadcases.schema_reading import Reading


ASIDE = (".md", ".yaml", ".yml", ".json", ".png", ".pdf")
"""Endings of files that are no tables."""


@dataclass(frozen=True)
class InspectedFile:
    """A file of a folder: its place in measured.yaml ('' for one that is not named there) and what was found in it."""

    file: str
    channel: str
    found: Inspection | None
    problems: tuple[Problem, ...]


@dataclass(frozen=True)
class InspectedFolder:
    """A folder of measurements: its title, its files, and all that would keep it from being read."""

    folder: str
    title: str
    files: tuple[InspectedFile, ...]
    problems: tuple[Problem, ...]


@dataclass(frozen=True)
class _Entry:
    """A file as measured.yaml names it."""

    name: str
    channel: str
    where: str
    options: Options
    size: CouponSize | None = None


def inspect_folder(folder: str | Path) -> InspectedFolder:
    """Return what would be read of a folder of measurements; raises BadInput where measured.yaml itself is wrong."""
    place = Path(folder)
    spec = measured_spec(place)
    entries = list(_entries(spec))
    files = [_inspected(place, entry) for entry in entries]
    named = {(place / entry.name).resolve() for entry in entries}
    files += [
        InspectedFile(path.name, "", None, ())
        for path in sorted(place.iterdir())
        if path.is_file() and path.resolve() not in named and path.suffix.lower() not in ASIDE
    ]
    try:
        load_measurements(place)
    except BadInput as error:
        return InspectedFolder(str(place), spec.title, tuple(files), error.problems)
    return InspectedFolder(str(place), spec.title, tuple(files), ())


def folder_as_json(found: InspectedFolder) -> dict[str, Any]:
    """Return an inspected folder in JSON types."""
    files = [
        {
            "file": item.file,
            "channel": item.channel or None,
            "read": None if item.found is None else as_json(item.found),
        }
        for item in found.files
    ]
    problems = [str(problem) for problem in found.problems]
    return {
        "folder": found.folder, "kind": "measurements", "title": found.title, "files": files, "problems": problems,
    }  # fmt: skip


def _inspected(place: Path, entry: _Entry) -> InspectedFile:
    """Return what would be read of one file."""
    where = f"{entry.channel}{entry.where}"
    try:
        found = inspect_table(place / entry.name, channel=entry.channel, options=entry.options, size=entry.size)
    except BadInput as error:
        return InspectedFile(entry.name, where, None, error.problems)
    return InspectedFile(entry.name, where, found, found.problems)


def _entries(spec: MeasuredFolder) -> Iterator[_Entry]:
    """Yield all files that a measured.yaml names."""
    if spec.channels is not None:
        yield from _of_test(spec.channels, "")
    for test in spec.tests:
        yield from _of_test(test.channels, f", test {test.name}")


def _of_test(channels: Channels, where: str) -> Iterator[_Entry]:
    """Yield the files of one test."""
    for channel, section in channels:
        if isinstance(section, TensileFiles):
            yield from _coupons(section, where)
        elif isinstance(section, PunchForceFiles):
            for item in section.files:
                own = (item if isinstance(item, PunchFile) else PunchFile(file=item)).over(section)
                yield _Entry(own.file, channel, where, own.options())
        elif isinstance(section, Reading):
            for name in getattr(section, "files", None) or (getattr(section, "file", ""),):
                yield _Entry(name, channel, where, section.options())
            if isinstance(section, HeightFiles) and section.diaphragm is not None:
                yield _Entry(section.diaphragm, channel, f", diaphragm{where}", section.options())


def _coupons(section: TensileFiles, where: str) -> Iterator[_Entry]:
    """Yield the coupons of all directions."""
    for direction in DIRECTIONS:
        for item in getattr(section, direction):
            own = (item if isinstance(item, Specimen) else Specimen(file=item)).over(section)
            sizes = [getattr(own, name) or getattr(section, name) for name in ("width", "thickness", "gauge_length")]
            stiffness = own.machine_stiffness or section.machine_stiffness
            width, thickness, gauge_length = sizes
            size = CouponSize(width, thickness, gauge_length, stiffness) if all(sizes) else None
            yield _Entry(own.file, "tensile", f" {direction}{where}", own.options(), size)
