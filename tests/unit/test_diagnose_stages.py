"""The display of a diagnosis: every finding as a line, a few lines of progress when piped, a bar on a terminal."""

from __future__ import annotations

import io

import pytest

from etextile.app.diagnose_stages import StageDisplay


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def go_through(stream: io.StringIO, *, quiet: bool = False) -> str:
    """Show two stages with a hundred runs between."""
    with StageDisplay(stream=stream, quiet=quiet, clock=lambda: 0.0) as show:
        show.tell("simulate", "100 runs")
        for done in range(1, 101):
            show.watch(done, 100)
        show.tell("gate", "0.3 % of the force stay open")
        show.watch(1, 1)
        show.advance(10.0, 40.0, "the ordinary run")
        show.tell("detect", "force +6 % from 26 mm")
    return stream.getvalue()


def test_a_pipe_gets_findings_and_a_line_per_quarter_of_the_runs() -> None:
    lines = go_through(io.StringIO()).splitlines()
    assert [line.split("s  ", 1)[1].strip() for line in lines] == [
        "simulate              100 runs",
        "simulate              25 of 100 runs",
        "simulate              50 of 100 runs",
        "simulate              75 of 100 runs",
        "simulate              100 of 100 runs",
        "0 numerics gate       0.3 % of the force stay open",
        "1 detect              force +6 % from 26 mm",
    ]


def test_a_long_stage_says_what_it_is_at_when_nothing_happens() -> None:
    stream, now = io.StringIO(), [0.0]
    show = StageDisplay(stream=stream, clock=lambda: now[0])
    show.tell("simulate", "5 runs")
    for now[0] in (5.0, 14.0):
        show.beat()
    assert len(stream.getvalue().splitlines()) == 1
    now[0] = 16.0
    show.watch(2, 5)
    show.beat()
    now[0] = 30.0
    show.beat()
    now[0] = 31.0
    show.beat()
    show.tell("simulate", "done")
    show.tell("screen", "found")
    now[0] = 60.0
    show.beat()
    assert [line.strip() for line in stream.getvalue().splitlines()[1:]] == [
        "16 s  simulate              2 of 5 runs",
        "31 s  simulate              2 of 5 runs",
        "31 s  simulate              done",
        "31 s  2 screen              found",
        "60 s  3 fit                 at work",
    ]


def test_quiet_shows_nothing_anywhere() -> None:
    assert go_through(io.StringIO(), quiet=True) == ""
    assert go_through(Terminal(), quiet=True) == ""


def test_a_terminal_keeps_the_findings_and_loses_the_bar(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "100")
    text = go_through(Terminal())
    assert "0.3 % of the force stay open" in text
    assert "force +6 % from 26 mm" in text
    assert text.endswith("\x1b[2K")
