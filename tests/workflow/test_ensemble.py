"""Ensembles from case to verdict: files, resume, workers that die, other schedulers; designs side by side.

Without a mark: samples run in this process. Marked slow: real worker processes.
"""

from __future__ import annotations

import csv
import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import etextile as et
from etextile.app.cli import main
from etextile.ensemble import schedule
from etextile.ensemble.schedule import TaskOutcome
from etextile.errors import BadInput
from etextile.studies.ensemble.designs import compare_designs, sentence
from etextile.studies.ensemble.run import EnsembleOutcome
from etextile.studies.ensemble.run import ensemble as run_ensemble
from etextile.studies.page import page_of
from etextile.text.designs import compare_text
from etextile.text.ensemble import ensemble_text
from loadcases.reader import LoadedCase, load_case


LIMIT_PASSED = 4
"""Exit code: the lattice of SMALL is too coarse for the ball."""
SMALL = ("fabric.coarsening=60", "motion.total=28 mm", "motion.steps=7")
NO_EQUILIBRIUM = ("solver.max_iterations=4", "solver.max_cut_backs=0")
KEYS = {"samples", "failed_runs", "seed", "wires"}


def small(*overrides: str) -> LoadedCase:
    return load_case("punch", overrides=(*SMALL, *overrides))


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Run samples in this process, and list the tasks that were run."""
    ran: list[Any] = []

    @contextmanager
    def nobody(**_: Any) -> Iterator[None]:
        yield None

    def run_all(_: None, function: Callable[[Any], Any], tasks: Sequence[Any], *, names: Sequence[str]) -> Any:
        assert len(set(names)) == len(tasks)
        for task in reversed(tasks):
            ran.append(task)
            yield TaskOutcome(task, function(task))

    monkeypatch.setattr(schedule, "workers", nobody)
    monkeypatch.setattr(schedule, "run_all", run_all)
    return ran


@pytest.fixture
def undrawn(here: list[Any], monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """As `here`, without pictures and without the run that has no scatter."""
    monkeypatch.setattr("etextile.studies.ensemble.run._without_scatter", lambda *_: [])
    monkeypatch.setattr("etextile.studies.ensemble.drawing.draw", lambda *_: ())
    monkeypatch.setattr("etextile.studies.ensemble.drawing.chances", lambda *_: None)
    return here


def ensemble(folder: Path, *overrides: str, samples: int = 4, **options: Any) -> EnsembleOutcome:
    return run_ensemble(small(*overrides), folder, samples=samples, **options)


def on_page(path: Path) -> Any:
    """Return the data a page carries."""
    found = re.search(r'id="live-data">(.*?)</script>', path.read_text(encoding="utf-8"), re.DOTALL)
    assert found is not None
    return json.loads(found.group(1))


def table(folder: Path) -> list[dict[str, str]]:
    with (folder / "samples.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_an_ensemble_leaves_what_was_promised(here: list[Any], tmp_path: Path) -> None:
    said: list[tuple[int, str]] = []
    outcome = ensemble(tmp_path / "out", seed=7, watch=lambda done, words: said.append((done, words)))
    data = json.loads((tmp_path / "out" / "ensemble.json").read_text(encoding="utf-8"))
    assert outcome.exit_code == LIMIT_PASSED
    assert data["trust"]["limits"] == {"lattice cut over the radius of the body": 4}
    (cut,) = data["trust"]["without_scatter"]["limits"]
    assert cut.startswith("lattice cut over the radius of the body")
    assert "In 27 of 27 loops geometry alone decides" in data["trust"]["without_scatter"]["laws"]
    assert data == outcome.data
    assert set(data) >= KEYS
    assert (data["samples"], data["failed_runs"], data["seed"]) == (4, 0, 7)
    assert len(data["wires"]) == 9
    for row in [*data["wires"], *(loop for wire in data["wires"] for loop in wire["loops"])]:
        assert 0.0 <= row["low"] <= row["failure_probability"] <= row["high"] <= 1.0
        assert 0.0 <= row["open_low"] <= row["open_probability"] <= row["open_high"] <= 1.0
    assert data["wires"][0]["failure_probability"] > 0.99 > 0.01 > data["wires"][-1]["failure_probability"]
    names = ("fragility", "fragility_wires", "probability", "probability_open")
    assert all((tmp_path / "out" / f"{name}.png").stat().st_size > 10_000 for name in names)
    assert [row["sample"] for row in table(tmp_path / "out")] == ["0", "1", "2", "3"]
    (shown,) = on_page(tmp_path / "out" / "ensemble.html")["designs"]
    ends = [[row[name] for name in ("failure_probability", "low", "high")]
            for wire in data["wires"] for row in wire["loops"]]  # fmt: skip
    assert [[loop[name][-1] for name in ("value", "low", "high")] for loop in shown["loops"]] == [
        pytest.approx(row, abs=1e-6) for row in ends
    ]
    assert page_of(tmp_path / "out").name == "ensemble.html"
    assert said[0][0] == 0
    assert said[-1][0] == 4


def test_the_summary_fits_a_terminal(undrawn: list[Any], tmp_path: Path) -> None:
    text = ensemble_text(ensemble(tmp_path / "out").data)
    assert max(map(len, text.splitlines())) <= 80
    assert "Failure probability" in text
    assert "a quarter keeps its symmetry" in text


def test_samples_in_the_folder_are_not_run_again(undrawn: list[Any], tmp_path: Path) -> None:
    first = ensemble(tmp_path / "out")
    before = (tmp_path / "out" / "ensemble.json").read_bytes()
    (tmp_path / "out" / "samples" / "sample_00001.npz").unlink()
    damaged = tmp_path / "out" / "samples" / "sample_00002.npz"
    damaged.write_bytes(damaged.read_bytes()[:500])
    undrawn.clear()
    assert ensemble(tmp_path / "out", resume=True).data == first.data
    assert sorted(task.number for task in undrawn) == [1, 2]
    assert (tmp_path / "out" / "ensemble.json").read_bytes() == before


def test_a_sobol_ensemble_can_be_enlarged(undrawn: list[Any], tmp_path: Path) -> None:
    ensemble(tmp_path / "out", samples=2)
    undrawn.clear()
    ensemble(tmp_path / "out", samples=5)
    assert sorted(task.number for task in undrawn) == [2, 3, 4]
    ensemble(tmp_path / "fresh", samples=5)
    assert table(tmp_path / "out") == table(tmp_path / "fresh")


def test_samples_of_another_ensemble_are_never_mixed_in(undrawn: list[Any], tmp_path: Path) -> None:
    ensemble(tmp_path / "out", samples=2)
    for change in ({"seed": 1}, {"method": "lhs"}):
        with pytest.raises(BadInput, match="another case, seed or method"):
            ensemble(tmp_path / "out", samples=2, **change)
    with pytest.raises(BadInput, match="another case"):
        ensemble(tmp_path / "out", "failure.onset=6 %", samples=2)
    undrawn.clear()
    ensemble(tmp_path / "out", samples=2, seed=1, force=True)
    assert len(undrawn) == 2


def test_going_on_with_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="no samples to go on from"):
        ensemble(tmp_path / "out", resume=True)
    assert not (tmp_path / "out").exists()


def test_runs_without_equilibrium_are_bounds_and_exit_code_3(undrawn: list[Any], tmp_path: Path) -> None:
    outcome = ensemble(tmp_path / "out", *NO_EQUILIBRIUM, samples=3)
    assert outcome.exit_code == 3
    assert outcome.data["failed_runs"] == 3
    assert all((wire["low"], wire["high"]) == (0.0, 1.0) for wire in outcome.data["wires"])
    assert all(row["status"] == "no equilibrium" and row["share_failed"] == "" for row in table(tmp_path / "out"))
    assert "3 runs broke off" in " ".join(ensemble_text(outcome.data).split())


def test_an_error_of_a_worker_is_a_failed_run_that_is_tried_again(
    undrawn: list[Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:

    usual = schedule.run_all

    def one_is_lost(*arguments: Any, **options: Any) -> Any:
        for outcome in usual(*arguments, **options):
            lost = outcome.task.number == 1
            yield TaskOutcome(outcome.task, None, MemoryError("too little")) if lost else outcome

    monkeypatch.setattr(schedule, "run_all", one_is_lost)
    monkeypatch.setattr("etextile.studies.ensemble.sample.write_sample", lambda *_: None)  # as on another machine
    outcome = ensemble(tmp_path / "out")
    assert outcome.data["failed"] == [{"sample": 1, "reason": "MemoryError: too little"}]
    assert not (tmp_path / "out" / "samples" / "sample_00001.npz").exists()
    monkeypatch.setattr(schedule, "run_all", usual)
    undrawn.clear()
    assert ensemble(tmp_path / "out").data["failed_runs"] == 0
    assert [task.number for task in undrawn] == [1]


@pytest.mark.slow
def test_a_run_the_sizing_of_loops_and_an_ensemble_say_the_same_number(undrawn: list[Any], tmp_path: Path) -> None:
    """Chances of loops, wires and the garment and strains of loops, where nothing scatters that a run does not know."""
    still = [
        f"scatter.{name}=0"
        for name in ("fabric", "strength", "loop_slack", "mounting", "wire_offset", "loop_offset", "punch_position")
    ]
    a, b = (f"{{name: {name}, wire: {wire}, from_loop: {wire}, to_loop: 2}}" for name, wire in (("a", 1), ("b", 0)))
    nets = f"wires.nets=[{a}, {b}]"
    case = small("failure.criterion=calibrated", "motion.total=20 mm", "outputs.maps=[]", nets, *still)
    run = et.run(case, tmp_path / "run").report
    data = run_ensemble(case, tmp_path / "many", samples=2).data
    sized = et.size_loops(case, tmp_path / "sized", per="garment").data
    assert 0.1 < run["wires"][1]["failure_probability"] < 0.9
    for one, other in zip(run["wires"], data["wires"], strict=True):
        for key in ("failure_probability", "open_probability"):
            assert other[key] == pytest.approx(one[key], rel=1e-6, abs=1e-9)
            assert [loop[key] for loop in other["loops"]] == pytest.approx(
                [loop[key] for loop in one["loops"]], rel=1e-6, abs=1e-9
            )
        strains = [loop["max_strain"] for loop in one["loops"]]
        assert [loop["max_strain_mean"] for loop in other["loops"]] == pytest.approx(strains, rel=1e-6, abs=1e-9)
    some, known = run["reliability"]["p_any_wire_broken"], run["reliability"]["intervals"]
    for name, key in (("any_failure", "p_any_wire_broken"), ("any_open", "p_any_wire_open")):
        found = data["specimen"][name]
        assert found["value"] == pytest.approx(run["reliability"][key], rel=1e-6, abs=1e-9)
        assert [found["calibration_low"], found["calibration_high"]] == pytest.approx(known[key], rel=1e-6, abs=1e-9)
    assert [net["name"] for net in data["nets"]] == ["a", "b"]
    for net, other in zip(run["nets"], data["nets"], strict=True):
        assert 1e-6 < net["loss_probability"] < 0.5
        ends = [other[key] for key in ("loss_probability", "calibration_low", "calibration_high")]
        assert ends == pytest.approx([net[key] for key in ("loss_probability", "low", "high")], rel=1e-6, abs=1e-12)
        assert other["low"] <= other["loss_probability"] <= other["high"]
    assert "Nets (2 of 2)" in ensemble_text(data)
    assert run["failure"]["strain_kind"] == data["failure"]["strain_kind"] == sized["strain_kind"] == "wire"
    assert sized["probability_now"] == pytest.approx(some, rel=1e-6, abs=1e-9)
    of_wires = et.size_loops(
        small("failure.criterion=calibrated", "motion.total=20 mm", *still), tmp_path / "wires", per="net"
    ).data
    worst = max(wire["failure_probability"] for wire in run["wires"])
    assert of_wires["probability_now"] == pytest.approx(worst, rel=1e-6)
    loops = [loop["failure_probability"] for wire in run["wires"] for loop in wire["loops"]]
    assert [row["probability_now"] for row in sized["loops"]] == pytest.approx(loops, rel=1e-6, abs=1e-9)


@pytest.mark.slow
def test_a_design_with_more_slack_is_better_and_the_pairs_show_it(here: list[Any], tmp_path: Path) -> None:
    """So it is on this lattice too, which is too coarse for a verdict: the numbers stand, the sentence does not."""
    strain = "failure.criterion=wire_strain"
    outcome = compare_designs(
        small(strain), small(strain, "wires.loops.slack=5 %"), tmp_path / "out", samples=6, method="lhs"
    )
    data = json.loads((tmp_path / "out" / "compare.json").read_text(encoding="utf-8"))
    assert data["better"] == "B"
    assert data["difference"]["share_failed"]["high"] < 0.0
    assert data["first_failure_mm"]["low"] > 0.0
    assert len(data["wires"]) == 9
    assert data["differs"] == [{"key": "wires.loops.slack", "A": 0.02, "B": 0.05}]
    assert data["verdict"]["withheld"]
    said = " ".join(compare_text(outcome.data).replace("│", " ").split())
    assert " ".join(data["verdict"]["sentence"].split()) in said
    assert "B is better" in sentence(data)
    assert [row["strength"] for row in table(tmp_path / "out" / "A")] == [
        row["strength"] for row in table(tmp_path / "out" / "B")
    ]
    assert (tmp_path / "out" / "difference.png").stat().st_size > 10_000
    shown = on_page(page_of(tmp_path / "out"))["designs"]
    for design, name in zip(shown, "AB", strict=True):
        own = json.loads((tmp_path / "out" / name / "ensemble.json").read_text(encoding="utf-8"))
        assert design["some"]["value"] == pytest.approx(own["fragility"]["any_failure"]["value"], abs=1e-6)


def test_a_difference_the_criterion_does_not_see_is_undecided(undrawn: list[Any], tmp_path: Path) -> None:
    # copper of another slack hardly changes the fabric, and span_strain looks at the fabric alone
    outcome = compare_designs(small(), small("outputs.maps=[failure]"), tmp_path / "out", samples=3)
    assert outcome.data["better"] == "undecided"
    assert any("does not count" in note for note in outcome.data["notes"])


def test_designs_that_cannot_be_compared_are_refused(undrawn: list[Any], tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="same case"):
        compare_designs(small(), small(), tmp_path / "out", samples=2)
    with pytest.raises(BadInput, match="move differently"):
        compare_designs(small(), small("motion.total=20 mm"), tmp_path / "out", samples=2)
    assert not list(tmp_path.rglob("*.npz"))


def test_a_scheduler_that_is_not_there_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(schedule, "CONNECT_S", 0.2)
    with pytest.raises(BadInput, match="no scheduler answers"):
        ensemble(tmp_path / "out", scheduler=f"tcp://127.0.0.1:{free_port()}")


def test_the_verb_reports_wrong_numbers_as_usage(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ensemble", "punch", "-n", "0", "-o", str(tmp_path / "out")]) == 2
    assert main(["ensemble", "punch", "-n", "2", "--set", "wires=null", "-o", str(tmp_path / "out")]) == 2
    assert "no wires" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


# Real worker processes


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return int(found.getsockname()[1])


def start(*arguments: str) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        [sys.executable, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
    )


def end(process: subprocess.Popen[bytes]) -> None:
    """End a process and all it started."""
    if process.poll() is None:
        os.killpg(process.pid, signal.SIGKILL)
    process.wait(timeout=30)


def command(folder: Path, *more: str, samples: int = 6) -> list[str]:
    settings = [part for item in SMALL for part in ("--set", item)]
    return ["-m", "etextile", "ensemble", "punch", "-n", str(samples), "-o", str(folder), *settings, *more]


def numbers(folder: Path) -> tuple[bytes, bytes]:
    return (folder / "ensemble.json").read_bytes(), (folder / "samples.csv").read_bytes()


@pytest.mark.slow
def test_200_samples_of_the_punch_take_less_than_three_minutes_on_two_cores(tmp_path: Path) -> None:
    """By processor time, which other load leaves alone: 0.3 s per sample when written, 6 s to start a worker."""
    from etextile.studies.ensemble.run import _tasks, prepare
    from etextile.studies.ensemble.sample import run_sample

    tasks = _tasks(prepare(load_case("punch"), tmp_path, samples=6, seed=0, method="sobol"), {})
    run_sample(tasks[0])
    begun = time.process_time()
    for task in tasks[1:]:
        run_sample(task)
    each = (time.process_time() - begun) / 5.0
    assert 200.0 / 2.0 * each + 6.0 < 150.0


@pytest.mark.slow
def test_numbers_do_not_depend_on_the_number_of_workers(tmp_path: Path) -> None:
    for jobs in (1, 2):
        ensemble(tmp_path / str(jobs), samples=6, seed=3, jobs=jobs)
    assert numbers(tmp_path / "1") == numbers(tmp_path / "2")


@pytest.mark.slow
def test_scheduler_and_workers_may_be_processes_of_their_own(tmp_path: Path, here: list[Any]) -> None:
    ensemble(tmp_path / "here", samples=6)
    address = f"tcp://127.0.0.1:{free_port()}"
    scheduler = start("-m", "distributed.cli.dask_scheduler", "--host", address, "--no-dashboard", "--no-show")
    workers = [
        start("-m", "distributed.cli.dask_worker", address, "--nthreads", "1", "--no-dashboard", "--no-nanny",
              "--local-directory", str(tmp_path / f"worker{k}"))
        for k in range(2)
    ]  # fmt: skip
    try:
        time.sleep(3.0)
        run = start(*command(tmp_path / "there", "--scheduler", address, "--quiet"))
        assert run.wait(timeout=240) == LIMIT_PASSED
    finally:
        for process in (*workers, scheduler):
            end(process)
    assert numbers(tmp_path / "here") == numbers(tmp_path / "there")


def workers_of(process: subprocess.Popen[bytes]) -> list[int]:
    """Return the worker processes of a run: forks of the server among its children."""
    parents, servers = {}, set()
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(status.read_text().rsplit(")", 1)[1].split()[1])
            words = (status.parent / "cmdline").read_bytes()
        except (OSError, IndexError):
            continue
        number = int(status.parent.name)
        parents[number] = parent
        if parent == process.pid and b"multiprocessing.forkserver" in words:
            servers.add(number)
    return [number for number, parent in parents.items() if parent in servers]


def wait_for_samples(folder: Path, count: int, run: subprocess.Popen[bytes]) -> None:
    for _ in range(1200):
        if len(list((folder / "samples").glob("sample_*.npz"))) >= count or run.poll() is not None:
            return
        time.sleep(0.1)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="finds the workers through /proc")
def test_a_worker_that_dies_loses_nothing(tmp_path: Path) -> None:
    run = start(*command(tmp_path / "killed", "--jobs", "2", "--quiet", samples=16))
    try:
        wait_for_samples(tmp_path / "killed", 2, run)
        victims = workers_of(run)
        assert victims
        os.kill(victims[0], signal.SIGKILL)
        assert run.wait(timeout=300) == LIMIT_PASSED
    finally:
        end(run)
    data = json.loads((tmp_path / "killed" / "ensemble.json").read_text(encoding="utf-8"))
    assert (data["samples"], data["failed_runs"]) == (16, 0)


@pytest.mark.slow
def test_ctrl_c_ends_in_two_lines_and_keeps_the_samples(tmp_path: Path) -> None:
    arguments = [sys.executable, *command(tmp_path / "out", "--jobs", "2", samples=60)]
    before = signal.signal(signal.SIGINT, signal.SIG_DFL)  # a shell lets what it runs in the background ignore Ctrl-C
    try:
        run = subprocess.Popen(arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True)
    finally:
        signal.signal(signal.SIGINT, before)
    try:
        wait_for_samples(tmp_path / "out", 3, run)
        os.killpg(run.pid, signal.SIGINT)
        _, errors = run.communicate(timeout=60)
    finally:
        end(run)
    assert run.returncode == 130
    assert errors.decode().splitlines()[-2:] == [
        "samples that ended are kept, the same command goes on with them", "interrupted"
    ]  # fmt: skip
    assert b"Traceback" not in errors


@pytest.mark.slow
def test_a_killed_ensemble_goes_on_where_it_was(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    run = start(*command(folder, "--jobs", "1", "--quiet", samples=12))
    try:
        wait_for_samples(folder, 3, run)
    finally:
        end(run)
    kept = {path.name: path.stat().st_mtime_ns for path in (folder / "samples").glob("sample_*.npz")}
    assert 3 <= len(kept) < 12
    assert not (folder / "ensemble.json").exists()
    outcome = ensemble(folder, samples=12, jobs=2, resume=True)
    assert outcome.data["samples"] == 12
    after = {path.name: path.stat().st_mtime_ns for path in (folder / "samples").glob("sample_*.npz")}
    assert len(after) == 12
    assert {name: after[name] for name in kept} == kept
