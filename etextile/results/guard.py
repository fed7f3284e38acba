"""The file under HDF5: what the disk refuses is kept from HDF5, which would crash over it, and told to us.

HDF5 cannot close a file whose last write failed, and a process that holds such a file ends in a segmentation fault. All
writes therefore go through an object that never fails towards HDF5: from the first refused write on nothing reaches the
disk any more, so that the file there stays as a kill at that moment would leave it, which is valid and resumable.
"""

from __future__ import annotations

import io
import os
import time
from pathlib import Path
from typing import Any

import h5py


SYNC_S = 5.0
"""Data are forced to the disk at most this often, s: what a power loss tears is told by checksums and repaired."""


class GuardedFile(io.RawIOBase):
    """A file for h5py's file-object driver; `failure` is the first error of the disk, None as long as all is well."""

    def __init__(self, path: Path, *, create: bool) -> None:
        super().__init__()
        flags = os.O_RDWR | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0) | getattr(os, "O_CLOEXEC", 0)
        if create:
            path.unlink(missing_ok=True)
            flags |= os.O_CREAT | os.O_EXCL
        self._file = io.FileIO(os.open(path, flags, 0o666), "r+")
        self.path = path
        self.failure: OSError | None = None
        self._unwritten: list[tuple[int, bytes]] = []
        self._size = self._file.seek(0, io.SEEK_END)
        self._place = 0
        self._synced = time.monotonic()

    def readable(self) -> bool:
        """Return True."""
        return True

    def writable(self) -> bool:
        """Return True."""
        return True

    def seekable(self) -> bool:
        """Return True."""
        return True

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Move the place of the next read or write."""
        base = {io.SEEK_SET: 0, io.SEEK_CUR: self._place, io.SEEK_END: self._size}[whence]
        self._place = base + offset
        return self._place

    def tell(self) -> int:
        """Return the place of the next read or write."""
        return self._place

    def readinto(self, buffer: Any, /) -> int:
        """Read; what was never written reads as zero, what the disk refused reads as it was given."""
        view = memoryview(buffer).cast("B")
        self._file.seek(self._place)
        done = 0
        while done < len(view):
            count = self._file.readinto(view[done:])
            if not count:
                view[done:] = bytes(len(view) - done)
                break
            done += count
        for start, data in self._unwritten:
            low, high = max(start, self._place), min(start + len(data), self._place + len(view))
            if low < high:
                view[low - self._place : high - self._place] = data[low - start : high - start]
        self._place += len(view)
        return len(view)

    def write(self, data: Any, /) -> int:
        """Write all of it, or note the failure and keep it in memory."""
        view = memoryview(data).cast("B")
        start, done = self._place, 0
        if self.failure is None:
            try:
                self._file.seek(start)
                while done < len(view):
                    done += self._file.write(view[done:])
            except OSError as error:
                self._note(error)
        if done < len(view):
            self._unwritten.append((start + done, bytes(view[done:])))
        self._place = start + len(view)
        self._size = max(self._size, self._place)
        return len(view)

    def truncate(self, size: int | None = None, /) -> int:
        """Set the size of the file."""
        wanted = self._place if size is None else size
        if self.failure is None and wanted != self._size:
            try:
                self._file.truncate(wanted)
            except OSError as error:
                self._note(error)
        self._size = wanted
        return wanted

    def flush(self) -> None:
        """Do nothing: writes are not buffered."""

    def check(self, *, sync: bool = False) -> None:
        """Raise the error of the disk, if there was one; `sync` forces the data to the disk now."""
        if self.failure is None and (sync or time.monotonic() - self._synced > SYNC_S):
            self._synced = time.monotonic()
            try:
                os.fsync(self._file.fileno())
            except OSError as error:
                self._note(error)
        if self.failure is not None:
            raise OSError(self.failure.errno, self.failure.strerror, str(self.path))

    def close(self) -> None:
        """Close the file on the disk."""
        self._file.close()
        super().close()

    def _note(self, error: OSError) -> None:
        self.failure = self.failure or error


class GuardedHDF5:
    """An HDF5 file over a guarded one; `flush` raises what the disk refused, `close` never does."""

    def __init__(self, path: Path, mode: str = "r+", **options: Any) -> None:  # options of h5py.File
        self.guard = GuardedFile(path, create=mode == "w")
        self.file = h5py.File(self.guard, mode, locking=False, **options)

    def flush(self, *, sync: bool = False) -> None:
        """Hand all data to the disk; raises OSError with the file's name when it refused any."""
        self.file.flush()
        self.guard.check(sync=sync)

    def close(self) -> None:
        """Close both files."""
        if self.file:
            self.file.close()
        self.guard.close()
