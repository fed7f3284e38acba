"""The writer of result files: one increment at a time, valid after every one of them, resumable from the last.

The file is built complete under another name and put in place at once; afterwards each increment is written behind what
is there, flushed, and only then counted with a single write. A killed run therefore keeps all it had computed, opens in
ParaView, and goes on with `ResultWriter.reopen`. How: `etextile.results.hdf` and `etextile.results.vtkhdf`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

import h5py
import numpy as np
from numpy.typing import ArrayLike, NDArray

from etextile.errors import EtextileError
from etextile.results import hdf, integrity, layout, skeleton
from etextile.results.copies import build_beside, copy
from etextile.results.guard import GuardedHDF5
from etextile.results.layout import BodySurface, CaseRecord, UndeformedGrid
from etextile.results.restart import flatten
from etextile.results.vtkhdf import Commit, FileCounters, read_counters


if TYPE_CHECKING:
    from etextile.solve.path import Increment


class ResultWriter:
    """Appends increments to a result file; use as a context manager, or call `close`."""

    def __init__(self, path: Path, file: GuardedHDF5) -> None:
        self._path = path
        self._take(file)

    def _take(self, guarded: GuardedHDF5) -> None:
        """Hold on to everything an append needs, so that it does not search the file again."""
        self._guarded, file = guarded, guarded.file
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
        self._commit = Commit(file, guarded.flush)
        checks = extra.get("checks")
        self._checks = {} if checks is None else hdf.tracks(checks)
        self._state_checks = None if checks is None else checks["state"]
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
        grid: UndeformedGrid,
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
        part = build_beside(
            path, lambda file: skeleton.build(file, grid, case, steps, wires or {}, body, flatten(restart))
        )
        part.replace(path)
        return cls(path, GuardedHDF5(path))

    @classmethod
    def reopen(cls, path: Path) -> ResultWriter:
        """Go on after the last increment that was written completely; raises BadInput for a file that is not ours.

        What a power loss tore is left behind: the count goes back to the last increment whose data and state hold.
        """
        from etextile.results.reader import open_results
        from etextile.results.repair import repair

        repair(Path(path))
        results = open_results(path)
        writer = cls(results.path, GuardedHDF5(results.path))
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
        counters = FileCounters(self.steps + int(increment.output), self.increments + 1, slot)
        times = [*self._times, travel] if increment.output else self._times
        self._commit(counters, times)
        self._counters, self._times = counters, times
        self._travel, self._displacement = travel, increment.displacement_mm

    def finish(self, sentence: str = "", *, completed: bool = True) -> None:
        """Say how the run ended; `completed` is False for a run that found no equilibrium or was interrupted."""
        self._mark(completed=completed, sentence=sentence)

    def close(self) -> None:
        """Close the file; closing twice does no harm."""
        self._guarded.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _write_fields(self, increment: Increment, histories: Mapping[str, ArrayLike]) -> None:
        self._write_checked("VTKHDF.Points", self._points, increment.positions)
        moved = increment.positions - self._reference
        for name, values in (("displacement", moved), ("contact_force", increment.contact_force)):
            self._write_checked(f"VTKHDF.PointData.{name}", self._point_arrays[name], values)
        for name, track in self._cell_arrays.items():
            self._write_checked(f"VTKHDF.CellData.{name}", track, getattr(increment, f"truss_{name}"))
        for name, values in histories.items():
            layout.quantity("histories", name)
            if not self._histories:
                raise EtextileError("the result file was created without wires, so it takes no wire histories")
            self._write_checked(f"etextile.histories.{name}", self._histories[name], values)

    def _write_checked(self, name: str, track: hdf.Track, values: ArrayLike) -> None:
        """Write an entry of the next output step with its checksum."""
        stored = track.write(self.steps, values)
        if name in self._checks:
            self._checks[name].write(self.steps, integrity.crc(stored, start=self.steps))

    def _write_row(self, increment: Increment, wall_s: float) -> float:
        """Write the curve values and return the path travelled so far."""
        travel: float = self._travel + abs(increment.displacement_mm - self._displacement)
        step = self.steps if increment.output else -1
        row = _row(increment) | {"travel_mm": travel, "wall_s": wall_s, "step": step}
        stored = {name: self._columns[name].write(self.increments, value) for name, value in row.items()}
        if integrity.ROW in self._checks:
            self._checks[integrity.ROW].write(self.increments, integrity.row_crc(stored, self.increments))
        return travel

    def _write_restart(self, restart: Mapping[str, NDArray[Any]]) -> int:
        """Write the state into the slot that is not in use, so that the last good one stays until the commit."""
        slot = 0 if self._counters.restart_slot == 1 else 1
        state = self._states[slot]
        if set(state) != set(restart):
            raise EtextileError(f"restart state holds {sorted(restart)}, the file was created for {sorted(state)}")
        if self._state_checks is not None:
            kept = {name: np.asarray(values, dtype=state[name].dtype) for name, values in restart.items()}
            after = self.increments + 1
            self._state_checks[slot] = (integrity.state_crc(kept, after), after)
        for name, values in restart.items():
            array = np.ascontiguousarray(np.asarray(values, dtype=state[name].dtype)).reshape(np.shape(values))
            if array.shape != state[name].shape:
                raise EtextileError(f"restart array {name!r} has shape {array.shape}, expected {state[name].shape}")
            if array.size:
                state[name].id.write(h5py.h5s.ALL, h5py.h5s.ALL, array)
        return slot

    def _mark(self, *, completed: bool, sentence: str) -> None:
        self._extra["ending"][0] = clip(sentence)
        self._guarded.flush()
        self._extra.attrs.modify("completed", np.int8(completed))
        self._guarded.flush(sync=True)

    def _make_room(self) -> None:
        """Double the room when it is used up: an enlarged copy replaces the file at once."""
        used = (self.steps, self.increments)
        if all(count < room for count, room in zip(used, self._room, strict=True)):
            return
        larger = [2 * room if count >= room else room for count, room in zip(used, self._room, strict=True)]
        plan = dict(zip((hdf.STEPS, hdf.INCREMENTS), zip(used, larger, strict=True), strict=True))
        part = build_beside(self._path, lambda file: copy(self._file, file, plan, self._counters))
        self._guarded.close()
        part.replace(self._path)
        self._take(GuardedHDF5(self._path))


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
