"""A verb in a process of its own, forked from one that has imported all and solved nothing: words, time, memory."""

from __future__ import annotations

import io
import os
import resource
import select
import signal
import time
import traceback
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from etextile.app import cli


LONGEST_S = 20.0
SILENCE_S = 600.0
"""Seconds of the wall clock after which a verb is given up; on a busy machine that is little processor time."""
LARGEST_BYTES = 2 * 1024**3
DOCUMENTED = (0, 2, 3, 4)
"""Exit codes a verb may end with; 1 is a fault of the program, and what the disk or the system refuses."""


@dataclass(frozen=True)
class Ended:
    """How a verb ended: exit code (minus the signal), processor seconds, memory it took at most, what it said.

    `said` is all a person reads in the terminal, in the order of arrival; `printed` is standard output alone, which is
    what a program reads.
    """

    code: int
    seconds: float
    peak: int
    said: str
    printed: str = ""

    @property
    def traceback(self) -> bool:
        """Whether the program itself failed."""
        return "Traceback" in self.said or "fault of the program" in self.said

    @property
    def trouble(self) -> str:
        """What nobody should ever see, '' when there is none."""
        if self.traceback:
            return "traceback"
        if self.seconds > LONGEST_S:
            return "hang"
        if self.peak > LARGEST_BYTES:
            return "memory"
        return "" if self.code in DOCUMENTED else "exit"


def verb(
    arguments: Sequence[str], *, after: Callable[[], None] | None = None, folder: Path | None = None,
    before: Callable[[], None] | None = None,
) -> Ended:  # fmt: skip
    """Run a verb, and `after` it in the same process if it ended with 0; `before` it the process may be restricted."""
    (output, printing), (errors, warning) = os.pipe(), os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the child uses no thread of its parent
        process = os.fork()
    if process == 0:
        child(printing, arguments, after, folder, before, warning=warning)
    os.close(printing)
    os.close(warning)
    parts, deadline, readers = [], time.monotonic() + SILENCE_S, {output, errors}
    while readers:
        ready, _, _ = select.select(sorted(readers), [], [], max(0.0, deadline - time.monotonic()))
        if not ready:
            os.kill(process, signal.SIGKILL)
            break
        for reader in ready:
            part = os.read(reader, 65536)
            parts.append((reader, part))
            if not part:
                readers.remove(reader)
    os.close(output)
    os.close(errors)
    _, status, usage = os.wait4(process, 0)
    return Ended(
        os.waitstatus_to_exitcode(status), usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024,
        b"".join(part for _, part in parts).decode("utf-8", "replace"),
        b"".join(part for reader, part in parts if reader == output).decode("utf-8", "replace"),
    )  # fmt: skip


def child(
    writer: int, arguments: Sequence[str], after: Callable[[], None] | None = None, folder: Path | None = None,
    before: Callable[[], None] | None = None, *, warning: int | None = None,
) -> None:  # fmt: skip
    """Do the work of the child and end it; what it warns of goes to `writer` too where no place is given for it."""
    code = 1
    try:
        nothing = os.open(os.devnull, os.O_RDONLY)
        for place, target in ((0, nothing), (1, writer), (2, writer if warning is None else warning)):
            os.dup2(target, place)
        cli.sys.stdout = io.TextIOWrapper(io.FileIO(1, "w"), "utf-8", errors="replace", write_through=True)
        cli.sys.stderr = io.TextIOWrapper(io.FileIO(2, "w"), "utf-8", errors="replace", write_through=True)
        resource.setrlimit(resource.RLIMIT_CPU, (int(3 * LONGEST_S), int(3 * LONGEST_S) + 5))
        if folder is not None:
            os.chdir(folder)
        if before is not None:
            before()
        code = cli.main(list(arguments))
        if code == 0 and after is not None:
            after()
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(code)
