"""A result file after a power loss: the count goes back to the last increment that is there with all its data.

Data and count are written one after the other, but a disk may keep them in another order when the power goes. The
journal beside the count tells the last two commits, checksums tell which of them holds.
"""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from etextile.errors import BadInput
from etextile.results import integrity, vtkhdf
from etextile.results.copies import rebuild
from etextile.results.guard import GuardedHDF5
from etextile.results.vtkhdf import Commit, FileCounters, read_counters, read_journal


def repair(path: Path) -> bool:
    """Take back what is torn at the end of a file; return whether anything was. Raises BadInput when nothing holds."""
    try:
        with h5py.File(path, "r", locking=False) as file:
            integrity.refuse_foreign(file, path.stat().st_size)
            if vtkhdf.JOURNAL not in file:
                return False
            entries = read_journal(file)
            latest = _counted(file)
            if latest is not None and _whole(file, latest):
                return False
            sound = next((counters for counters in entries if counters != latest and _whole(file, counters)), None)
    except (integrity.Damaged, *FAULTS):
        return False  # opening it says what is wrong
    if sound is None:
        message = "the last increments are damaged and no restart state holds: repeat the run without --resume"
        raise BadInput.of(message, file=str(path))
    _go_back(path, sound, rebuilt=latest is None)
    return True


FAULTS = (KeyError, OSError, RuntimeError, ValueError, TypeError, IndexError)


def _counted(file: h5py.File) -> FileCounters | None:
    """Return the count of a file, None when it is torn."""
    try:
        return read_counters(file)
    except (integrity.Damaged, *FAULTS):
        return None


def _whole(file: h5py.File, counters: FileCounters) -> bool:
    """Tell whether the last increment and step of a count, and its state, are as they were written."""
    try:
        extra = file["etextile"]
        integrity.rows(extra, counters.increments)
        for name in extra["checks"] if counters.steps else ():
            if name not in (integrity.ROW, "state", "journal"):
                integrity.block(file, name.replace(".", "/"), counters.steps - 1)
        if counters.restart_slot >= 0:
            integrity.state(file, counters.restart_slot, counters.increments)
    except (integrity.Damaged, *FAULTS):
        return False
    return True


def _go_back(path: Path, counters: FileCounters, *, rebuilt: bool) -> None:
    """Set the count; one whose header is torn is built anew in a copy."""
    guarded = GuardedHDF5(path)
    try:
        if rebuilt:
            rebuild(guarded.file, path, counters)
            return
        extra = guarded.file["etextile/increments"]
        output = extra["step"][: counters.increments] >= 0
        times = np.asarray(extra["travel_mm"][: counters.increments])[output]
        Commit(guarded.file, lambda: guarded.flush(sync=True))(counters, times)
    finally:
        guarded.close()
