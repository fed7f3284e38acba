"""The one decorator for compiled kernels: numba without the GIL, cached on disk wherever a disk can be written.

Numba looks for a cache folder next to the source file and in the home folder and refuses to decorate when neither is
writable (a read-only installation run by a user without a home). The decorator then moves the cache to a private
temporary folder, through NUMBA_CACHE_DIR so that worker processes use the same one, and compiles without a cache
where even that fails. Importing this module imports numba: keep it out of everything `--help` and `check` load.

Numba asks only whether the file of a kernel has changed, but a kernel has those it calls compiled into itself: with an
old truss kernel a new law would go unseen. So the text of all kernels is part of the stamp of each.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core.event import Listener, install_listener

from etextile.environment import set_variable


F = TypeVar("F", bound=Callable[..., Any])


def njit(function: F) -> F:
    """Compile `function` in nopython mode, without the GIL, division by zero giving inf or nan, cached on disk."""
    try:
        return _compile(function, cache=True)
    except RuntimeError as error:
        if "cannot cache" not in str(error):
            raise
    try:
        _move_cache(private_temporary_folder("etextile-numba"))
        return _compile(function, cache=True)
    except (OSError, RuntimeError):
        return _compile(function, cache=False)


def private_temporary_folder(name: str) -> Path:
    """Return a temporary folder that only this user can write, the same on every call where possible.

    Compiled code is read back from it, so a folder somebody else made under the expected name is never used.
    Raises OSError when no temporary folder can be written.
    """
    if not hasattr(os, "getuid"):
        folder = Path(tempfile.gettempdir()) / name
        folder.mkdir(parents=True, exist_ok=True)
        return folder
    folder = Path(tempfile.gettempdir()) / f"{name}-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    status = folder.lstat()
    if folder.is_symlink() or status.st_uid != os.getuid() or status.st_mode & 0o022:
        return Path(tempfile.mkdtemp(prefix=f"{name}-"))
    return folder


def _compile(function: F, *, cache: bool) -> F:
    compiled = numba.njit(nogil=True, cache=cache, error_model="numpy")(function)
    index: Any = getattr(getattr(compiled, "_cache", None), "_cache_file", None)
    if hasattr(index, "_source_stamp"):
        setattr(index, "_source_stamp", (index._source_stamp, sources()))  # noqa: B010 (numba has no setting for it)
    return cast(F, compiled)


@lru_cache(maxsize=1)
def sources() -> str:
    """Return a digest of the text of all files with kernels in the packages beside this file."""
    here = Path(__file__).parent
    files = sorted(path for package in (here, here.parent / "wires") for path in package.rglob("*.py"))
    texts = (path.read_bytes() for path in files)
    return hashlib.sha256(b"".join(text for text in texts if b"@njit" in text)).hexdigest()


class _First(Listener):
    """Calls `tell` when the first kernel begins to be compiled; what is read from the cache is not compiled."""

    def __init__(self, tell: Callable[[], None]) -> None:
        self._tell = tell
        self._told = False

    def on_start(self, event: Any) -> None:
        """Begin to compile."""
        if not self._told:
            self._told = True
            self._tell()

    def on_end(self, event: Any) -> None:
        """Nothing to say."""


@contextmanager
def announcing(tell: Callable[[], None]) -> Iterator[None]:
    """Call `tell` once, before the first kernel is compiled, if any has to be: the cache is one of this machine."""
    with install_listener("numba:compile", _First(tell)):
        yield


def _move_cache(folder: Path) -> None:
    set_variable("NUMBA_CACHE_DIR", str(folder))
    setattr(numba.config, "CACHE_DIR", str(folder))  # noqa: B010 (numba fills its configuration at run time)
