"""What compare and diagnose refuse before they compute anything, and with which words."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from etextile.app.cli import main
from etextile.diagnose.data.observe import Record
from etextile.diagnose.predict.parameters import PRIOR_E, reference_strain
from etextile.diagnose.predict.simulate import Runner
from etextile.errors import BadInput
from etextile.studies.diagnose import run as diagnose_run
from etextile.studies.diagnose.compare import require_base
from etextile.studies.diagnose.setting import DiagnosisTask, assemble, log_covariance
from loadcases.fabric import Covariance, load_fabric
from loadcases.measurements import load_measurements
from loadcases.reader import load_case
from loadcases.shipped import measured_folder, measured_names


@pytest.fixture(autouse=True)
def in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def folder_with(channels: str, **files: str) -> Path:
    """Write a folder of measurements with these channels and CSV files."""
    folder = Path("set")
    folder.mkdir()
    (folder / "measured.yaml").write_text(f"title: a test\nchannels:\n{channels}")
    for name, text in files.items():
        (folder / f"{name}.csv").write_text(text)
    return folder


FORCE = "displacement_mm,force_N\n" + "".join(f"{u},{u * u}\n" for u in range(1, 13))
EDGE = "displacement_mm,warp0_mm,warp_mm,weft_mm,height_mm\n" + "".join(f"{u},60,60,49,1\n" for u in range(1, 13))
FIELD = "displacement_mm,warp0_mm,weft0_mm,strain_warp,strain_weft\n" + "".join(f"{u},1,1,0,0\n" for u in range(1, 13))
SLIP = "displacement_mm,weft0_mm,slip_mm\n" + "".join(f"{u},0,0\n" for u in range(1, 13))
WIRES = "displacement_mm,wire,warp0_mm,state\n10,8,0,intact\n"
WITH_FORCE = "punch_force: {files: [b.csv]}\n  wires: {file: a.csv}"


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    """Run both verbs, which refuse with the same words and leave nothing behind; return these words."""
    found = set()
    for verb in ("compare", "diagnose"):
        assert main([verb, *arguments, "-o", "out"]) == 2
        captured = capsys.readouterr()
        assert captured.out == ""
        found.add(captured.err.strip())
    assert not Path("out").exists()
    assert len(found) == 1
    return found.pop()


def test_case_and_measurements_are_complained_about_together(capsys: pytest.CaptureFixture[str]) -> None:
    folder_with("  punch_force: {files: [a.csv], noise: 2 N}\n", a="displacement_mm,force_N\n1,2\n1,3\n2,3\n3,4\n4,5\n")
    message = refused(capsys, "punch", "--measured", "set", "--set", "motion.totl=3")
    assert "motion.totl" in message
    assert "did you mean" in message
    assert "a.csv:3: displacement_mm: repeats 1 with another force; give every specimen a file of its own" in message


@pytest.mark.parametrize(
    ("measured", "words"),
    [
        ("nowhere", "no such folder of measurements (got 'nowhere'), give a path or a shipped one: "),
        ("hidden_clam", "did you mean 'hidden_clamp'?"),
        ("./nowhere", "no such folder of measurements, it must hold measured.yaml"),
    ],
)
def test_measurements_that_are_not_there_are_said_so(
    measured: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert words in refused(capsys, "punch", "--measured", measured)


def test_coupons_alone_are_no_punch_test(capsys: pytest.CaptureFixture[str]) -> None:
    for verb in ("compare", "diagnose"):
        assert main([verb, "punch", "--measured", "nylon_woven", "-o", "out"]) == 2
        assert "no channel of the test to go by, give one of punch_force" in capsys.readouterr().err


def test_wires_alone_can_be_compared_but_not_diagnosed(capsys: pytest.CaptureFixture[str]) -> None:
    folder_with("  wires: {file: a.csv}\n", a=WIRES)
    assert main(["diagnose", "punch", "--measured", "set", "-o", "out"]) == 2
    assert "no channel of the test to go by, give one of punch_force" in capsys.readouterr().err
    assert not Path("out").exists()


def test_an_unknown_key_has_its_line(capsys: pytest.CaptureFixture[str]) -> None:
    folder_with("  punch_force: {files: [a.csv], nois: 2 N}\n", a=FORCE)
    message = refused(capsys, "punch", "--measured", "set")
    assert "measured.yaml:3:" in message
    assert "did you mean 'noise'?" in message


@pytest.mark.parametrize(
    ("channel", "text", "setting", "words"),
    [
        ("free_edge: {file: a.csv}", EDGE, "", "60 mm lies outside of the specimen, which reaches 50 mm"),
        ("free_edge: {file: a.csv}", EDGE.replace(",60,60", ",1,1"), "supports.clamped=[x_min,x_max,y_min,y_max]",
         "so it has no free edge there"),
        ("free_edge: {file: a.csv}", EDGE.replace("60,60,49,1", "40,0.04,0.049,0.001"), "",
         "a.csv:2: weft_mm: 0.049 mm, where the point of the case starts from 50 mm and the punch has moved 1 mm"),
        ("free_edge: {file: a.csv}", EDGE.replace("60,60,49", "40,-40,49"), "", "a.csv:2: warp_mm: -40 mm"),
        ("free_edge: {file: a.csv}", EDGE.replace("60,60,49,1", "40,40,49,120"), "", "a.csv:2: height_mm: 120 mm"),
        ("free_edge: {file: a.csv}", EDGE.replace("60,60,49", "40,40,49") + "80,40,40,30,9\n", "",
         "a.csv:14: displacement_mm: 80 mm is beyond the test, a test of this case reaches 52.5 mm"),
        (WITH_FORCE, WIRES.replace(",8,0,", ",8,51,"), "", "a.csv:2: warp0_mm: 51 mm lies outside"),
        (WITH_FORCE, WIRES + "11,17,0,intact\n", "",
         "a.csv:3: wire: no such wire (got 17), the specimen has wires 0 to 16, counted from -y"),
        (WITH_FORCE, WIRES.replace(",8,0,", ",-1,0,"), "fabric.portion=whole", "no such wire (got -1)"),
        ("strain_field: {file: a.csv}", FIELD.replace(",1,1,", ",1,51,"), "", "a.csv:2: weft0_mm: 51 mm lies outside"),
        ("clamp_line: {file: a.csv}", SLIP, "supports.clamped=[y_min,y_max]", "the case has no clamp at x_max"),
    ],
)  # fmt: skip
def test_a_channel_that_the_case_cannot_have_is_refused(
    channel: str, text: str, setting: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder_with(f"  {channel}\n", a=text, b=FORCE)
    settings = ["--set", setting] if setting else []
    assert words in refused(capsys, "punch", "--measured", "set", *settings)


def test_a_channel_that_goes_on_far_beyond_the_force_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    channels = "  punch_force: {files: [a.csv]}\n  clamp_line: {file: b.csv}\n"
    folder_with(channels, a=FORCE, b=SLIP + "18,0,0\n18.5,0,0\n")
    message = refused(capsys, "punch", "--measured", "set")
    assert "b.csv:15: displacement_mm: 18.5 mm is beyond the test, the force was recorded up to 12 mm" in message


def test_wires_may_be_looked_at_after_the_force_was_recorded() -> None:
    folder_with("  punch_force: {files: [a.csv]}\n  wires: {file: b.csv}\n", a=FORCE, b=WIRES.replace("10,", "52.5,"))
    assert assemble(load_case("punch"), load_measurements("set"), name_effects=False).measured.wires is not None


@pytest.mark.parametrize(
    ("factor", "words"), [(1e-3, "a.csv:13: force_N: peaks at 0.72, where the case takes 720; kN?"), (21.0, "mN? gf?")]
)
def test_forces_that_no_effect_explains_are_refused_after_the_first_run(factor: float, words: str) -> None:
    assert words in objection_to(factor)


@pytest.mark.parametrize("factor", [0.06, 1.0, 19.0])
def test_forces_that_an_effect_may_explain_go_on(factor: float) -> None:
    assert objection_to(factor) == ""


def objection_to(factor: float) -> str:
    """What is said after the first run of forces that are `factor` times the simulated ones, empty when they go on."""
    folder_with("  punch_force: {files: [a.csv]}\n", a=scaled(factor))
    try:
        require_base(*task_and_runner())
    except BadInput as error:
        (problem,) = error.problems
        return str(problem)
    return ""


def scaled(factor: float) -> str:
    """Force over displacement of the straight line that `task_and_runner` simulates, times a factor."""
    return "displacement_mm,force_N\n" + "".join(f"{u},{60 * factor * u}\n" for u in range(1, 13))


def task_and_runner() -> tuple[DiagnosisTask, Runner]:
    """The folder as a task, and a simulator of 60 N per mm that goes on to 20 mm."""
    u, nothing = np.linspace(0.0, 20.0, 11), np.zeros(1)
    record = Record(nothing, nothing, (True, True), u, 60.0 * u, np.zeros((11, 1, 1, 3)), np.zeros((11, 6)))
    task = assemble(load_case("punch"), load_measurements("set"), name_effects=False)
    return task, cast(Runner, lambda requests: [record] * len(requests))


@pytest.mark.parametrize(
    ("case", "settings", "words"),
    [
        ("tension_warp", (), "the force of a punch needs a body, that of a pulled clamp is clamp_force"),
        ("bias_extension", ("motion.total=20",), "the force of a punch needs a body"),
    ],
)
def test_a_case_that_cannot_be_diagnosed_is_refused(
    case: str, settings: tuple[str, ...], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    folder_with("  punch_force: {files: [a.csv]}\n", a=FORCE)
    given = [part for item in settings for part in ("--set", item)]
    message = refused(capsys, case, "--measured", "set", *given)
    assert words in message
    assert "yaml:" in message or "fabric.warp_angle" in message


def test_unknown_and_missing_effects_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    folder_with("  punch_force: {files: [a.csv]}\n", a=FORCE)
    assert main(["diagnose", "punch", "--measured", "set", "--among", "clamp_slop"]) == 2
    assert "--among: unknown effect (got 'clamp_slop')" in capsys.readouterr().err
    assert main(["diagnose", "punch", "--measured", "set", "--effect", "mine.py"]) == 2
    assert "no such Python file (got 'mine.py')" in capsys.readouterr().err


def test_a_fault_of_a_stage_is_told_and_ctrl_c_says_how_to_go_on(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*arguments: object, **options: object) -> None:
        raise KeyboardInterrupt

    folder_with("  punch_force: {files: [a.csv]}\n", a=FORCE)
    monkeypatch.setattr(diagnose_run, "diagnose_task", interrupted)
    assert main(["diagnose", "punch", "--measured", "set", "-o", "out"]) == 130
    assert "simulator runs that ended are kept, the same command goes on with them" in capsys.readouterr().err


def test_files_of_others_are_not_overwritten(capsys: pytest.CaptureFixture[str]) -> None:
    folder_with("  punch_force: {files: [a.csv]}\n", a=FORCE)
    Path("out").mkdir()
    for name in ("compare.json", "diagnosis.json"):
        Path("out", name).write_text("mine")
    for verb in ("compare", "diagnose"):
        assert main([verb, "punch", "--measured", "set", "-o", "out"]) == 2
        assert "choose another --output or overwrite with --force" in capsys.readouterr().err
    assert {path.read_text() for path in Path("out").iterdir()} == {"mine"}
    for path in Path("out").iterdir():
        path.unlink()
    Path("out", "fabric.yaml").write_text("mine")
    assert main(["diagnose", "punch", "--measured", "set", "-o", "out"]) == 2
    assert "holds fabric.yaml of another case" in capsys.readouterr().err


def test_every_shipped_measurement_is_found_by_name() -> None:
    assert {"hidden_clamp", "nylon_woven"} <= set(measured_names())
    for name in measured_names():
        assert (measured_folder(name) / "measured.yaml").is_file()


def test_a_folder_here_comes_before_a_shipped_one() -> None:
    Path("hidden_clamp").mkdir()
    assert measured_folder("hidden_clamp") == Path("hidden_clamp")


def test_a_stated_covariance_turns_into_that_of_logarithms() -> None:
    """By drawing parameters: ln s = ln H + n ln p at the reference strain."""
    family = load_fabric("estimated_mid").warp
    matrix = np.array([[4e4, 0.5], [0.5, 4e-4]])
    stated = family.model_copy(update={"covariance": Covariance(parameters=("H", "n"), matrix=matrix.tolist())})
    found = log_covariance(stated)
    assert found is not None
    rng = np.random.default_rng(0)
    H, n = rng.multivariate_normal([family.H.value, family.n.value], matrix, size=200_000).T
    p = reference_strain(family.strain_range[1])
    drawn = np.cov(np.log(H) + n * np.log(p), n)
    np.testing.assert_allclose(found[1:, 1:], drawn, rtol=0.02)
    assert found[0, 0] == pytest.approx(PRIOR_E**2)
    assert log_covariance(family) is None


def test_compare_json_is_plain_json_when_only_wires_were_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without a channel of the punch test only wires are compared, and a case without wires says so."""
    folder_with("  wires: {file: a.csv}\n", a=WIRES)
    assert main(["compare", "punch", "--measured", "set", "-o", "out", "--set", "wires=null", "--quiet"]) == 0
    found = json.loads(Path("out", "compare.json").read_text())
    assert (found["gap"], found["agree"], found["wires"]) == ([], None, None)
    assert found["notes"] == ["wire states were observed, but the case has no wires"]


@pytest.mark.parametrize(
    ("kind", "doubt", "runs", "code"),
    [
        ("named", False, (0, 0), 0),
        ("named", False, (0, 4), 4),
        ("named", False, (0, 3), 4),
        ("unexplained", False, (), 0),
        ("unexplained", True, (), 4),
        ("no_gap", False, (), 0),
    ],
)
def test_doubt_has_the_exit_code_4(kind: str, doubt: bool, runs: tuple[int, ...], code: int) -> None:
    diagnosis = SimpleNamespace(verdict=SimpleNamespace(kind=kind, lattice_doubt=doubt))
    report = {"trust": {"limits": [{"sentence": "too coarse"}]}}
    base, patched = (SimpleNamespace(exit_code=item, report=report) for item in runs) if runs else (None, None)
    for lost in ("", "a run ended early"):
        proven = SimpleNamespace(base=base, patched=patched, lost=lost)
        doubts = diagnose_run._doubts(diagnosis, proven)  # type: ignore[arg-type]
        outcome = diagnose_run.DiagnosisOutcome(Path(), {}, diagnosis, doubts)  # type: ignore[arg-type]
        assert outcome.exit_code == (4 if lost else code)
