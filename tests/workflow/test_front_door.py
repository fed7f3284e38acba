"""`import etextile as et`: what stands there, what a run gives back, and a notebook from case to picture."""

from __future__ import annotations

import inspect
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import etextile as et
from etextile.app.cli import main
from etextile.studies.run.outcome import Run, unfit
from etextile.studies.table import Table
from etextile.text.run import report_text
from etextile.text.summary import WORDS
from loadcases.reader import load_case
from wires.seal import sealed


QUICK = {"motion.steps": 3, "fabric.coarsening": 60, "outputs.maps": []}
"""A punch of a few cells, in a second."""

NOTEBOOK = """
import etextile as et
import matplotlib.pyplot as plt

case = et.load("punch", {"motion.total": "25 mm", "motion.steps": 5, "fabric.coarsening": 40})
run = et.run(case, "out/punch")
loop = run.loop(wire=0, loop=0)
plt.plot(loop["displacement_mm"], loop["span_strain"], label="fabric under the loop")
plt.plot(loop["displacement_mm"], loop["wire_strain"], label="wire in the loop")
plt.legend()
plt.savefig("loop.png")
run.failure_map("failure.png", step=-1, flat=True)
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    changes = {**QUICK, "wires.every_warp_yarns": 200, "wires.first_offset": "20 mm"}
    return et.run(et.load("punch", changes), tmp_path_factory.mktemp("front") / "out")


def test_every_public_name_is_there_and_nothing_else_is_loaded_by_the_import() -> None:
    for name in et.__all__:
        assert getattr(et, name).__doc__, name
    assert set(et.__all__) <= set(dir(et))
    code = "import sys, etextile; print(*(name for name in ('numpy', 'pydantic', 'rich') if name in sys.modules))"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == ""


def test_whatever_a_study_returns_has_a_summary() -> None:
    studies = set(et.__all__) - {"advise", "build", "bundle_damage", "implicit_body", "summary"}
    for name in sorted(studies):
        if inspect.isfunction(study := getattr(et, name)):
            told = str(inspect.signature(study).return_annotation).split(" | ")
            assert set(told) <= set(WORDS), name


def test_a_summary_is_what_the_verb_prints(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    text = et.summary(run)
    assert run.report["verdict"]["sentence"][:40] in text
    assert text.splitlines() == report_text(run.report, folder=run.folder).splitlines()
    assert main(["check", "punch"]) == 0
    assert capsys.readouterr().out == f"{et.summary(et.load('punch'))}\n"
    with pytest.raises(et.BadInput, match="no summary of this"):
        et.summary({"verdict": "fine"})


@pytest.mark.parametrize("name", ["identify", "diagnose", "ensemble"])
def test_packages_of_the_same_name_do_not_take_the_place_of_a_function(name: str) -> None:
    modules = {"identify": "identify.curves", "diagnose": "diagnose.workflow", "ensemble": "ensemble.store"}
    code = f"import etextile.{modules[name]}, etextile as et; print(callable(et.{name}), et.{name}.__name__)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.split() == ["True", name]


def changed(run: Run, folder: Path, how: str) -> Path:
    """Return a copy of a run's folder in which a number was changed, the results are others, or the report is gone."""
    folder.mkdir()
    shutil.copy(run.folder / "results.vtkhdf", folder)
    report = json.loads((run.folder / "report.json").read_text(encoding="utf-8"))
    if how == "a number":
        report["wires"][0]["max_strain"] += 1e-9
    if how == "other results":
        del report["seal"]
        report = sealed({**report, "results_sha256": "0" * 64})
    if how != "alone":
        (folder / "report.json").write_text(json.dumps(report, indent=3), encoding="utf-8")
    return folder


