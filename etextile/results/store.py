"""The writer of result files: one increment at a time, valid after every one of them, resumable from the last.

The file is built complete under another name and put in place at once; afterwards each increment is written behind what
is there, flushed, and only then counted with a single write. A killed run therefore keeps all it had computed, opens in
ParaView, and goes on with `ResultWriter.reopen`. How: `etextile.results.hdf` and `etextile.results.vtkhdf`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from etextile.errors import EtextileError
from etextile.results import hdf, layout, skeleton, vtkhdf
from etextile.results.layout import BodySurface, CaseRecord, Grid
from etextile.results.restart import flatten
from etextile.results.vtkhdf import Commit, Counters, read_counters


if TYPE_CHECKING:
    from etextile.solve.path import Increment


METADATA_BLOCK = 1 << 16
"""HDF5 sets aside this many bytes at a time for structure, so that a header can be made in one block."""


class ResultWriter:
    """Appends increments to a result file; use as a context manager, or call `close`."""

    def __init__(self, path: Path, file: h5py.File) -> None:
        self._path = path
        self._take(file)

    def _take(self, file: h5py.File) -> None:
        """Hold on to everything an append needs, so that it does not search the file again."""
        root, extra = file["VTKHDF"], file["etextile"]
        self._file, self._extra = file, extra
        self._counters = read_counters(file)
        self._reference = extra["lattice/reference"][:]
        self._points = hdf.Track(root["Points"])
        self._point_arrays, self._cell_arrays = hdf.tracks(root["PointData"]), hdf.tracks(root["CellData"])
        self._histories = hdf.tracks(extra["histories"]) if "histories" in extra else {}
        self._columns = hdf.tracks(extra["increments"])
        self._states = [dict(extra[f"restart/{slot}"].items()) for slot in "01"] if "restart" in extra else []
        self._room = (int(extra.attrs[f"room_{hdf.STEPS}"]), int(extra.attrs[f"room_{hdf.INCREMENTS}"]))
        self._commit = Commit(file)
        rows = extra["increments/step"][: self.increments] >= 0
        travel = extra["increments/travel_mm"][: self.increments]
        self._times: list[float] = list(travel[rows])
        last = extra["increments/displacement_mm"][: self.increments]
        self._travel: float = travel[-1] if self.increments else 0.0
        self._displacement: float = last[-1] if self.increments else 0.0

    @property
    def steps(self) -> int:
        """Output steps in the file."""
        return self._counters.steps

    @property
    def increments(self) -> int:
        """Increments in the file."""
        return self._counters.increments

    @classmethod
    def create(
        cls,
        path: Path,
        grid: Grid,
        *,
        case: CaseRecord,
        steps: int,
        wires: Mapping[str, ArrayLike] | None = None,
        body: BodySurface | None = None,
        restart: object = None,
    ) -> ResultWriter:
        """Start a result file with room for `steps` output steps (it grows when there are more).

        `wires` holds the arrays of `layout.WIRES` by name. `restart` is the state before the first increment (any nest
        that `restart.flatten` takes); the state of the last increment is then kept in arrays of the same shapes.
        """
        path = Path(path)
        part = _build_beside(
            path, lambda file: skeleton.build(file, grid, case, steps, wires or {}, body, flatten(restart))
        )
        part.replace(path)
        return cls(path, _open_for_writing(path))

    @classmethod
    def reopen(cls, path: Path) -> ResultWriter:
        """Go on after the last increment that was written completely; raises BadInput for a file that is not ours."""
        from etextile.results.reader import open_results

        results = open_results(path)
        writer = cls(results.path, _open_for_writing(results.path))
        writer._mark(completed=False, sentence="")
        return writer

    def append(
        self,
        increment: Increment,
        *,
        wall_s: float = 0.0,
        histories: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        """Add a converged increment: one row of curves, its fields when it is an output step, its state for restart.

        `histories` has the arrays of `layout.HISTORIES` by name. `increment.state` is kept when `create` got a state.
        """
        self._make_room()
        if increment.output:
            self._write_fields(increment, histories or {})
        travel = self._write_row(increment, wall_s)
        slot = self._write_restart(flatten(increment.state)) if self._states else -1
        counters = Counters(self.steps + int(increment.output), self.increments + 1, slot)
        times = [*self._times, travel] if increment.output else self._times
        self._commit(counters, times)
        self._counters, self._times = counters, times
        self._travel, self._displacement = travel, increment.displacement_mm

    def finish(self, sentence: str = "", *, completed: bool = True) -> None:
        """Say how the run ended; `completed` is False for a run that found no equilibrium or was interrupted."""
        self._mark(completed=completed, sentence=sentence)

    def close(self) -> None:
        """Close the file; closing twice does no harm."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _write_fields(self, increment: Increment, histories: Mapping[str, ArrayLike]) -> None:
        step = self.steps
        self._points.write(step, increment.positions)
        self._point_arrays["displacement"].write(step, increment.positions - self._reference)
        self._point_arrays["contact_force"].write(step, increment.contact_force)
        for name, track in self._cell_arrays.items():
            track.write(step, getattr(increment, f"truss_{name}"))
        for name, values in histories.items():
            layout.quantity("histories", name)
            if not self._histories:
                raise EtextileError("the result file was created without wires, so it takes no wire histories")
            self._histories[name].write(step, values)

    def _write_row(self, increment: Increment, wall_s: float) -> float:
        """Write the curve values and return the path travelled so far."""
        travel: float = self._travel + abs(increment.displacement_mm - self._displacement)
        step = self.steps if increment.output else -1
        for name, value in (_row(increment) | {"travel_mm": travel, "wall_s": wall_s, "step": step}).items():
            self._columns[name].write(self.increments, value)
        return travel

    def _write_restart(self, restart: Mapping[str, NDArray[Any]]) -> int:
        """Write the state into the slot that is not in use, so that the last good one stays until the commit."""
        slot = 0 if self._counters.restart_slot == 1 else 1
        state = self._states[slot]
        if set(state) != set(restart):
            raise EtextileError(f"restart state holds {sorted(restart)}, the file was created for {sorted(state)}")
        for name, values in restart.items():
            array = np.ascontiguousarray(np.asarray(values, dtype=state[name].dtype)).reshape(np.shape(values))
            if array.shape != state[name].shape:
                raise EtextileError(f"restart array {name!r} has shape {array.shape}, expected {state[name].shape}")
            if array.size:
                state[name].id.write(h5py.h5s.ALL, h5py.h5s.ALL, array)
        return slot

    def _mark(self, *, completed: bool, sentence: str) -> None:
        self._extra["ending"][0] = clip(sentence)
        self._file.flush()
        self._extra.attrs.modify("completed", np.int8(completed))
        self._file.flush()

    def _make_room(self) -> None:
        """Double the room when it is used up: an enlarged copy replaces the file at once."""
        used = (self.steps, self.increments)
        if all(count < room for count, room in zip(used, self._room, strict=True)):
            return
        larger = [2 * room if count >= room else room for count, room in zip(used, self._room, strict=True)]
        plan = dict(zip((hdf.STEPS, hdf.INCREMENTS), zip(used, larger, strict=True), strict=True))
        part = _build_beside(self._path, lambda file: _enlarge(self._file, file, plan))
        self._file.close()
        part.replace(self._path)
        self._take(_open_for_writing(self._path))


