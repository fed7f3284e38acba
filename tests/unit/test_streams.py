"""Texts reach streams that are closed, cut, in a code page or full, and the work goes on; all text stays text."""

import errno
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from etextile import files
from etextile.app import streams
from etextile.app.cli import main
from etextile.app.options import tell_reason
from etextile.errors import BadInput
from etextile.studies.run.outcome import read_report
from etextile.text.plain import as_text
from etextile.visible import visible
from loadcases.reader import load_case


NASTY = "\x1b[31mred\x1b]0;x\x07 \u202eevil [bold]x[/nope] $\\frac{1$ \ud800 <b>&amp; \x00"


def started(arguments: list[str], *, redirect: str = "", **variables: str) -> subprocess.CompletedProcess[bytes]:
    command = f'"{sys.executable}" -m etextile "$@" {redirect}'
    return subprocess.run(
        ["/bin/bash", "-o", "pipefail", "-c", command, "etextile", *arguments],
        capture_output=True,
        check=False,
        env={**os.environ, **variables},
    )


def test_an_outlet_takes_all_and_remembers_the_first_failure() -> None:
    reader, writer = os.pipe()
    outlet = streams.Outlet(writer)
    assert outlet.write(b"one") == 3
    assert os.read(reader, 10) == b"one"
    os.close(reader)
    assert outlet.write(b"two") == 3
    assert outlet.failure is not None
    assert outlet.failure.errno == errno.EPIPE
    assert outlet.write(b"three") == 5
    os.close(writer)


@pytest.mark.parametrize(
    ("text", "encoding", "written"),
    [
        ("12 ° ± 3 µm × 2", "ascii", b"12  deg +- 3 um x 2"),
        ("╭─╮ é Ω ☃", "ascii", b"+-+ e Ohm ?"),
        ("5 mm² – 3 °", "cp1252", "5 mm² – 3 °".encode("cp1252")),
        ("a ≤ b", "latin-1", b"a <= b"),
    ],
)
def test_a_code_page_gets_what_is_most_like_it(text: str, encoding: str, written: bytes) -> None:
    streams.codecs.register_error("plain", streams._plainly)
    assert text.encode(encoding, "plain") == written


@pytest.mark.slow
@pytest.mark.parametrize(
    ("redirect", "code", "said"),
    [
        (">&-", 0, b""),
        (">&- 2>&- <&-", 0, b""),
        ("| head -1", 0, b""),
        ("> /dev/full", 1, b"could not be written (No space left on device)"),
    ],
)
def test_a_stream_that_takes_nothing_is_no_fault(redirect: str, code: int, said: bytes) -> None:
    done = started(["check", "punch"], redirect=redirect)
    assert done.returncode == code
    assert said in done.stderr
    assert b"fault" not in done.stderr
    assert b"Traceback" not in done.stderr


@pytest.mark.slow
def test_text_in_ascii_and_code_pages_is_complete() -> None:
    for encoding in ("ascii", "cp437"):
        done = started(["list"], PYTHONIOENCODING=encoding)
        assert done.returncode == 0
        assert len(done.stdout.decode(encoding).splitlines()) > 30


def test_what_does_not_show_is_spelled_and_text_of_other_scripts_is_kept() -> None:
    assert visible("a\tb\nc é 布 שלום \u200d") == "a\tb\nc é 布 שלום \u200d"
    assert visible("\x1b[2J\u202e\x00\x9b\ud800") == "\\x1b[2J\\u202e\\x00\\x9b\\ud800"


def test_a_title_is_text_on_the_terminal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(f"schema_version: 1\nextends: punch\ntitle: {json.dumps(NASTY)}\n")
    assert load_case(path).case.title == visible(NASTY)
    assert main(["check", str(path)]) == 0
    said = capsys.readouterr().out
    assert visible(NASTY) in said
    assert visible(said) == said


def test_a_message_and_a_report_of_somebody_else_are_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "case.yaml"
    path.write_text(f"schema_version: 1\nextends: punch\n{json.dumps(NASTY)}: 1\nbody: {{type: {json.dumps(NASTY)}}}\n")
    assert main(["check", str(path)]) == 2
    said = capsys.readouterr().err
    assert visible(said) == said
    (tmp_path / "report.json").write_text(json.dumps({"case": {"title": NASTY}}))
    assert read_report(tmp_path)["case"]["title"] == visible(NASTY)


