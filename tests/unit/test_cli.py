"""The command line: verbs, exit codes, and one clear message for every mistake."""

from __future__ import annotations

import errno
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import etextile
from etextile.app.cli import VERBS, main
from etextile.environment import THREADS
from etextile.errors import BadInput, NoEquilibrium


@pytest.fixture(autouse=True)
def in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")


@pytest.fixture
def pipeline(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[..., Any]], None]:
    """Puts a function in the place of the simulation."""

    def replace(run: Callable[..., Any]) -> None:
        monkeypatch.setattr(etextile, "run", run)

    return replace


@pytest.fixture
def plan(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[..., Any]], None]:
    """Puts a function in the place of the planning of the model."""

    def replace(function: Callable[..., Any]) -> None:
        monkeypatch.setitem(sys.modules, "loadcases.build", SimpleNamespace(plan=function))

    return replace


def complaint(capsys: pytest.CaptureFixture[str], *arguments: str, code: int = 2) -> str:
    """Run a command that fails and return what it says; nothing goes to the standard output."""
    assert main(arguments) == code
    captured = capsys.readouterr()
    assert captured.out == ""
    return captured.err.strip()


def test_help_names_every_verb_and_the_exit_codes(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    text = capsys.readouterr().out
    assert all(f" {verb} " in text for verb in VERBS)
    assert "Exit codes: 0 done, 2 bad input, 3 no equilibrium" in text


def test_the_bare_command_shows_its_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    assert "Usage: etextile COMMAND" in capsys.readouterr().out


@pytest.mark.parametrize("verb", VERBS)
def test_help_of_every_verb_shows_an_example(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([verb, "--help"]) == 0
    text = capsys.readouterr().out
    assert f"Usage: etextile {verb}" in text
    assert f"Example:\n\n  etextile {verb}" in text


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out.startswith("etextile ")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("rn", "punch"), 'etextile: Unknown command "rn". Did you mean "run"?'),
        (("check",), "etextile check: CASE is missing."),
        (("check", "punch", "elbow"), "etextile check: too many arguments: ['elbow']."),
        (("check", "punch", "--st", "a=1"), "etextile check: Unknown option: --st. Did you mean --set?"),
        (("check", "punch", "--set"), "etextile check: --set is missing."),
        (("run", "punch", "--jobs", "0"), 'etextile run: Invalid value "0" for --jobs.'),
        (
            ("run", "punch", "--jobs", "two"),
            'etextile run: Invalid value for --jobs: unable to convert "two" into int.',
        ),
        (("run", "punch", "--seed", "-1"), 'etextile run: Invalid value "-1" for --seed.'),
        (("report", "x", "--format", "pdf"), 'etextile report: Invalid value "pdf" for --format.'),
        (("schema", "cases"), 'etextile schema: Invalid value "cases" for KIND.'),
    ],
)
def test_mistakes_on_the_command_line(
    arguments: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = complaint(capsys, *arguments)
    assert text.startswith(message)
    assert text.splitlines()[-1].startswith("See: etextile")


def test_a_wrong_case_is_refused_before_anything_is_computed_or_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], pipeline: Callable[..., None]
) -> None:
    pipeline(lambda *_, **__: pytest.fail("computed"))
    text = complaint(capsys, "run", "punch", "-o", "out", "--set", "motion.steps=0", "--set", "contact.fricton=1")
    assert [line.split(": ")[1] for line in text.splitlines()] == ["motion.steps", "contact.fricton"]
    assert list(tmp_path.iterdir()) == []


def test_an_unknown_case_is_refused_with_the_nearest(capsys: pytest.CaptureFixture[str]) -> None:
    text = complaint(capsys, "check", "elbw")
    assert text.startswith("etextile: no such case (got 'elbw')")
    assert text.endswith("did you mean 'elbow'?")


def test_check_says_what_would_be_run(capsys: pytest.CaptureFixture[str], plan: Callable[..., None]) -> None:
    plan(lambda case: {"cells": (9, 16), "trusses": 601, "wires": 9, "steps": case.motion.steps, "notes": ["rounded"]})
    assert main(["check", "punch", "--set", "motion.steps=7"]) == 0
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    assert lines[0] == "Punch test: ready to run"
    assert "cells 9 x 16" in lines
    assert "steps 7" in lines
    assert "note rounded" in lines
    assert "body sphere, radius 15" in lines
    assert any(line.startswith("fabric estimated_mid, quarter of 100 x 100 mm, coarsening 19.5") for line in lines)


