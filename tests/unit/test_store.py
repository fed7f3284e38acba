"""The result file as a store: what is appended comes back, and bad files are told apart."""

from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from etextile.errors import BadInput, EtextileError
from etextile.results.layout import BodySurface, CaseRecord, UndeformedGrid
from etextile.results.reader import open_results
from etextile.results.store import ResultWriter
from etextile.results.vtkhdf import header_blocks


N_POINTS, N_CELLS, N_LOOPS, N_ELEMENTS = 6, 7, 2, 3
RESTART = {"plastic": np.zeros(N_CELLS), "slip": np.zeros((2, 2)), "leg": np.int64(0)}
WIRES = {
    "weft_mm": [0.0, 5.91],
    "start_mm": [0.0, 0.0],
    "end_mm": [50.0, 50.0],
    "share": [0.5, 1.0],
    "loop_wire": [0, 1],
    "loop_index": [0, 0],
    "loop_warp_mm": [0.0, 0.0],
    "loop_exit_mm": [-2.0, -2.0],
    "loop_entry_mm": [2.0, 2.0],
    "loop_slack": [0.02, 0.02],
    "loop_halved": [True, True],
    "loop_copies": [1, 1],
    "wire_copies": [1, 2],
    "symmetric": True,
    "element_wire": [0, 0, 1],
    "element_warp_mm": [-3.0, 3.0, 0.0],
}
CASE = CaseRecord(
    text="title: ünnötig\n",
    source="punch.yaml",
    overrides=("contact.friction=0", "wires=null"),
    versions={"numpy": "2.4"},
    seed=7,
    created="2025-01-01T00:00:00Z",
)


def grid() -> UndeformedGrid:
    reference = np.arange(3 * N_POINTS, dtype=float).reshape(-1, 3)
    cells = np.stack([np.arange(N_CELLS) % N_POINTS, (np.arange(N_CELLS) + 1) % N_POINTS], axis=1)
    family = np.array([0, 0, 1, 1, 2, 2, 3], dtype=np.int8)
    wire = np.where(family == 3, 0, -1).astype(np.int32)
    quads = np.array([[0, 1, 2, 3]])
    return UndeformedGrid(reference, cells, family, wire, quads, np.arange(N_POINTS) < 2, (True, False), 45.0)


def increment(number: int, *, displacement: float | None = None, output: bool = True) -> SimpleNamespace:
    travel = 2.5 * number if displacement is None else displacement
    energy = SimpleNamespace(
        external=travel, stored=travel / 2, plastic=travel / 4, friction=0.0, contact=0.0, work_doubt=0.0
    )
    verdict = SimpleNamespace(
        converged=True,
        reason="converged",
        iterations=4,
        linear_solves=5,
        cut_backs=1,
        residual_N=1e-7,
        tolerance_N=1e-6,
        sentence=f"converged at {travel} mm: fabric läuft",
        worst_node=3,
    )
    return SimpleNamespace(
        displacement_mm=travel,
        positions=grid().reference + number,
        truss_strain=np.full(N_CELLS, number / 8),
        truss_stress=np.full(N_CELLS, number * 2.0),
        truss_plastic_strain=np.full(N_CELLS, number / 16),
        truss_force=np.arange(N_CELLS) + number,
        contact_force=np.full((N_POINTS, 3), number / 2),
        punch_force_N=10.0 * number,
        clamp_force_N=10.0 * number,
        max_penetration_mm=0.01,
        energy=energy,
        verdict=verdict,
        softening=0,
        state=restart(number),
        output=output,
    )


def histories(number: int) -> dict[str, np.ndarray]:
    return {
        "span_strain": np.full(N_LOOPS, number / 100),
        "wire_strain": np.full(N_LOOPS, number / 200),
        "element_strain": np.arange(N_ELEMENTS) + number / 4,
    }