@pytest.mark.parametrize(
    ("how", "why"), [("a number", "it was changed after"), ("other results", "it is of other results"), ("", None)]
)
def test_a_report_that_was_changed_or_is_of_other_results_is_told(
    how: str, why: str | None, run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Another layout of the same JSON is no change."""
    folder = changed(run, tmp_path / "out", how)
    assert main(["report", str(folder), "--format", "json"]) == (2 if why else 0)
    assert (why or "") in capsys.readouterr().err
    assert unfit(folder) == "" if why is None else unfit(folder).startswith(why)


def test_a_result_file_alone_gives_the_report_of_its_run(
    run: Run, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = changed(run, tmp_path / "out", "alone")
    assert main(["report", str(folder), "--format", "json"]) == 0
    said = capsys.readouterr()
    assert "made again" in said.err
    report, timed = json.loads(said.out), {"solver", "notes", "extrapolation"}
    assert {key: value for key, value in report.items() if key not in timed} == {
        key: value for key, value in run.report.items() if key not in timed
    }
    # the laws continued otherwise are solved again, from numbers as the file keeps them
    again, before = report["extrapolation"]["continuations"], run.report["extrapolation"]["continuations"]
    for name in ("low", "high"):
        assert again[name]["force_N"] == pytest.approx(before[name]["force_N"], rel=1e-9)
    assert [path.name for path in folder.iterdir()] == ["results.vtkhdf"]
    assert main(["report", str(folder), "--format", "html"]) == 0
    assert capsys.readouterr().out.rstrip().endswith("</html>")


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no attribute 'simulate'"):
        et.simulate  # noqa: B018


@pytest.mark.parametrize(
    ("changes", "texts"),
    [
        ({"motion.total": "25 mm", "motion.steps": 5}, ("motion.total=25 mm", "motion.steps=5")),
        ({"wires": None, "contact.friction": 0.5}, ("wires=null", "contact.friction=0.5")),
        (
            {"fabric.size": (80, "60 mm"), "outputs.maps": ["failure"]},
            ("fabric.size=[80, 60 mm]", "outputs.maps=[failure]"),
        ),
        ({"fabric.coarsening": np.float64(26.0)}, ("fabric.coarsening=26.0",)),
    ],
)
def test_changes_in_python_are_those_of_the_command_line(changes: dict[str, object], texts: tuple[str, ...]) -> None:
    assert et.load("punch", changes).case == load_case("punch", overrides=texts).case


def test_a_mistake_in_a_change_names_its_key() -> None:
    with pytest.raises(et.BadInput, match=r"motion\.totl"):
        et.load("punch", {"motion.totl": 3})


def test_a_run_gives_tables_as_its_files_hold_them(run: Run) -> None:
    written = pd.read_csv(run.folder / "wires.csv", dtype={"name": str})
    loops = run.loops
    assert isinstance(loops, pd.DataFrame)
    assert list(loops.columns) == list(written.columns)
    pd.testing.assert_frame_equal(loops.convert_dtypes(), written.convert_dtypes(), rtol=1e-6, check_dtype=False)
    assert loops.attrs["units"]["first_failure_mm"] == "mm"
    assert loops.attrs["units"]["max_strain"] == ""
    assert len(run.wires) == len(run.report["wires"]) == written["wire"].nunique()
    curves = pd.read_csv(run.folder / "force_displacement.csv")
    np.testing.assert_allclose(run.curves["force_N"], curves["force_N"], rtol=1e-6)


def test_tables_are_plain_arrays_without_pandas(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    frame = run.loops
    monkeypatch.setitem(sys.modules, "pandas", None)
    table = run.loops
    assert isinstance(table, Table)
    assert list(table) == list(frame)
    assert len(table) == len(frame) > 0
    np.testing.assert_array_equal(table["max_strain"], np.asarray(frame["max_strain"]))
    assert table["max_strain"].dtype == np.float64


def test_the_history_of_a_loop_begins_flat_and_ends_with_the_reported_strain(run: Run) -> None:
    row = run.report["wires"][-1]
    history = run.loop(row["wire"], row["loops"][-1]["loop"])
    assert history["displacement_mm"][0] == history["span_strain"][0] == 0.0
    assert max(history["span_strain"]) == pytest.approx(row["loops"][-1]["max_strain"])
    with pytest.raises(et.BadInput, match="no loop 99 on a wire 0"):
        run.loop(0, 99)


def test_arrays_come_with_their_units(run: Run) -> None:
    assert run.unit("displacement") == "mm"
    assert run.array("displacement", -1).shape[1] == 3
    with pytest.raises(et.BadInput, match="no array 'strian'"):
        run.unit("strian")


def test_a_folder_opens_as_the_run_that_wrote_it(run: Run) -> None:
    again = et.open(run.folder)
    assert again.report == run.report
    assert again.exit_code == run.exit_code
    np.testing.assert_array_equal(again.tables["loops"]["max_strain"], run.tables["loops"]["max_strain"])
    with pytest.raises(et.BadInput, match="no such folder"):
        et.open(run.folder / "nothing")


def test_a_run_without_equilibrium_opens_with_its_exit_code(tmp_path: Path) -> None:
    changes = {**QUICK, "solver.max_iterations": 1, "solver.max_cut_backs": 0, "wires": None}
    done = et.run(et.load("punch", changes), tmp_path)
    assert done.exit_code == et.open(tmp_path).exit_code == 3


def test_failure_maps_are_drawn_of_any_step(run: Run, tmp_path: Path) -> None:
    first, last = (run.failure_map(tmp_path / f"{step}.png", step, flat=True) for step in (0, -1))
    assert first.read_bytes() != last.read_bytes()
    with pytest.raises(et.BadInput, match=r"maps are \.png files"):
        run.failure_map(tmp_path / "map.pdf", flat=True)
    with pytest.raises(et.BadInput, match="step 7 asked for"):
        run.failure_map(tmp_path / "map.png", 7, flat=True)


def test_nothing_of_the_front_door_prints(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    et.build("punch")
    et.size_loops(et.load("punch", {**QUICK, "failure.criterion": "wire_strain"}), tmp_path / "loops", target=0.5)
    captured = capfd.readouterr()
    assert captured.out == captured.err == ""


def test_a_notebook_of_a_dozen_lines_goes_from_case_to_pictures(tmp_path: Path) -> None:
    lines = [line for line in NOTEBOOK.splitlines() if line]
    assert len(lines) <= 12
    done = subprocess.run([sys.executable, "-c", NOTEBOOK], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout == ""
    for name in ("loop.png", "failure.png"):
        assert (tmp_path / name).stat().st_size > 10_000
