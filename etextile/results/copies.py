"""Whole result files built beside their final place, so that there is never half a one: new, enlarged, or repaired."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np

from etextile.files import part_of
from etextile.results import hdf, vtkhdf
from etextile.results.guard import GuardedHDF5
from etextile.results.vtkhdf import Commit, FileCounters


METADATA_BLOCK = 1 << 16
"""HDF5 sets aside this many bytes at a time for structure, so that a header can be made in one block."""


def build_beside(path: Path, build: Callable[[h5py.File], None]) -> Path:
    """Build a file beside its final place and return where, for the caller to move; on failure nothing is left."""
    part = part_of(path)
    guarded = GuardedHDF5(part, "w", meta_block_size=METADATA_BLOCK)
    try:
        build(guarded.file)
        guarded.file.close()
        guarded.guard.check(sync=True)
    except BaseException:
        guarded.close()
        part.unlink(missing_ok=True)
        raise
    guarded.close()
    return part


def rebuild(old: h5py.File, path: Path, counters: FileCounters) -> None:
    """Replace a file whose count cannot be read by a copy that holds what `counters` says."""
    rooms = [int(old["etextile"].attrs[f"room_{name}"]) for name in (hdf.STEPS, hdf.INCREMENTS)]
    used = (counters.steps, counters.increments)
    plan = dict(zip((hdf.STEPS, hdf.INCREMENTS), zip(used, rooms, strict=True), strict=True))
    build_beside(path, lambda new: copy(old, new, plan, counters)).replace(path)


def copy(old: h5py.File, new: h5py.File, plan: dict[str, tuple[int, int]], counters: FileCounters) -> None:
    """Copy a file with room as planned, times taken from the table of increments."""
    hdf.copy_enlarged(old, new, plan)
    for name, (_, room) in plan.items():
        new["etextile"].attrs[f"room_{name}"] = room
    vtkhdf.lay_out_steps(new, plan[hdf.STEPS][1])
    table = old["etextile/increments"]
    output = table["step"][: counters.increments] >= 0
    Commit(new)(counters, np.asarray(table["travel_mm"][: counters.increments])[output])