def restart(number: int) -> dict[str, np.ndarray]:
    return {"plastic": np.full(N_CELLS, float(number)), "slip": np.full((2, 2), number / 2), "leg": np.int64(number)}


def written(path: Path, count: int, *, steps: int = 4) -> Path:
    with ResultWriter.create(path, grid(), case=CASE, steps=steps, wires=WIRES, restart=RESTART) as writer:
        for number in range(1, count + 1):
            writer.append(increment(number), wall_s=0.5, histories=histories(number))
    return path


def test_fields_come_back_per_step(tmp_path: Path) -> None:
    results = open_results(written(tmp_path / "results.vtkhdf", 3))
    assert results.steps == 3
    np.testing.assert_array_equal(results.displacement_mm, [2.5, 5.0, 7.5])
    np.testing.assert_array_equal(results.points(1), grid().reference + 2)
    np.testing.assert_array_equal(results.array("strain", -1), np.full(N_CELLS, 3 / 8, dtype=np.float32))
    np.testing.assert_array_equal(results.array("force", 0), np.arange(N_CELLS) + 1)
    np.testing.assert_array_equal(results.array("contact_force", 2), np.full((N_POINTS, 3), 1.5))
    assert results.unit("stress") == "MPa"


def test_the_piece_and_its_origin_come_back(tmp_path: Path) -> None:
    body = BodySurface(np.eye(3), np.array([[0, 1, 2]]), np.array([0.0, 0.0, 1.0]))
    path = tmp_path / "results.vtkhdf"
    ResultWriter.create(path, grid(), case=CASE, steps=1, body=body).close()
    results = open_results(tmp_path)
    assert results.case == CASE
    assert results.case_text == CASE.text
    assert results.grid.symmetry == (True, False)
    assert results.grid.warp_angle_deg == 45.0
    np.testing.assert_array_equal(results.grid.clamped, np.arange(N_POINTS) < 2)
    np.testing.assert_array_equal(results.grid.quads, [[0, 1, 2, 3]])
    np.testing.assert_array_equal(results.family, grid().family)
    np.testing.assert_array_equal(results.body.vertices, body.vertices)
    assert (results.steps, results.completed, results.wires, results.restart()) == (0, False, None, None)


def test_increments_between_output_steps_keep_their_row_and_their_restart_state(tmp_path: Path) -> None:
    path = tmp_path / "results.vtkhdf"
    with ResultWriter.create(path, grid(), case=CASE, steps=2, restart=RESTART) as writer:
        writer.append(increment(1, output=False))
        writer.append(increment(2))
        writer.append(increment(3, output=False))
    results = open_results(path)
    np.testing.assert_array_equal(results.increments.displacement_mm, [2.5, 5.0, 7.5])
    np.testing.assert_array_equal(results.increments.step, [-1, 0, -1])
    np.testing.assert_array_equal(results.displacement_mm, [5.0])
    np.testing.assert_array_equal(results.points(0), grid().reference + 2)
    state = results.restart()
    assert state is not None
    for name, values in restart(3).items():
        np.testing.assert_array_equal(state[name], values)


def test_curves_hold_forces_energies_and_the_verdict_in_words(tmp_path: Path) -> None:
    curves = open_results(written(tmp_path / "results.vtkhdf", 2)).curves
    np.testing.assert_array_equal(curves.punch_force_N, [10.0, 20.0])
    np.testing.assert_array_equal(curves.external_work, [2.5, 5.0])
    np.testing.assert_array_equal(curves.converged, [True, True])
    np.testing.assert_array_equal(curves.linear_solves, [5, 5])
    assert curves.reason == ("converged", "converged")
    assert curves.sentence[1] == "converged at 5.0 mm: fabric läuft"