def clip(text: str, *, size: int = layout.TEXT_BYTES) -> bytes:
    """Return text as UTF-8 that fits a stored sentence, cut at a character."""
    return text.encode()[:size].decode(errors="ignore").encode()


def _row(increment: Increment) -> dict[str, Any]:
    """Return the curve values of an increment by column name."""
    verdict, energy = increment.verdict, increment.energy
    return {
        "displacement_mm": increment.displacement_mm,
        "punch_force_N": increment.punch_force_N,
        "clamp_force_N": increment.clamp_force_N,
        "max_penetration_mm": increment.max_penetration_mm,
        "external_work": energy.external,
        "stored_energy": energy.stored,
        "plastic_work": energy.plastic,
        "friction_work": energy.friction,
        "contact_energy": energy.contact,
        "work_doubt": energy.work_doubt,
        "softening": increment.softening,
        "converged": verdict.converged,
        "iterations": verdict.iterations,
        "linear_solves": verdict.linear_solves,
        "cut_backs": verdict.cut_backs,
        "residual_N": verdict.residual_N,
        "tolerance_N": verdict.tolerance_N,
        "worst_node": verdict.worst_node,
        "reason": clip(verdict.reason, size=64),
        "sentence": clip(verdict.sentence),
    }


def _open_for_writing(path: Path) -> h5py.File:
    """Open without a lock, so that nobody who looks at a running file can stop the run."""
    return h5py.File(path, "r+", locking=False)


def _build_beside(path: Path, build: Callable[[h5py.File], None]) -> Path:
    """Build a file beside its final place and return where, for the caller to move; on failure nothing is left."""
    part = path.with_name(path.name + ".part")
    try:
        with h5py.File(part, "w", locking=False, meta_block_size=METADATA_BLOCK) as file:
            build(file)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
    return part


def _enlarge(old: h5py.File, new: h5py.File, plan: dict[str, tuple[int, int]]) -> None:
    hdf.copy_enlarged(old, new, plan)
    for name, (_, room) in plan.items():
        new["etextile"].attrs[f"room_{name}"] = room
    vtkhdf.lay_out_steps(new, plan[hdf.STEPS][1])
    Commit(new)(read_counters(old), old["VTKHDF/Steps/Values"][:])
