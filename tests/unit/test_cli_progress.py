"""Progress: a bar on a terminal, a few plain lines in a pipe, nothing when quiet."""

from __future__ import annotations

import contextlib
import io
from types import SimpleNamespace

import pytest

from etextile.app.progress import COMPILING, LINES, PATIENCE, Progress


class Clock:
    """A clock that is put forward by hand."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def increment(displacement: float, *, converged: bool = True) -> SimpleNamespace:
    verdict = SimpleNamespace(iterations=3, converged=converged)
    return SimpleNamespace(displacement_mm=displacement, punch_force_N=10.0 * displacement, verdict=verdict)


def run(stream: io.StringIO, *, seconds: float, steps: int = 100, quiet: bool = False) -> list[str]:
    """Go through a run of equal steps in `seconds` and return the lines that were printed."""
    clock = Clock()
    with Progress("Punch", total=50.0, quiet=quiet, stream=stream, clock=clock) as progress:
        for step in range(1, steps + 1):
            clock.now = seconds * step / steps
            progress.increment(increment(50.0 * step / steps))
    return stream.getvalue().splitlines()


def test_a_pipe_gets_a_few_plain_lines() -> None:
    lines = run(io.StringIO(), seconds=100.0)
    assert len(lines) == LINES
    assert lines[-1] == "Punch: 100 %  50.00 mm     500.0 N   300 Newton iterations  100 s"
    assert lines[0].startswith("Punch:   5 %  2.50 mm")


def test_many_steps_do_not_flood_a_log() -> None:
    assert len(run(io.StringIO(), seconds=1000.0, steps=5000)) <= LINES


def test_fast_work_prints_nothing() -> None:
    assert run(io.StringIO(), seconds=0.9 * PATIENCE) == []


def test_compiling_is_said_where_there_is_somebody_to_read_it() -> None:
    pipe, quiet = io.StringIO(), io.StringIO()
    for stream, silent in ((pipe, False), (quiet, True)):
        with Progress("Punch", total=50.0, quiet=silent, stream=stream) as progress:
            progress.compiling()
    assert pipe.getvalue() == f"Punch: {COMPILING}\n"
    assert quiet.getvalue() == ""


def test_quiet_prints_nothing_anywhere() -> None:
    assert run(io.StringIO(), seconds=100.0, quiet=True) == []
    assert run(Terminal(), seconds=100.0, quiet=True) == []


def test_there_and_back_counts_as_way() -> None:
    clock, stream = Clock(), io.StringIO()
    with Progress("Cycle", total=40.0, stream=stream, clock=clock) as progress:
        clock.now = 10.0
        for displacement in (10.0, 20.0, 10.0, 0.0):
            progress.increment(increment(displacement))
    assert [line.split("%")[0].split(":")[1].strip() for line in stream.getvalue().splitlines()] == [
        "25",
        "50",
        "75",
        "100",
    ]


def test_unconverged_increments_are_called_so() -> None:
    clock, stream = Clock(), io.StringIO()
    with Progress("Punch", total=1.0, stream=stream, clock=clock) as progress:
        clock.now = 10.0
        progress.increment(increment(1.0, converged=False))
    assert "NOT CONVERGED" in stream.getvalue()


def test_a_terminal_gets_a_bar_that_is_taken_away_also_after_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    stream = Terminal()
    progress = Progress("Punch [a]", total=50.0, stream=stream)
    with contextlib.suppress(ZeroDivisionError), progress:
        progress.increment(increment(25.0))
        progress._bar._progress.refresh()  # type: ignore[union-attr]
        raise ZeroDivisionError
    text = stream.getvalue()
    assert "Punch [a]" in text
    assert "25.00 mm" in text
    assert "250.0 N" in text
    assert "3 Newton iterations" in text
    assert text.endswith("\x1b[2K")