def test_time_never_goes_back_when_the_punch_does(tmp_path: Path) -> None:
    path = tmp_path / "results.vtkhdf"
    with ResultWriter.create(path, grid(), case=CASE, steps=3) as writer:
        for displacement in (10.0, 4.0, 12.0):
            writer.append(increment(1, displacement=displacement))
    results = open_results(path)
    np.testing.assert_array_equal(results.displacement_mm, [10.0, 4.0, 12.0])
    np.testing.assert_array_equal(results.curves.travel_mm, [10.0, 16.0, 24.0])
    with h5py.File(path) as file:
        np.testing.assert_array_equal(file["VTKHDF/Steps/Values"], [10.0, 16.0, 24.0])


def test_wire_histories_come_back_with_their_layout(tmp_path: Path) -> None:
    wires = open_results(written(tmp_path / "results.vtkhdf", 3)).wires
    assert wires is not None
    np.testing.assert_allclose(wires.span_strain, np.outer([0.0, 0.01, 0.02, 0.03], [1, 1]))
    np.testing.assert_allclose(wires.element_strain[:, 2], [0.0, 2.25, 2.5, 2.75])
    np.testing.assert_array_equal(wires.layout.loop_wire, [0, 1])
    np.testing.assert_array_equal(wires.layout.loop_halved, [True, True])
    assert wires.layout.symmetric is True
    np.testing.assert_array_equal(wires.displacement_mm, [0.0, 2.5, 5.0, 7.5])


def test_a_reopened_file_goes_on_after_the_last_step(tmp_path: Path) -> None:
    once, twice = written(tmp_path / "once.vtkhdf", 4), written(tmp_path / "twice.vtkhdf", 2)
    with ResultWriter.reopen(twice) as writer:
        assert (writer.increments, writer.steps) == (2, 2)
        for number in (3, 4):
            writer.append(increment(number), wall_s=0.5, histories=histories(number))
        writer.finish()
    one, two = open_results(once), open_results(twice)
    assert (one.completed, two.completed) == (False, True)
    for step in range(4):
        np.testing.assert_array_equal(one.array("displacement", step), two.array("displacement", step))
    np.testing.assert_array_equal(one.curves.travel_mm, two.curves.travel_mm)
    np.testing.assert_array_equal(one.wires.span_strain, two.wires.span_strain)
    np.testing.assert_array_equal(one.restart()["plastic"], two.restart()["plastic"])


def test_more_steps_than_expected_enlarge_the_file_without_loss(tmp_path: Path) -> None:
    results = open_results(written(tmp_path / "results.vtkhdf", 9, steps=1))
    assert results.steps == 9
    for step in range(9):
        np.testing.assert_array_equal(results.points(step), grid().reference + step + 1)
    np.testing.assert_allclose(results.wires.span_strain[1:, 0], np.arange(1, 10) / 100)
    assert not list(tmp_path.glob("**/.*.part*"))
    with h5py.File(results.path) as file:
        assert file["VTKHDF/Steps"].attrs["NSteps"] == 9
        np.testing.assert_array_equal(file["VTKHDF/Steps/Values"], results.displacement_mm)


def test_many_small_increments_enlarge_the_table_of_curves(tmp_path: Path) -> None:
    path = tmp_path / "results.vtkhdf"
    with ResultWriter.create(path, grid(), case=CASE, steps=1) as writer:
        for number in range(300):
            writer.append(increment(number, output=False))
        writer.append(increment(300))
    results = open_results(path)
    np.testing.assert_array_equal(results.increments.displacement_mm, 2.5 * np.arange(301))
    assert results.steps == 1


@pytest.mark.parametrize("arrays", range(0, 40, 4))
def test_the_header_that_commits_a_step_is_one_block_wherever_it_lands(tmp_path: Path, arrays: int) -> None:
    path = tmp_path / "results.vtkhdf"
    state = {str(number): np.zeros(number) for number in range(arrays)}
    with ResultWriter.create(path, grid(), case=CASE, steps=2, restart=state) as writer:
        for number in range(1, 6):
            late = increment(number)
            late.state = state
            writer.append(late)
    with h5py.File(path) as file:
        assert header_blocks(file["VTKHDF/Steps"]) == 1


