"""Files as a run leaves them: written whole or not at all, by one writer per folder, never through a link.

A reader sees a finished file or the one before, also after a kill or a power loss; a second program that would write
into the same folder is told who does already.
"""

from __future__ import annotations

import csv
import errno
import inspect
import io
import json
import os
import re
import socket
import stat
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import wraps
from pathlib import Path
from typing import ParamSpec, TypeVar

from etextile.errors import BadInput, NoSpace


P = ParamSpec("P")
R = TypeVar("R")

FULL = (errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC))
LOCK = ".etextile.lock"
OWNER = ".etextile.owner"
PART = re.compile(r"\..+\.\d+\.part(\.\w+)?")
"""Name of a file that is being written."""
MOST_PATH, MOST_NAME = 4095, 255
"""Bytes that a path, and a name in it, may have on the usual systems."""
SHOWN = 160
_held: set[Path] = set()


def no_space(error: OSError, kept: str) -> OSError | NoSpace:
    """Return the error of a full disk, quota or file size limit in words (`kept`: what is safe), others unchanged."""
    if error.errno not in FULL:
        return error
    return NoSpace(f"no space left on {error.filename or 'the disk'} ({error.strerror}): {kept}")


def part_of(path: Path) -> Path:
    """Return where this process writes a file until it is whole."""
    return path.with_name(f".{path.stem[:100]}.{os.getpid()}.part{path.suffix}")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a new path beside `path` to write to; it takes that name when all is written and is on the disk.

    A reader sees the old or the new file; a link at its place is replaced, not followed. Raises BadInput where a folder
    or a device stands, and OSError under the file's own name.
    """
    _refuse_other_kinds(path)
    part = part_of(path)
    try:
        part.unlink(missing_ok=True)
        yield part
        with part.open("rb+") as file:
            os.fsync(file.fileno())
        part.replace(path)
    except BaseException as error:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror, str(path)) from error
        raise


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file at once, see `replacing`."""
    with replacing(path) as part, part.open("xb") as file:
        file.write(content.encode("utf-8") if isinstance(content, str) else content)


def write_table(path: Path, rows: Iterable[Sequence[object]]) -> None:
    """Write rows as a CSV file at once; None is an empty field."""
    text = io.StringIO(newline="")
    csv.writer(text, lineterminator="\n").writerows(rows)
    write_whole(path, text.getvalue())


def read_bounded(path: Path, most: int, *, shown: str = "") -> bytes:
    """Return the bytes of an ordinary file of at most `most`; pipes and devices, which may never end, are not opened.

    Raises BadInput, under the name `shown`, for what is no such file or cannot be read.
    """
    file = shown or short(path)
    try:
        found = path.stat()
        if not stat.S_ISREG(found.st_mode):
            kind = "a folder" if stat.S_ISDIR(found.st_mode) else "a device or a pipe"
            raise BadInput.of(f"this is {kind}, give an ordinary file", file=file)
        if found.st_size > most:
            raise BadInput.of(f"{found.st_size} bytes are too many for such a file, at most {most} are read", file=file)
        with path.open("rb") as stream:
            return stream.read(most)
    except OSError as error:
        message = f"cannot be read ({error.strerror or error}), check the path and its rights"
        raise BadInput.of(message, file=file) from error


def too_long(name: str | Path) -> str:
    """Say what is too long in a path, '' for one that the system can take."""
    text = str(name)
    longest = max((len(os.fsencode(part)) for part in Path(text).parts), default=0)
    whole = len(os.fsencode(text))
    if longest <= MOST_NAME and whole <= MOST_PATH:
        return ""
    found = f"a path of {whole} bytes with a name of {longest}"
    return f"{found} is too long, at most {MOST_PATH} and {MOST_NAME} are possible (got {short(text)!r})"


def short(path: str | Path) -> str:
    """Return a path as messages show it: the middle of a very long one is left out."""
    text = str(path)
    return text if len(text) <= SHOWN else f"{text[: SHOWN // 2]}...{text[-SHOWN // 2 :]}"


def _refuse_other_kinds(path: Path) -> None:
    """Raise BadInput where something stands that no file may replace."""
    try:
        found = path.lstat()
    except OSError:
        return
    if stat.S_ISDIR(found.st_mode):
        raise BadInput.of("a folder stands where this file has to be written, move it away", file=str(path))
    if not stat.S_ISREG(found.st_mode) and not stat.S_ISLNK(found.st_mode):
        raise BadInput.of("this is a device or a pipe, give the name of a file to write", file=str(path))


