"""A case from its file to the verdict: every shipped case runs, leaves what it promises and goes on after a break."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from etextile.app.cli import main
from etextile.results.reader import open_results
from etextile.studies.run.run import run
from etextile.text.run import report_text
from loadcases import catalogue
from loadcases.build import build, plan
from loadcases.reader import load_case


REPORT_KEYS = {
    "case": {"title", "sha256"},
    "punch": {"displacement_mm", "force_N"},
    "strain": {"warp_max", "weft_max", "diagonal_max"},
    "edge": {"displacement_mm", "draw_in_mm"},
    "solver": {
        "nodes", "trusses", "steps", "linear_solves", "cut_backs", "all_converged", "wall_s", "solve_s",
        "max_penetration_mm", "energy_error",
    },
    "trust": {"ok", "limits"},
}  # fmt: skip
WIRE_KEYS = {"wire", "weft_mm", "state", "first_failure_mm", "max_strain", "failure_probability", "loops"}
LOOP_KEYS = {"loop", "warp_mm", "state", "first_failure_mm", "max_strain", "filaments_broken"}
LONG = (
    "elbow",
    "knee",
    "nylon_30",
    "elbow_sleeve",
    "elbow_sleeve_loose",
    "elbow_sleeve_mesh",
    "knee_sleeve",
    "elbow_pad",
    "knee_pad",
    "nylon_offaxis",
)
CASES = [pytest.param(name, marks=[pytest.mark.slow] * (name in LONG)) for name in catalogue.names("case")]
QUICK = ("fabric.coarsening=40", "outputs.maps=[]")


@pytest.fixture(autouse=True)
def _caches_stay_in_the_test(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ETEXTILE_CACHE_DIR", str(tmp_path_factory.getbasetemp() / "cache"))


@pytest.mark.parametrize("name", CASES)
def test_every_shipped_case_runs_coarse_and_keeps_its_promises(name: str, tmp_path: Path) -> None:
    loaded = load_case(name, overrides=["outputs.maps=[]"])
    motion = loaded.case.motion
    overrides = [f"fabric.coarsening={max(30.0, loaded.case.fabric.coarsening)}", "outputs.maps=[]"]
    if motion.target != "body":
        overrides = ["outputs.maps=[]"]
    worn = loaded.case.worn
    overrides += [f"motion.{'flexion' if worn else 'total'}={0.5 * motion.reach}", "motion.steps=6", "motion.path=null"]
    outcome = run(load_case(name, overrides=overrides), tmp_path / "out")
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert outcome.exit_code == 0, report_text(outcome.report)
    for key, inner in REPORT_KEYS.items():
        assert inner <= report[key].keys()
    assert all(
        wire.keys() >= WIRE_KEYS and all(loop.keys() >= LOOP_KEYS for loop in wire["loops"]) for wire in report["wires"]
    )
    force = report["joint"]["moment_Nmm"] if worn else report["punch"]["force_N"]
    results = open_results(tmp_path / "out")
    assert results.completed
    assert len(force) == 6
    assert np.all(np.diff(force) > 0.0)
    assert results.steps == report["solver"]["steps"] == 6 + int(np.count_nonzero(results.displacement_mm <= 0.0))
    assert (tmp_path / "out" / "wires.csv").read_text().startswith("wire,")
    assert (tmp_path / "out" / "report.html").stat().st_size > 10_000


def test_body_cases_have_wires_and_loops_enough() -> None:
    for name in ("elbow", "knee"):
        counts = plan(load_case(name).case)
        assert counts["wires"] >= 15
        assert counts["loops"] >= 30


def test_plan_counts_what_build_builds() -> None:
    case = load_case("punch").case
    counts, built = plan(case), build(case)
    assert counts["cells"] == (9, 16)
    assert counts["nodes"] == len(built.model.lattice.points) == 170
    assert counts["trusses"] == len(built.model.lattice.trusses) == 601


@pytest.mark.slow
def test_interrupted_run_resumes_to_the_same_numbers(tmp_path: Path) -> None:
    loaded = load_case("punch", overrides=["outputs.maps=[]", "contact.friction=0.3", "motion.steps=14"])
    whole = run(loaded, tmp_path / "whole")

    def stop_half_way(increment: object) -> None:
        if getattr(increment, "index", 0) == 7:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(loaded, tmp_path / "broken", watch=stop_half_way)
    halfway = open_results(tmp_path / "broken")
    assert not halfway.completed
    assert halfway.steps == 8
    resumed = run(loaded, tmp_path / "broken", resume=True)
    force, again = (np.array(outcome.report["punch"]["force_N"]) for outcome in (whole, resumed))
    assert again.shape == force.shape
    assert np.abs(again - force).max() <= 1e-6 * force.max()
    assert resumed.report["wires"] == whole.report["wires"]


def test_resume_of_a_changed_case_lists_what_changed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "out"
    quick = [part for item in (*QUICK, "motion.total=5", "motion.steps=4") for part in ("--set", item)]
    assert main(["run", "punch", "--quiet", "-o", str(folder), *quick]) == 0
    before = (folder / "results.vtkhdf").read_bytes()
    code = main(["run", "punch", "--quiet", "--resume", "-o", str(folder), *quick, "--set", "contact.friction=0.2"])
    message = capsys.readouterr().err
    assert code == 2
    assert "friction" in message
    assert "0.2" in message
    assert (folder / "results.vtkhdf").read_bytes() == before


def test_folder_of_another_case_is_not_overwritten_without_force(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = str(tmp_path / "out")
    quick = [part for item in (*QUICK, "motion.total=4", "motion.steps=4") for part in ("--set", item)]
    assert main(["run", "punch", "--quiet", "-o", folder, *quick]) == 0
    kept = (tmp_path / "out" / "report.json").read_bytes()
    other = [*quick, "--set", "body.radius=12"]
    assert main(["run", "punch", "--quiet", "-o", folder, *other]) == 2
    assert "another case (radius: 15.0 there, radius: 12.0 here), choose" in capsys.readouterr().err
    assert (tmp_path / "out" / "report.json").read_bytes() == kept
    assert main(["run", "punch", "--quiet", "-o", folder, *other, "--force"]) == 0
    assert (tmp_path / "out" / "report.json").read_bytes() != kept


def test_bad_input_is_refused_before_anything_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    case = tmp_path / "case.yaml"
    case.write_text(
        "schema_version: 1\ntitle: t\nextends: punch\nmotion: {total: 20 mm, steps: 2}\nwires: {filaments: 900}\n"
    )
    code = main(["run", str(case), "-o", str(tmp_path / "out")])
    message = capsys.readouterr().err
    assert code == 2
    assert "wires.filaments" in message
    assert "case.yaml:5" in message
    assert not (tmp_path / "out").exists()


def test_a_path_without_equilibrium_keeps_what_converged(tmp_path: Path) -> None:
    overrides = ["outputs.maps=[]", "solver.max_iterations=3", "solver.max_cut_backs=0"]
    outcome = run(load_case("punch", overrides=overrides), tmp_path / "out")
    assert outcome.exit_code == 3
    assert not outcome.report["solver"]["all_converged"]
    assert not outcome.report["trust"]["ok"]
    assert "no equilibrium" in report_text(outcome.report)
    assert [reason[:14] for reason in outcome.reasons] == ["no equilibrium"]
    assert not open_results(tmp_path / "out").completed


def test_passed_trust_limit_withholds_the_verdict(tmp_path: Path) -> None:
    """Beyond 65 mm more than 2 % of the trusses are past their force peak: the model may localise."""
    overrides = [*QUICK, "motion.total=75", "motion.steps=15"]
    outcome = run(load_case("punch", overrides=overrides), tmp_path / "out")
    assert outcome.exit_code == 4
    assert outcome.report["solver"]["all_converged"]
    assert outcome.report["verdict"]["withheld"]
    assert "softening share" in report_text(outcome.report)


def test_coupon_with_wires_returns_the_measured_warp_curve() -> None:
    """The coupons behind the fabric sets contained the wires: their stiffness is not counted twice."""
    case = load_case("punch").case
    built = build(case)
    assert built.share is not None
    assert 0.0 < built.share.at_end < built.share.largest < 0.06
    assert built.share.misfit < 0.01
    without = build(load_case("punch", overrides=["wires=null"]).case)
    assert without.model.lattice_block.laws[0].H == 9960.0
    assert built.model.lattice_block.laws[0].H != 9960.0


def test_wire_elements_cover_each_wire_once_and_loops_are_free() -> None:
    built = build(load_case("punch").case)
    assert built.wires is not None
    layout = built.wires.layout
    woven, loops = built.model.truss_blocks[1:]
    for wire in range(layout.n_wires):
        own = built.wires.element_wire == wire
        free = loops.span[layout.loop_wire == wire]
        assert woven.span[own].sum() + free.sum() == pytest.approx(layout.end_mm[wire] - layout.start_mm[wire])
    assert loops.rest_length == pytest.approx(loops.span * (1.0 + layout.loop_slack))
    for block in (woven, loops):
        assert np.abs(block.weights.sum(axis=1)).max() < 1e-12


def test_lattice_error_is_estimated_on_two_other_lattices(tmp_path: Path) -> None:
    overrides = ["outputs.maps=[]", "motion.total=25", "motion.steps=10"]
    outcome = run(load_case("punch", overrides=overrides), tmp_path / "out", estimate_error=True)
    found = outcome.report["lattice_error"]
    assert found["cells"] == [[9, 16], [6, 11], [14, 24]]
    assert 0.005 < found["force_change"] < 0.03
    assert len(found["wire_strain_change"]) == len(outcome.report["wires"])
    assert "lattice error" in report_text(outcome.report)


@pytest.mark.slow
def test_the_limit_of_ever_finer_lattices_holds_on_a_finer_one(tmp_path: Path) -> None:
    """Of three lattices from 9 x 16 to 36 x 64 cells; 1 N and 0.2 % strain are far below what these differ by."""
    overrides = ["outputs.maps=[]", "motion.total=30", "motion.steps=6"]
    found = run(load_case("punch", overrides=overrides), tmp_path / "limit", extrapolate=True)
    limit = found.report["limit"]
    assert limit["reached"]
    assert limit["cells"] == [[9, 16], [18, 32], [36, 64]]
    assert limit["punch_force_N"][-1] == pytest.approx((4 * limit["force_N"][2] - limit["force_N"][1]) / 3, rel=1e-9)
    assert 1.5 < limit["order_force"] < 2.5
    finer = run(load_case("punch", overrides=[*overrides, "fabric.coarsening=3.25"]), tmp_path / "finer")
    force = finer.report["punch"]["force_N"][-1]
    assert abs(found.report["punch"]["force_N"][-1] - force) > 8.0
    assert abs(limit["punch_force_N"][-1] - force) < max(limit["punch_force_doubt_N"][-1], 1.0)
    assert finer.results.wires is not None
    for loop, there in zip(limit["loops"], finer.results.wires.span_strain.max(axis=0), strict=True):
        assert loop["max_span_strain"] == pytest.approx(there, abs=max(loop["span_strain_doubt"], 2e-3))
    assert "Limit of ever finer lattices" in report_text(found.report)


def test_no_limit_is_given_with_the_reason_where_lattices_are_too_coarse(tmp_path: Path) -> None:
    overrides = ["outputs.maps=[]", "motion.total=20", "motion.steps=4", "fabric.coarsening=80"]
    found = run(load_case("punch", overrides=overrides), tmp_path / "coarse", extrapolate=True)
    assert not found.report["limit"]["reached"]
    assert "punch_force_N" not in found.report["limit"]
    assert "none is given" in report_text(found.report)


def test_one_large_step_does_not_jump_through_the_fabric(tmp_path: Path) -> None:
    overrides = ["outputs.maps=[]", "motion.steps=1"]
    outcome = run(load_case("punch", overrides=overrides), tmp_path / "out")
    assert outcome.report["punch"]["force_N"] == pytest.approx([3256.0], rel=0.005)
    assert open_results(tmp_path / "out").steps == 1


def test_body_that_reaches_a_clamp_or_slips_between_nodes_is_not_trusted(tmp_path: Path) -> None:
    quick = ["outputs.maps=[]", "wires=null", "fabric.portion=whole", "motion.steps=2"]
    close = run(load_case("punch", overrides=[*quick, "body.position=[45,0]", "motion.total=6"]), tmp_path / "close")
    assert close.exit_code == 4
    assert "body in the clamp" in report_text(close.report)
    small = ["body.radius=1", "body.position=[2.7,1.5]", "motion.total=4"]
    lost = run(load_case("punch", overrides=[*quick, *small]), tmp_path / "lost")
    assert lost.exit_code == 4
    assert "without force" in report_text(lost.report)


def test_unloading_and_reloading_comes_back_to_the_same_force(tmp_path: Path) -> None:
    """The laws unload elastically, so the punch meets the fabric where it left it."""
    overrides = ["outputs.maps=[]", "wires=null", "motion.total=20", "motion.steps=8", "motion.path=[20,0,20]"]
    report = run(load_case("punch", overrides=overrides), tmp_path / "out").report
    force = np.array(report["punch"]["force_N"])
    assert force[7] == pytest.approx(171.1, rel=0.005)
    assert force[15] == 0.0
    assert force[23] == pytest.approx(force[7], rel=1e-5)
