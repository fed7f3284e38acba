"""The VTKHDF side of a result file, and the one write that makes an increment part of it.

VTK insists that `/VTKHDF/Steps/Values` has exactly NSteps entries, so two things have to change together. They do: the
times are kept in two copies, the idle one is brought up to date, and then NSteps, our own counters and the link
`Values` are changed. All of these live in the object header of the group `Steps`, which HDF5 writes with a single call
(a test replays every write and opens the file after each).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from etextile.errors import EtextileError
from etextile.results import integrity
from etextile.results.layout import VTK_LINE, VTKHDF_VERSION


TIMES = "/etextile/times"
HEADER_ROOM = 768
_PLACES = 16


def lay_out_topology(root: h5py.Group, cells: ArrayLike, n_points: int) -> None:
    """Write the part of a VTKHDF grid of line cells that is shared by all steps."""
    lines = np.asarray(cells, dtype=np.int64).reshape(-1, 2)
    root.attrs["Version"] = np.array(VTKHDF_VERSION, dtype=np.int64)
    root.attrs.create("Type", b"UnstructuredGrid", dtype="S16")
    root["NumberOfPoints"] = np.array([n_points], dtype=np.int64)
    root["NumberOfCells"] = np.array([len(lines)], dtype=np.int64)
    root["NumberOfConnectivityIds"] = np.array([lines.size], dtype=np.int64)
    root["Connectivity"] = lines.ravel()
    root["Offsets"] = 2 * np.arange(len(lines) + 1, dtype=np.int64)
    root["Types"] = np.full(len(lines), VTK_LINE, dtype=np.uint8)


def lay_out_steps(file: h5py.File, capacity: int) -> None:
    """Write the offsets of all steps there is room for; only counters and times change from then on."""
    root, steps = file["VTKHDF"], _compact_group(file["VTKHDF"], "Steps")
    steps["Values"] = h5py.SoftLink(f"{TIMES}/none")
    for counter, start in (("NSteps", 0), ("increments", 0), ("restart_slot", -1)):
        steps.attrs[counter] = np.int64(start)
    _lay_out_times(file.create_group(TIMES), capacity)
    index = np.arange(capacity, dtype=np.int64)
    steps["PartOffsets"] = np.zeros_like(index)
    steps["NumberOfParts"] = np.ones_like(index)
    steps["PointOffsets"] = index * int(root["NumberOfPoints"][0])
    steps["CellOffsets"] = np.zeros((capacity, 1), dtype=np.int64)
    steps["ConnectivityIdOffsets"] = np.zeros((capacity, 1), dtype=np.int64)
    for name in ("PointData", "CellData"):
        offsets = steps.create_group(f"{name}Offsets")
        for key, dataset in root[name].items():
            offsets[key] = index * int(dataset.attrs.get("block", 0))


def _lay_out_times(group: h5py.Group, capacity: int) -> None:
    """Create the two copies of the times, each a chunk that is in the file from now on, and the empty list."""
    for copy in ("none", "0", "1"):
        empty = copy == "none"
        times = group.create_dataset(copy, (1 - empty,), "float64", maxshape=(capacity,), chunks=(capacity,))
        times.attrs["unit"] = "mm"
        times.attrs["description"] = "path travelled by the punch (the displacement itself as long as it only grows)"
        if not empty:
            times[:] = 0.0


@dataclass(frozen=True)
class FileCounters:
    """What is complete in a file: output steps, increments, and the restart slot in use (-1: none)."""

    steps: int
    increments: int
    restart_slot: int


def read_counters(file: h5py.File) -> FileCounters:
    """Return what is complete in a file; raises Damaged when the journal knows of no such count."""
    found = file["VTKHDF/Steps"].attrs
    counters = FileCounters(int(found["NSteps"]), int(found["increments"]), int(found["restart_slot"]))
    if JOURNAL in file and counters not in read_journal(file):
        raise integrity.Damaged(f"the count of {counters.steps} steps is not the one that was written")
    return counters


JOURNAL = f"{integrity.CHECKS}/journal"


def lay_out_journal(group: h5py.Group) -> None:
    """Create the two entries in which the last counters and those before stand a second time, with checksums."""
    first = _entry(FileCounters(0, 0, -1))
    journal = group.create_dataset("journal", data=np.array([first, np.zeros_like(first)]))
    journal.attrs["unit"] = ""
    journal.attrs["description"] = "steps, increments, restart slot and checksum of the last two commits"


def read_journal(file: h5py.File) -> list[FileCounters]:
    """Return the counters of the last two commits whose checksums hold, the latest first."""
    found = [FileCounters(*(int(value) for value in row[:3])) for row in file[JOURNAL][:2] if _holds(row)]
    return sorted(found, key=lambda counters: -counters.increments)


def _entry(counters: FileCounters) -> NDArray[np.int64]:
    values = np.array([counters.steps, counters.increments, counters.restart_slot], dtype=np.int64)
    return np.append(values, integrity.crc(values))


def _holds(row: NDArray[np.int64]) -> bool:
    return integrity.crc(np.asarray(row[:3], dtype=np.int64)) == int(row[3])


class Commit:
    """Makes what was written part of the file, for VTK and for us at the same instant."""

    def __init__(self, file: h5py.File, flush: Callable[[], None] | None = None) -> None:
        self._flush = flush or file.flush
        self._journal = file.get(JOURNAL)
        self._steps = file["VTKHDF/Steps"]
        names = ("NSteps", "increments", "restart_slot")
        self._counters = [h5py.h5a.open(self._steps.id, name.encode()) for name in names]
        self._copies = (file[f"{TIMES}/0"], file[f"{TIMES}/1"])

    def __call__(self, counters: FileCounters, times: ArrayLike) -> None:
        """Flush all data, then change counters and times with one write; `times` has an entry per output step."""
        known = np.asarray(times, dtype=np.float64)
        turn = len(known) != self._steps["Values"].shape[0]
        idle = 1 if self._steps.get("Values", getlink=True).path == f"{TIMES}/0" else 0
        if turn:
            self._copies[idle].resize(known.shape)
            self._copies[idle][:] = known
        if self._journal is not None:
            self._journal[counters.increments % 2] = _entry(counters)
        self._flush()
        values = (counters.steps, counters.increments, counters.restart_slot)
        for attribute, value in zip(self._counters, values, strict=True):
            attribute.write(np.array(value, dtype=np.int64))
        if turn:
            del self._steps["Values"]
            self._steps["Values"] = h5py.SoftLink(f"{TIMES}/{idle}")
        self._flush()


def _compact_group(parent: h5py.Group, name: str) -> h5py.Group:
    """Create a group that keeps up to 8 links in its object header, in one block (tracked order selects that format).

    An attribute that is taken out again leaves one stretch of the header free, which links and counters then share. The
    header can only grow in place where the file has room behind it, so places are tried until one has.
    """
    plan = h5py.h5p.create(h5py.h5p.GROUP_CREATE)
    plan.set_link_creation_order(h5py.h5p.CRT_ORDER_TRACKED)
    tried = []
    for _ in range(_PLACES):
        group = h5py.Group(h5py.h5g.create(parent.id, None, gcpl=plan))
        group.attrs["room"] = np.zeros(HEADER_ROOM, dtype=np.int8)
        if header_blocks(group) == 1:
            del group.attrs["room"]
            parent[name] = group
            return group
        tried.append(group)
    raise EtextileError("HDF5 found no room for the header of /VTKHDF/Steps in one block")


def header_blocks(group: h5py.Group) -> int:
    """Return in how many separate blocks the header of a group is written; with one, a change is a single write."""
    return int(h5py.h5o.get_info(group.id).hdr.nchunks)