def test_the_end_is_recorded_in_words(tmp_path: Path) -> None:
    path = written(tmp_path / "results.vtkhdf", 1)
    with ResultWriter.reopen(path) as writer:
        writer.finish("no equilibrium at 5 mm: try smaller steps", completed=False)
    results = open_results(path)
    assert not results.completed
    assert results.ending == "no equilibrium at 5 mm: try smaller steps"


def test_a_restart_state_of_another_shape_or_name_is_refused(tmp_path: Path) -> None:
    other_shape, other_name = increment(1), increment(1)
    other_shape.state = restart(1) | {"slip": np.zeros(3)}
    other_name.state = {"plastic": np.zeros(N_CELLS)}
    with ResultWriter.create(tmp_path / "results.vtkhdf", grid(), case=CASE, steps=1, restart=RESTART) as writer:
        with pytest.raises(EtextileError, match=r"'slip' has shape \(3,\), expected \(2, 2\)"):
            writer.append(other_shape)
        with pytest.raises(EtextileError, match="created for"):
            writer.append(other_name)
        assert writer.increments == 0


def test_a_refused_increment_leaves_the_earlier_ones(tmp_path: Path) -> None:
    path = written(tmp_path / "results.vtkhdf", 2)
    with ResultWriter.reopen(path) as writer, pytest.raises(EtextileError, match="unknown histories array"):
        writer.append(increment(3), histories={"spam_strain": np.zeros(N_LOOPS)})
    assert open_results(path).steps == 2


def test_incomplete_wires_are_refused_and_leave_no_file(tmp_path: Path) -> None:
    wires = {name: values for name, values in WIRES.items() if name != "loop_slack"}
    with pytest.raises(EtextileError, match="loop_slack"):
        ResultWriter.create(tmp_path / "results.vtkhdf", grid(), case=CASE, steps=1, wires=wires)
    assert not list(tmp_path.iterdir())


def test_files_that_are_not_results_are_told_apart(tmp_path: Path) -> None:
    text, foreign, cut = tmp_path / "a.vtkhdf", tmp_path / "b.vtkhdf", tmp_path / "c.vtkhdf"
    text.write_text("displacement,force\n")
    with h5py.File(foreign, "w") as file:
        file["x"] = 1
    cut.write_bytes(written(tmp_path / "whole.vtkhdf", 3).read_bytes()[:9000])
    for path, message in (
        (tmp_path / "none.vtkhdf", "no result file"),
        (text, "not HDF5"),
        (foreign, "not a result file of etextile"),
        (cut, "truncated"),
    ):
        with pytest.raises(BadInput, match=message) as caught:
            open_results(path)
        assert caught.value.problems[0].file == str(path)


def test_a_file_of_another_version_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path / "results.vtkhdf", 1)
    with h5py.File(path, "r+") as file:
        file["etextile"].attrs["version"] = [99, 0]
    with pytest.raises(BadInput, match=r"format version 99\.0"):
        open_results(path)


@pytest.mark.parametrize("part", ["etextile/increments/punch_force_N", "etextile/lattice", "VTKHDF/CellData/family"])
def test_a_file_with_a_hole_is_refused_with_the_name_of_what_is_missing(tmp_path: Path, part: str) -> None:
    path = written(tmp_path / "results.vtkhdf", 1)
    with h5py.File(path, "r+") as file:
        del file[part]
    with pytest.raises(BadInput, match=rf"incomplete result file.*{part.rsplit('/', 1)[1]}"):
        open_results(path)


def test_asking_for_what_is_not_there_names_what_is(tmp_path: Path) -> None:
    results = open_results(written(tmp_path / "results.vtkhdf", 2))
    with pytest.raises(BadInput, match="did you mean 'strain'"):
        results.array("strian", 0)
    with pytest.raises(BadInput, match="steps 0 to 1"):
        results.array("strain", 2)
