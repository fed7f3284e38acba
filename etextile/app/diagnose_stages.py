"""Progress of a diagnosis: which stage is on, how far its runs have come, and what each stage found.

Findings stay on the screen; on a terminal a bar below them moves, piped output has a line per quarter of the runs, and
one whenever nothing was said for a while: whoever waits knows what is being done.
"""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, TextIO

from etextile.app.progress import rich_bar


STAGES = {
    "check": "check",
    "simulate": "simulate",
    "gate": "0 numerics gate",
    "detect": "1 detect",
    "look": "2 first look",
    "screen": "2 screen",
    "fit": "3 fit",
    "rank": "4 rank",
    "verdict": "5 verdict",
    "further": "further test",
    "next": "6 next measurement",
    "wires": "wires",
    "prove": "7 patch and prove",
}
"""Names of the stages as a person reads them."""
AFTER = {
    "check": "simulate",
    "simulate": "simulate",
    "gate": "detect",
    "detect": "screen",
    "look": "screen",
    "screen": "fit",
    "fit": "rank",
    "rank": "verdict",
    "verdict": "prove",
    "further": "verdict",
    "next": "prove",
}
"""The stage that is on when another has told what it found."""
QUARTERS = 4
SILENCE = 15.0
"""Seconds after which a piped display says what it is at."""
WIDTH = 20


class StageDisplay:
    """Shows the stages of a diagnosis; use as a context manager, `tell` and `watch` are its two inputs."""

    def __init__(
        self, *, quiet: bool = False, stream: TextIO | None = None, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._stream = stream or sys.stderr
        self._clock = clock
        self._begun = clock()
        self._quiet = quiet
        self._stage = "simulate"
        self._quarter = 0
        self._runs = ""
        self._said = self._begun
        self._ended = threading.Event()
        self._lock = threading.Lock()
        self._bar: Any = None if quiet or not self._stream.isatty() else rich_bar(self._stream)
        self._task: Any = None

    def __enter__(self) -> StageDisplay:
        """Start to show."""
        if self._bar is not None:
            self._bar.start()
            self._task = self._bar.add_task(STAGES[self._stage], total=None, text="")
        elif not self._quiet:
            threading.Thread(target=self._keep_talking, daemon=True).start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Leave the terminal clean, also after an error."""
        self._ended.set()
        if self._bar is not None:
            self._bar.stop()

    def tell(self, stage: str, text: str) -> None:
        """Show what a stage found and that the next one is on."""
        if self._quiet:
            return
        line = f"{STAGES.get(stage, stage):<{WIDTH}}  {text}"
        if self._bar is not None:
            from rich.text import Text

            self._bar.console.print(Text(line, overflow="fold"))
        else:
            self._say(line)
        self._stage = AFTER.get(stage, stage)
        self._quarter, self._runs = 0, ""
        if self._bar is not None:
            self._bar.update(self._task, description=STAGES[self._stage], completed=0, total=None, text="")

    def watch(self, done: int, total: int) -> None:
        """Show that `done` of `total` simulator runs of the present stage have ended."""
        if self._quiet:
            return
        if self._bar is not None:
            self._bar.update(self._task, completed=done, total=total, text=f"{done} of {total} runs")
            return
        self._runs = f"{done} of {total} runs"
        if total < 2 * QUARTERS:
            return
        quarter = QUARTERS * done // total
        if quarter > self._quarter:
            self._quarter = quarter
            self._say(f"{STAGES[self._stage]:<{WIDTH}}  {self._runs}")

    def advance(self, done: float, total: float, text: str) -> None:
        """Show how far a single run of the present stage has come."""
        self._runs = " ".join(text.split())
        if self._bar is not None:
            self._bar.update(self._task, completed=done, total=total, text=text)

    def beat(self) -> None:
        """Say what is being done when nothing was said for a while."""
        if self._clock() - self._said >= SILENCE:
            self._say(f"{STAGES[self._stage]:<{WIDTH}}  {self._runs or 'at work'}")

    def _keep_talking(self) -> None:
        while not self._ended.wait(1.0):
            self.beat()

    def _say(self, line: str) -> None:
        """Print a line with the seconds since the start."""
        with self._lock:
            self._said = self._clock()
            print(f"{self._seconds()}  {line}", file=self._stream, flush=True)

    def _seconds(self) -> str:
        return f"{self._clock() - self._begun:5.0f} s"