def check_targets(folder: Path, names: Iterable[str]) -> None:
    """Raise BadInput when one of the files or folders that will be written there cannot be; names of folders end in /.

    A link to a folder would lead writing elsewhere and is refused; a link to a file is replaced by the file.
    """
    for name in names:
        path = folder / name
        if name.endswith("/"):
            if path.is_symlink() or (path.exists() and not path.is_dir()):
                raise BadInput.of("this must be a folder to write into, move it away", file=str(path))
        elif path.is_dir() and not path.is_symlink():
            raise BadInput.of("a folder stands where this file has to be written, move it away", file=str(path))
        elif path.exists() and not os.access(path, os.W_OK):
            raise BadInput.of("this file is to be written and is read-only, move it away", file=str(path))


def remove(folder: Path, patterns: Iterable[str]) -> None:
    """Remove files of an earlier run, so that none of them stands beside newer results."""
    for pattern in patterns:
        for path in folder.glob(pattern):
            if path.is_symlink() or path.is_file():
                path.unlink()


def named(folder: str | Path) -> None:
    """Raise BadInput for a folder without a name, which would stand for the working folder."""
    if not str(folder).strip():
        raise BadInput.of("the output folder needs a name (got ''), write . for the working folder")


def one_writer(argument: str = "output") -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorate a function that writes into the folder given by its `argument`: one writer at a time, see `owned`."""

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        signature = inspect.signature(function)

        @wraps(function)
        def locked(*args: P.args, **kwargs: P.kwargs) -> R:
            folder = str(signature.bind(*args, **kwargs).arguments[argument])
            named(folder)
            with owned(Path(folder)):
                return function(*args, **kwargs)

        return locked

    return decorate


@contextmanager
def owned(folder: Path) -> Iterator[None]:
    """Make a folder and be its only writer; raises BadInput that tells host and process of another one.

    What was made for it goes away again when nothing was written. A process may take a folder that it holds.
    """
    from filelock import FileLock, Timeout

    place = folder.resolve()
    if place in _held:
        yield
        return
    made = _make(folder)
    lock = FileLock(folder / LOCK, timeout=0)
    try:
        lock.acquire()
    except Timeout:
        raise BadInput.of(f"another run writes into this folder ({_owner(folder)})", file=str(folder)) from None
    except (NotImplementedError, PermissionError) as error:
        if isinstance(error, PermissionError) or not os.access(folder, os.W_OK):
            raise BadInput.of(
                "this folder cannot be written into, choose another --output", file=str(folder)
            ) from error
    _held.add(place)
    _clear_parts(folder)
    try:
        with suppress(OSError):
            write_whole(folder / OWNER, json.dumps(_me()))
        yield
    finally:
        _held.discard(place)
        with suppress(OSError):
            (folder / OWNER).unlink(missing_ok=True)
        lock.release()
        _unmake(folder, made)


def _clear_parts(folder: Path) -> None:
    """Remove what writers that were killed left half written: nobody else writes here now."""
    for path in (*folder.glob(".*.part*"), *folder.glob("*/.*.part*")):
        if PART.fullmatch(path.name):
            with suppress(OSError):
                path.unlink()


def _make(folder: Path) -> list[Path]:
    """Make a folder with those above it; return the new ones, deepest first."""
    if found := too_long(folder):
        raise BadInput.of(f"{found}, choose another --output")
    new = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        if error.errno in FULL:
            raise NoSpace(f"no space left on {folder}: nothing was written") from error
        raise BadInput.of(
            f"this folder cannot be made ({error.strerror}), choose another --output", file=str(folder)
        ) from error
    return new


def _unmake(folder: Path, made: list[Path]) -> None:
    """Take folders away again that hold nothing but the lock."""
    if made and {path.name for path in folder.iterdir()} <= {LOCK, OWNER}:
        with suppress(OSError):
            (folder / LOCK).unlink(missing_ok=True)
            for path in made:
                path.rmdir()


def _me() -> dict[str, str]:
    started = time.strftime("%Y-%m-%d %H:%M:%S")
    return {
        "process": str(os.getpid()),
        "host": socket.gethostname(),
        "since": started,
        "command": Path(sys.argv[0]).name,
    }


def _owner(folder: Path) -> str:
    """Say who writes into a folder."""
    try:
        found = json.loads((folder / OWNER).read_text(encoding="utf-8"))
        return f"process {int(found['process'])} on {str(found['host'])[:80]}, since {str(found['since'])[:20]}"
    except (OSError, ValueError, KeyError, TypeError):
        return "its process is not known"