def test_check_verbose_prints_the_case_with_all_defaults(
    capsys: pytest.CaptureFixture[str], plan: Callable[..., None]
) -> None:
    from loadcases.reader import load_case, read_case

    plan(lambda case: {})
    assert main(["check", "knee", "-v"]) == 0
    text = capsys.readouterr().out.split("# the case as it is run, with all defaults\n")[1]
    assert read_case(text).case == load_case("knee").case


def test_check_quiet_says_nothing(capsys: pytest.CaptureFixture[str], plan: Callable[..., None]) -> None:
    plan(lambda case: {"cells": (1, 1)})
    assert main(["check", "punch", "--quiet"]) == 0
    captured = capsys.readouterr()
    assert captured.out == captured.err == ""


def test_problems_found_while_planning_are_placed_in_the_case(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], plan: Callable[..., None]
) -> None:
    def refuse(case: object) -> None:
        raise BadInput.of("no wire fits", key="wires.first_offset")

    plan(refuse)
    (tmp_path / "mine.yaml").write_text("extends: punch\nwires:\n  first_offset: 70\n", encoding="utf-8")
    assert complaint(capsys, "check", "mine.yaml") == "mine.yaml:3:17: wires.first_offset: no wire fits"


def test_run_hands_the_options_on_and_prints_the_report_before_the_maps_are_drawn(
    capsys: pytest.CaptureFixture[str], pipeline: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: dict[str, Any] = {}

    def run(loaded: Any, output: Path, **options: Any) -> SimpleNamespace:
        seen.update(options, title=loaded.case.title, output=output, threads=os.environ["MKL_NUM_THREADS"])
        options["judged"](SimpleNamespace(report={"trust": {"limits": []}}))
        seen["before the maps"] = capsys.readouterr().out
        return SimpleNamespace(exit_code=0, folder=output, reasons=[], remarks=("no maps",))

    pipeline(run)
    monkeypatch.setattr("etextile.text.run.report_text", lambda report, folder: f"the report in {folder}")
    for name in THREADS:
        monkeypatch.setenv(name, "1")  # put back after the test
    assert main(["run", "punch", "--jobs", "2", "--seed", "5", "--resume", "--patch", "patch.yaml"]) == 0
    assert seen["before the maps"] == "the report in out/punch\n"
    assert capsys.readouterr().out == "no maps\n"
    assert (seen["title"], seen["output"], seen["patch"]) == ("Punch test", Path("out/punch"), Path("patch.yaml"))
    assert (seen["threads"], seen["seed"], seen["resume"], seen["force"]) == ("2", 5, True, False)


@pytest.mark.parametrize("code", [0, 3, 4])
def test_run_returns_the_exit_code_of_the_run(code: int, pipeline: Callable[..., None]) -> None:
    pipeline(lambda *_, **__: SimpleNamespace(exit_code=code, folder=Path(), reasons=[], remarks=()))
    assert main(["run", "punch", "--quiet"]) == code


def raising(error: BaseException) -> Callable[..., Any]:
    """Return a function that raises."""

    def run(*_: object, **__: object) -> None:
        raise error

    return run


@pytest.mark.parametrize(
    ("error", "code", "message"),
    [
        (NoEquilibrium("step 7 stalled"), 3, "etextile: step 7 stalled"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (PermissionError(errno.EACCES, "Permission denied", "out"), 2, "etextile: out: Permission denied"),
        (OSError(errno.ENOSPC, "No space left on device", "out"), 1, "etextile: out: No space left on device"),
    ],
)
def test_what_ends_a_run_has_its_exit_code(
    error: BaseException, code: int, message: str, capsys: pytest.CaptureFixture[str], pipeline: Callable[..., None]
) -> None:
    pipeline(raising(error))
    assert complaint(capsys, "run", "punch", code=code) == message


def test_faults_take_one_line_and_a_traceback_only_when_asked(
    capsys: pytest.CaptureFixture[str], pipeline: Callable[..., None]
) -> None:
    pipeline(raising(ZeroDivisionError("no good")))
    text = complaint(capsys, "run", "punch", code=1)
    assert text.startswith("etextile: fault of the program: ZeroDivisionError: no good in test_cli.py:")
    assert "report it" in text
    assert "Traceback" not in text
    assert "Traceback" in complaint(capsys, "run", "punch", "-v", code=1)


# report


REPORT = {"case": {"title": "T"}, "wires": []}


def test_report_prints_json_and_html_as_they_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "report.json").write_text(json.dumps(REPORT), encoding="utf-8")
    (tmp_path / "report.html").write_text("<html>ä</html>", encoding="utf-8")
    assert main(["report", ".", "--format", "json"]) == 0
    assert json.loads(capsys.readouterr().out) == REPORT
    assert main(["report", ".", "--format", "html"]) == 0
    assert capsys.readouterr().out == "<html>ä</html>"


def test_report_says_why_there_is_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert complaint(capsys, "report", "nowhere") == "nowhere: no such folder, give the output folder of a run"
    assert complaint(capsys, "report", ".") == ".: no report.json in it: not the output folder of a run"
    (tmp_path / "results.vtkhdf").touch()
    assert complaint(capsys, "report", ".") == "results.vtkhdf: not a result file (not HDF5)"
    (tmp_path / "report.json").write_text('{"case": ', encoding="utf-8")
    assert complaint(capsys, "report", ".").startswith("report.json: not a report, the file is damaged")
    assert complaint(capsys, "report", "report.json").startswith("report.json: this is a file, give the output folder")


# schema


@pytest.mark.parametrize("kind", ["case", "fabric", "wire"])
def test_schema_prints_json_schema(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", kind]) == 0
    schema = json.loads(capsys.readouterr().out)
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert schema["additionalProperties"] is False


def test_every_key_of_a_case_has_a_description_and_numbers_take_units() -> None:
    from loadcases.json_schema import json_schema

    schema = json_schema("case")
    for name, part in [("case", schema), *schema["$defs"].items()]:
        for key, item in part["properties"].items():
            assert item.get("description"), f"{name}.{key}"
    radius = schema["$defs"]["Sphere"]["properties"]["radius"]
    assert radius["unit"] == "mm"
    assert [option["type"] for option in radius["anyOf"]] == ["number", "string"]
    assert radius["anyOf"][0]["exclusiveMinimum"] == 0
    assert schema["$defs"]["Failure"]["properties"]["onset"]["unit"] == "1"


def test_keys_are_required_only_without_extends() -> None:
    from loadcases.json_schema import json_schema

    schema = json_schema("case")
    assert "required" not in schema
    assert schema["else"]["required"] == ["schema_version", "title", "fabric", "motion"]
    assert schema["else"]["properties"]["motion"]["required"] == ["steps"]
    assert schema["if"]["required"] == ["extends"]


def test_check_names_the_wires_of_a_drawing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = tmp_path / "case.yaml"
    lines = ["schema_version: 1", "title: Band", "extends: punch", "fabric: {portion: whole}", "wires:", "  paths:"]
    case.write_text("\n".join([*lines, "    - {name: VCC, along: warp, at: 5}", ""]))
    assert main(["check", str(case)]) == 0
    assert "drawn: VCC" in capsys.readouterr().out


def test_a_shell_completes_verbs_and_options(capsys: pytest.CaptureFixture[str]) -> None:
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("no bash here")
    assert main(["completion", "bash"]) == 0
    script = capsys.readouterr().out

    def completed(*words: str) -> list[str]:
        line = " ".join(f"'{word}'" for word in words)
        ask = f"COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}; _etextile; printf '%s\\n' \"${{COMPREPLY[@]}}\""
        return subprocess.run(
            [bash, "-c", f"{script}\n{ask}"], capture_output=True, text=True, check=True
        ).stdout.split()

    assert completed("etextile", "insp") == ["inspect"]
    assert "--measured" in completed("etextile", "diagnose", "--mea")
