"""Progress of long work: a bar on a terminal, at most twenty plain lines when piped, nothing when quiet.

It goes to the standard error, so that the report on the standard output can be piped.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Protocol, TextIO


PATIENCE = 2.0
"""Seconds before plain lines begin: what is faster needs none."""
LINES = 20
"""Plain lines at most."""
COMPILING = "compiling for this machine, once, about 10 s"


class VerdictLike(Protocol):
    """What progress reads of a verdict."""

    @property
    def iterations(self) -> int:
        """Newton iterations of the increment."""

    @property
    def converged(self) -> bool:
        """Whether the increment converged."""


class IncrementLike(Protocol):
    """What progress reads of an increment (`etextile.solve.path.Increment`)."""

    @property
    def displacement_mm(self) -> float:
        """Displacement reached, mm."""

    @property
    def punch_force_N(self) -> float:  # noqa: N802 (name of the result column)
        """Force at this displacement, N."""

    @property
    def verdict(self) -> VerdictLike:
        """How the increment was found."""


class Progress:
    """Shows how far work of size `total` (in `unit`: mm, or deg of a joint) has come; use as a context manager."""

    def __init__(
        self,
        title: str,
        *,
        total: float,
        unit: str = "mm",
        quiet: bool = False,
        stream: TextIO | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._title, self._total, self._unit = title, total, unit
        self._stream = stream or sys.stderr
        self._clock = clock
        self._started = clock()
        self._line = 0
        self._travel = self._last = 0.0
        self._iterations = 0
        self._quiet = quiet
        self._bar = None if quiet or not self._stream.isatty() else _Bar(title, total=total, stream=self._stream)

    def __enter__(self) -> Progress:
        """Start to show."""
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave the terminal clean, also after an error."""
        self.stop()

    def stop(self) -> None:
        """Take the bar away, if there is one; once is enough, twice does no harm."""
        if self._bar is not None:
            self._bar.stop()

    def compiling(self) -> None:
        """Say why the first run on a machine takes longer to begin."""
        if self._quiet:
            return
        if self._bar is not None:
            self._bar.advance(0.0, COMPILING)
        else:
            print(f"{self._title}: {COMPILING}", file=self._stream, flush=True)

    def increment(self, increment: IncrementLike) -> None:
        """Show a converged increment: displacement, force, Newton iterations so far."""
        self._travel += abs(increment.displacement_mm - self._last)
        self._last = increment.displacement_mm
        self._iterations += increment.verdict.iterations
        mark = "" if increment.verdict.converged else "  NOT CONVERGED"
        load = f"{increment.displacement_mm:7.2f} {self._unit}  {increment.punch_force_N:8.1f} N"
        if self._unit == "deg":
            angle, moment = increment.displacement_mm, math.degrees(increment.punch_force_N)
            load = f"{angle:7.2f} deg  {moment:8.0f} N mm" if angle > 0.0 else f"put on, {-angle:5.2f} mm to go"
        text = f"{load}  {self._iterations:4d} Newton iterations{mark}"
        self.advance(self._travel, text)

    def advance(self, done: float, text: str) -> None:
        """Show that `done` of the total is reached, with a few words."""
        if self._quiet:
            return
        if self._bar is not None:
            self._bar.advance(done, text)
            return
        elapsed = self._clock() - self._started
        line = int(LINES * min(done / self._total, 1.0)) if self._total > 0 else LINES
        if line > self._line and elapsed >= PATIENCE:
            self._line = line
            share = f"{100 * min(done / self._total, 1.0):3.0f} %" if self._total > 0 else "100 %"
            print(f"{self._title}: {share}  {text.strip()}  {elapsed:.0f} s", file=self._stream, flush=True)


class _Bar:
    """The rich progress bar of a terminal."""

    def __init__(self, title: str, *, total: float, stream: TextIO) -> None:
        self._progress = rich_bar(stream)
        self._task = self._progress.add_task(title, total=total, text="")

    def start(self) -> None:
        """Draw the bar."""
        self._progress.start()

    def stop(self) -> None:
        """Take the bar away."""
        self._progress.stop()

    def advance(self, done: float, text: str) -> None:
        """Move the bar."""
        self._progress.update(self._task, completed=done, text=text)


def rich_bar(stream: TextIO) -> Any:
    """Return the bar of a terminal, to which tasks with a `text` are added."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

    return Progress(
        SpinnerColumn(),
        TextColumn("{task.description}", style="bold", markup=False),
        BarColumn(bar_width=24),
        TextColumn("{task.fields[text]}", markup=False),
        TimeElapsedColumn(),
        console=Console(file=stream),
        transient=True,
    )
