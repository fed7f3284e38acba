"""What others rely on in a result file: VTK reads every step, units everywhere, and a kill costs nothing."""

import random
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.results.guard import GuardedHDF5
from etextile.results.layout import CaseRecord, UndeformedGrid
from etextile.results.reader import open_results
from etextile.results.store import ResultWriter


SIDE = 12


def piece() -> UndeformedGrid:
    """Return a square sheet of warp and weft lines with one wire along the middle."""
    x, y = np.meshgrid(np.arange(SIDE, dtype=float), np.arange(SIDE, dtype=float), indexing="ij")
    reference = np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)
    index = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    warp = np.stack([index[:-1].ravel(), index[1:].ravel()], axis=1)
    weft = np.stack([index[:, :-1].ravel(), index[:, 1:].ravel()], axis=1)
    middle = np.stack([index[:-1, SIDE // 2], index[1:, SIDE // 2]], axis=1)
    family = np.repeat(np.array([0, 1, 3], dtype=np.int8), [len(warp), len(weft), len(middle)])
    wire = np.where(family == 3, 0, -1).astype(np.int32)
    return UndeformedGrid(reference, np.concatenate([warp, weft, middle]), family, wire)


def increment(number: int, *, output: bool = True) -> SimpleNamespace:
    """Return an increment in which every number stored tells the increment it belongs to."""
    grid = piece()
    trusses = len(grid.cells)
    lift = np.zeros_like(grid.reference)
    lift[:, 2] = number
    return SimpleNamespace(
        displacement_mm=float(number),
        positions=grid.reference + lift,
        truss_strain=np.full(trusses, number),
        truss_stress=np.full(trusses, 10 * number),
        truss_plastic_strain=np.full(trusses, number / 2),
        truss_force=np.full(trusses, 3 * number),
        contact_force=np.full_like(lift, number),
        punch_force_N=float(number),
        clamp_force_N=float(number),
        max_penetration_mm=0.0,
        energy=SimpleNamespace(external=1.0, stored=1.0, plastic=0.0, friction=0.0, contact=0.0, work_doubt=0.0),
        verdict=SimpleNamespace(
            converged=True,
            reason="converged",
            iterations=1,
            linear_solves=1,
            cut_backs=0,
            residual_N=0.0,
            tolerance_N=1e-6,
            sentence=f"increment {number}",
            worst_node=0,
        ),
        softening=0,
        state={"number": np.full(5000, float(number))},
        output=output,
    )


def create(path: Path, *, steps: int) -> ResultWriter:
    return ResultWriter.create(
        path, piece(), case=CaseRecord("title: test\n"), steps=steps, restart={"number": np.zeros(5000)}
    )


def append(writer: ResultWriter, number: int) -> None:
    writer.append(increment(number))


def assert_consistent(path: Path) -> int:
    """Check that each step holds exactly its own numbers and return how many there are."""
    results = open_results(path)
    for step in range(results.steps):
        assert set(results.array("strain", step)) == {step + 1}
        assert set(results.array("displacement", step)[:, 2]) == {step + 1}
        assert results.curves.sentence[step] == f"increment {step + 1}"
    state = results.restart()
    if results.steps:
        assert set(state["number"]) == {results.steps}
    return results.steps


def vtk_steps(path: Path) -> list[tuple[float, np.ndarray, dict[str, np.ndarray]]]:
    """Read all steps the way ParaView does: time, points and arrays.

    VTK names times only where there are two or more; a file of one step is shown without one, given as NaN here.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS()) or (np.nan,)
    assert reader.GetNumberOfSteps() == len(times)
    found = []
    for time_value in times:
        reader.Update() if np.isnan(time_value) else reader.UpdateTimeStep(time_value)
        grid = reader.GetOutput()
        arrays = {}
        for data in (grid.GetPointData(), grid.GetCellData()):
            for number in range(data.GetNumberOfArrays()):
                arrays[data.GetArrayName(number)] = vtk_to_numpy(data.GetArray(number)).copy()
        arrays["cells"] = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).copy()
        found.append((time_value, vtk_to_numpy(grid.GetPoints().GetData()).copy(), arrays))
    return found


def assert_vtk_shows(path: Path, steps: int) -> None:
    """Check that VTK shows exactly these steps, each with its own time and numbers."""
    seen = vtk_steps(path)
    assert len(seen) == steps
    for number, (time_value, points, arrays) in enumerate(seen, start=1):
        assert time_value == number or (steps == 1 and np.isnan(time_value))
        assert set(points[:, 2]) == set(arrays["strain"]) == {number}


def test_an_array_of_another_shape_is_damage_though_its_bytes_are_right(tmp_path: Path) -> None:
    path = tmp_path / "results.vtkhdf"
    with create(path, steps=2) as writer:
        append(writer, 1)
    with h5py.File(path, "r+") as file:
        lattice = file["etextile/lattice"]
        values, notes = lattice["cells"][()], dict(lattice["cells"].attrs)
        del lattice["cells"]
        lattice.create_dataset("cells", data=values[..., None]).attrs.update(notes)
    with pytest.raises(BadInput, match="another shape"):
        open_results(path)


def test_vtk_shows_the_numbers_of_a_file_with_a_single_step(tmp_path: Path) -> None:
    path = tmp_path / "results.vtkhdf"
    with create(path, steps=8) as writer:
        append(writer, 1)
        assert_vtk_shows(path, 1)
        append(writer, 2)
        assert_vtk_shows(path, 2)


def test_vtk_sees_every_step_with_its_own_points_and_arrays(tmp_path: Path) -> None:
    path = tmp_path / "results.vtkhdf"
    with create(path, steps=8) as writer:
        for number in (1, 2, 3):
            append(writer, number)
    steps = vtk_steps(path)
    assert [time_value for time_value, _, _ in steps] == [1.0, 2.0, 3.0]
    for number, (_, points, arrays) in enumerate(steps, start=1):
        np.testing.assert_allclose(points[:, 2], number)
        np.testing.assert_allclose(points[:, :2], piece().reference[:, :2])
        np.testing.assert_allclose(arrays["displacement"][:, 2], number)
        np.testing.assert_allclose(arrays["strain"], number)
        np.testing.assert_allclose(arrays["stress"], 10 * number)
        np.testing.assert_allclose(arrays["plastic_strain"], number / 2)
        np.testing.assert_allclose(arrays["force"], 3 * number)
        np.testing.assert_allclose(arrays["contact_force"], number)
        np.testing.assert_array_equal(arrays["family"], piece().family)
        np.testing.assert_array_equal(arrays["wire"], piece().wire)
        np.testing.assert_array_equal(arrays["cells"], piece().cells.ravel())


def test_pyvista_opens_the_file(tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    path = tmp_path / "results.vtkhdf"
    with create(path, steps=2) as writer:
        append(writer, 1)
    grid = pyvista.read(path)
    assert (grid.n_points, grid.n_cells) == (SIDE * SIDE, len(piece().cells))


def test_a_file_without_steps_yet_shows_the_flat_piece(tmp_path: Path) -> None:
    pyvista = pytest.importorskip("pyvista")
    path = tmp_path / "results.vtkhdf"
    create(path, steps=8).close()
    assert open_results(path).steps == 0
    np.testing.assert_allclose(pyvista.read(path).points, piece().reference)


def test_every_array_carries_unit_and_description(tmp_path: Path) -> None:
    path = tmp_path / "results.vtkhdf"
    with create(path, steps=2) as writer:
        append(writer, 1)
    bare = []

    def visit(name: str, item: h5py.HLObject) -> None:
        structure = name.count("/") == 1 and name.startswith("VTKHDF/") and name != "VTKHDF/Points"
        offsets = name.startswith("VTKHDF/Steps/") and name != "VTKHDF/Steps/Values"
        texts = name in tuple(f"etextile/{part}" for part in ("case", "case_effective", "overrides", "ending"))
        restart = name.startswith("etextile/restart/")
        if not isinstance(item, h5py.Dataset) or structure or offsets or texts or restart:
            return
        if "unit" not in item.attrs or not item.attrs.get("description"):
            bare.append(name)

    with h5py.File(path) as file:
        file.visititems(visit)
        record = file["etextile"]
        assert record.attrs["format"] == "etextile results"
        assert list(record.attrs["version"]) == [1, 1]
        assert record["case"].asstr()[()] == "title: test\n"
        assert len(record.attrs["case_sha256"]) == 64
        assert file["VTKHDF/Steps"].attrs["NSteps"] == 1
    assert bare == []


def test_appending_touches_nothing_that_was_written_before(tmp_path: Path) -> None:
    """The bytes of earlier steps and the whole inner structure stay; only counters and new room change."""
    path = tmp_path / "results.vtkhdf"
    with create(path, steps=8) as writer:
        append(writer, 1)
        before = np.frombuffer(path.read_bytes(), dtype=np.uint8)
        append(writer, 2)
        after = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    assert before.size == after.size
    changed = np.count_nonzero(before[before != after])
    assert changed < 32  # the counters, the link to the times and the checksum of their header; all else was zero


KILLED = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[2])
import test_result_file as t
path = Path(sys.argv[1])
writer = t.ResultWriter.reopen(path) if path.exists() else t.create(path, steps=40)
while True:
    t.append(writer, writer.steps + 1)
    print(writer.steps, flush=True)
"""


def test_a_writer_killed_at_any_moment_leaves_a_valid_file_that_can_be_continued(tmp_path: Path) -> None:
    path, chance, steps = tmp_path / "results.vtkhdf", random.Random(3), 0
    for _ in range(3):
        command = [sys.executable, "-c", KILLED, str(path), str(Path(__file__).parent)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            process.stdout.readline()
            time.sleep(chance.uniform(0.0, 0.1))
            process.send_signal(signal.SIGKILL)
            said = process.stdout.read().split()
        found = assert_consistent(path)
        assert found > steps
        assert found >= int(said[-1] if said else 0)
        steps = found
        assert_vtk_shows(path, steps)


@pytest.mark.slow
def test_the_file_is_valid_after_every_single_write_of_an_append(tmp_path: Path) -> None:
    """Replay the writes of appends one by one (recorded with h5py's file-object driver) and open each state."""
    path = tmp_path / "results.vtkhdf"
    with create(path, steps=6) as writer:
        append(writer, 1)
    start = path.read_bytes()
    journal = recorded_writes(tmp_path / "journal.vtkhdf", start)
    assert len(journal) > 20
    image, seen = bytearray(start), []
    for offset, data in journal:
        image[offset : offset + len(data)] = data
        path.write_bytes(image)
        seen.append(assert_consistent(path))
        with h5py.File(path) as file:
            shown, values = file["VTKHDF/Steps"].attrs["NSteps"], len(file["VTKHDF/Steps/Values"])
        assert values == shown == seen[-1]
    assert seen == sorted(seen)
    assert seen[-1] == 4


def recorded_writes(path: Path, start: bytes) -> list[tuple[int, bytes]]:
    """Append three increments to a copy of a file and return every write HDF5 made, in order."""
    journal: list[tuple[int, bytes]] = []

    class Recorder:
        def __init__(self) -> None:
            self.handle = path.open("r+b")

        def __getattr__(self, name: str) -> object:
            return getattr(self.handle, name)

        def write(self, data: bytes) -> int:
            journal.append((self.handle.tell(), bytes(data)))
            return self.handle.write(data)

    path.write_bytes(start)
    recorder = Recorder()
    guarded = GuardedHDF5(path)
    guarded.close()
    guarded.file = h5py.File(recorder, "r+")
    guarded.flush = lambda **_: guarded.file.flush()  # type: ignore[method-assign]
    writer = ResultWriter(path, guarded)
    for number in (2, 3, 4):
        append(writer, number)
    writer.close()
    recorder.handle.close()
    return journal
