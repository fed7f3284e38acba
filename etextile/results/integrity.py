"""Whether a result file is what was written: checksums of all that is read, and no way out of the file.

Static arrays carry the attribute `crc32`, arrays that grow have an entry per step in `/etextile/checks`. A file from
elsewhere may be anything, so links out of it, storage outside of it and sizes beyond it are refused before reading.
"""

from __future__ import annotations

import zlib
from collections.abc import Iterable, Mapping
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from etextile.results import layout


CHECK = "crc32"
CHECKS = "etextile/checks"
ROW = "row"
MOST_OBJECTS = 2000
SOFT = "/VTKHDF/Steps/Values"
"""The one soft link of a file: it turns between two copies of the times."""


class Damaged(Exception):
    """A part of a file is not as it was written; the message names it."""


def crc(*parts: bytes | NDArray[Any], start: int = 0) -> int:
    """Return the checksum of bytes and arrays, one after the other."""
    value = zlib.crc32(str(start).encode())
    for part in parts:
        value = zlib.crc32(part if isinstance(part, bytes) else np.ascontiguousarray(part).tobytes(), value)
    return value


def name_of(dataset: h5py.Dataset) -> str:
    """Return the name under which the checks of a growing array stand."""
    return str(dataset.name).strip("/").replace("/", ".")


def seal(dataset: h5py.Dataset) -> None:
    """Attach the checksum of an array that does not change."""
    dataset.attrs[CHECK] = np.uint32(crc(np.asarray(dataset[()])))


def static(group: h5py.Group, name: str) -> Any:
    """Return an array that does not change, checked where it carries a checksum; raises Damaged."""
    dataset = group[name]
    values = dataset[()]
    if np.shape(values)[1:] != layout.STATIC_SHAPES[name]:
        raise Damaged(f"{dataset.name} has another shape than it was written with")
    if CHECK in dataset.attrs:
        if crc(np.asarray(values)) != int(dataset.attrs[CHECK]):
            raise Damaged(f"{dataset.name} is not as it was written")
    elif CHECKS in group.file:
        raise Damaged(f"{dataset.name} has lost its checksum")
    return values


def block(file: h5py.File, place: str, number: int) -> NDArray[Any]:
    """Return the entry of a growing array at one step, checked; raises Damaged."""
    dataset = file[place]
    rows = int(dataset.attrs["block"])
    values: NDArray[Any] = dataset[number * rows : (number + 1) * rows]
    if len(values) != rows:
        raise Damaged(f"{dataset.name} ends before step {number}")
    if CHECKS in file and int(file[f"{CHECKS}/{name_of(dataset)}"][number]) != crc(values, start=number):
        raise Damaged(f"step {number} of {dataset.name} is not as it was written")
    return values


def blocks(file: h5py.File, place: str, steps: int) -> NDArray[Any]:
    """Return the entries of a growing array at the first steps, (S, rows), checked; raises Damaged."""
    rows = int(file[place].attrs["block"])
    return np.array([block(file, place, step) for step in range(steps)]).reshape(steps, rows)


def rows(extra: h5py.Group, count: int) -> dict[str, NDArray[Any]]:
    """Return the first `count` rows of the table of increments by column, checked; raises Damaged."""
    group = extra["increments"]
    columns = {entry.name: group[entry.name][:count] for entry in layout.INCREMENTS}
    if any(len(values) != count for values in columns.values()):
        raise Damaged(f"the table of increments holds fewer than the {count} rows that are counted")
    if "checks" in extra:
        known = extra[f"checks/{ROW}"][:count]
        for number in range(count):
            if row_crc({name: values[number] for name, values in columns.items()}, number) != int(known[number]):
                raise Damaged(f"row {number} of the table of increments is not as it was written")
    return columns


def row_crc(row: Mapping[str, Any], number: int) -> int:
    """Return the checksum of a row of the table of increments, values as they are stored."""
    parts = [np.asarray(row[entry.name], dtype=entry.dtype) for entry in layout.INCREMENTS]
    return crc(*parts, start=number)


def state(file: h5py.File, slot: int, increments: int) -> dict[str, NDArray[Any]]:
    """Return the restart state in a slot, which belongs to so many increments; raises Damaged."""
    arrays = {name: dataset[()] for name, dataset in file[f"etextile/restart/{slot}"].items()}
    if CHECKS in file:
        known, after = (int(value) for value in file[f"{CHECKS}/state"][slot])
        if after != increments or state_crc(arrays, increments) != known:
            raise Damaged(f"the restart state after increment {increments} is not as it was written")
    return arrays


def state_crc(arrays: Mapping[str, NDArray[Any]], increments: int) -> int:
    """Return the checksum of the restart state after `increments` increments."""
    return crc(*(np.asarray(arrays[name]) for name in sorted(arrays)), start=increments)


def record_crc(extra: h5py.Group) -> int:
    """Return the checksum of the case and its origin as they stand in a file."""
    texts = [str(extra[name].asstr()[()]) for name in ("case", "case_effective")]
    names = ("format", "case_sha256", "source", "seed", "created", "case_effective_sha256", "version")
    plain = [str(np.asarray(extra.attrs[name]).tolist()) for name in names]
    more = [*map(str, extra["overrides"].asstr()[:]), *(f"{k}={v}" for k, v in sorted(extra["versions"].attrs.items()))]
    return crc(repr([texts, plain, more]).encode())


def refuse_foreign(file: h5py.File, size: int) -> None:
    """Raise Damaged for links out of the file, storage outside of it, filters, and arrays larger than the file."""
    _walk(file.id, "", size, iter(range(MOST_OBJECTS)), 0)


def _walk(group: Any, path: str, size: int, left: Iterable[int], depth: int) -> None:
    for name in group:
        place = f"{path}/{name.decode(errors='replace')}"
        if next(iter(left), None) is None or depth > 5:
            raise Damaged(f"{place}: more objects than a result file has")
        kind = group.links.get_info(name).type
        if kind != h5py.h5l.TYPE_HARD:
            if kind == h5py.h5l.TYPE_SOFT and place == SOFT:
                continue
            raise Damaged(f"{place} is a link that leads elsewhere, which is not followed")
        item = h5py.h5o.open(group, name)
        if isinstance(item, h5py.h5g.GroupID):
            _walk(item, place, size, left, depth + 1)
        elif isinstance(item, h5py.h5d.DatasetID):
            _refuse_dataset(item, place, size)


def _refuse_dataset(item: Any, place: str, size: int) -> None:
    plan = item.get_create_plist()
    if plan.get_external_count() or plan.get_layout() == h5py.h5d.VIRTUAL or plan.get_nfilters():
        raise Damaged(f"{place} is stored outside of the file or packed, which no result file is")
    declared = int(np.prod([float(count) for count in item.shape])) * item.get_type().get_size()
    if declared > size:
        raise Damaged(f"{place} says it holds {declared} bytes, the whole file has {size}")