def test_rich_content_takes_brackets_for_text() -> None:
    assert as_text("[bold]x[/nope] :smile:").strip() == "[bold]x[/nope] :smile:"


def test_more_than_twenty_problems_are_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "case.yaml"
    path.write_text("schema_version: 1\nextends: punch\n" + "".join(f"k{number}: 1\n" for number in range(100)))
    assert main(["check", str(path)]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 21
    assert lines[-1] == "and 80 more problems"


def test_a_file_that_is_no_fabric_is_echoed_in_one_short_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "secret.yaml"
    path.write_text("".join(f"secret{number}: {'x' * 500}\n" for number in range(300)))
    assert main(["check", "punch", "--set", f"fabric.set={path}"]) == 2
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1
    assert "secret5" not in said
    assert "xxx" not in said


@pytest.mark.parametrize("tokens", [["-o", ""], ["--output="], ["-o", "  "]])
@pytest.mark.parametrize("verb", ["run", "ensemble"])
def test_an_output_needs_a_name(verb: str, tokens: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([verb, "punch", *tokens]) == 2
    assert "needs a name" in capsys.readouterr().err


def test_an_output_needs_a_name_in_python_too() -> None:
    with pytest.raises(BadInput, match="needs a name"):
        files.named("")


def test_what_is_written_goes_beside_a_link_not_through_it(tmp_path: Path) -> None:
    (tmp_path / "own").write_text("kept")
    for name in ("soft", "hard"):
        path = tmp_path / name
        if name == "soft":
            path.symlink_to("own")
        else:
            path.hardlink_to(tmp_path / "own")
        files.write_whole(path, "new")
        assert (tmp_path / "own").read_text() == "kept"
        assert path.read_text() == "new"
    (tmp_path / "folder").mkdir()
    with pytest.raises(BadInput, match="a folder stands"):
        files.write_whole(tmp_path / "folder", "new")


def test_what_a_killed_writer_left_half_written_goes_with_the_next_one(tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    half = [tmp_path / ".report.4711.part.json", tmp_path / "maps" / ".failure.4711.part.png"]
    others = [tmp_path / "film.part", tmp_path / ".notes.part", tmp_path / "report.json"]
    for path in (*half, *others):
        path.write_text("half")
    with files.owned(tmp_path):
        assert not any(path.exists() for path in half)
    assert all(path.exists() for path in others)


def test_a_file_that_cannot_be_finished_leaves_the_one_before(tmp_path: Path) -> None:
    path = tmp_path / "map.png"
    path.write_text("before")

    def interrupted() -> None:
        with files.replacing(path) as part:
            part.write_text("half")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert [item.name for item in tmp_path.iterdir()] == ["map.png"]
    assert path.read_text() == "before"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names")
def test_a_pipe_is_not_replaced_by_a_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(BadInput, match="a device or a pipe"):
        files.write_whole(tmp_path / "pipe", "text")
    assert (tmp_path / "pipe").is_fifo()


@pytest.mark.parametrize("what", ["report.json/", "maps", "maps ->", "samples ->"])
def test_a_place_that_cannot_be_written_is_found_before_anything_is_computed(
    what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out, elsewhere = tmp_path / "out", tmp_path / "elsewhere"
    out.mkdir()
    elsewhere.mkdir()
    if what.endswith("/"):
        (out / what).mkdir()
    elif what.endswith("->"):
        (out / what.split()[0]).symlink_to(elsewhere)
    else:
        (out / what).write_text("")
    monkeypatch.setattr("etextile.studies.run.simulate.build", None)
    monkeypatch.setattr("etextile.studies.ensemble.run.unit_rows", None)
    assert main(["ensemble" if "samples" in what else "run", "punch", "-o", str(out)]) == 2
    assert "move it away" in capsys.readouterr().err
    assert not list(elsewhere.iterdir())


def test_a_quiet_verb_gives_its_reason_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    tell_reason(4, ["the error of\nenergy is 7 %", "another"], quiet=True)
    tell_reason(4, ["said above"], quiet=False)
    tell_reason(0, ["nothing"], quiet=True)
    assert capsys.readouterr().err == "etextile: the error of energy is 7 %; another\n"
