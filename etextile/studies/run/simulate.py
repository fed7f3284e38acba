"""One simulation from case to result file: build, solve, store increment by increment, resume."""

from __future__ import annotations

import difflib
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib import metadata
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from etextile.errors import BadInput, NoEquilibrium
from etextile.files import check_targets, no_space, remove
from etextile.results.layout import FILE_NAME, WIRES, BodySurface, CaseRecord, UndeformedGrid, names, stored_name
from etextile.results.reader import Results, open_results
from etextile.results.restart import rebuild
from etextile.results.store import ResultWriter
from etextile.solve.path import Increment, Snapshot, advance, start
from etextile.studies.run.continuation import Inside, identified_to, reached_in, still_inside
from etextile.studies.run.settling import Settling, settling_of
from etextile.types import Array
from loadcases.build import Built, build, settings
from loadcases.reader import LoadedCase, dump_case
from loadcases.schema import Case


PACKAGES = ("etextile", "numpy", "scipy", "numba", "h5py")
JUDGED = (
    "report.json", "report.html", "report.pdf", "force_displacement.csv", "moment_angle.csv", "wires.csv",
    *(f"maps/{name}.png" for name in ("failure", "failure_inner", "failure_flat", "wire_strain")),
    *(f"maps/{name}_strain.png" for name in ("warp", "weft", "diagonal")),
)  # fmt: skip
"""What an earlier run said in its folder: it goes before the first new step, so that no old verdict stands over it."""
ROOM = 400
"""Output steps for which a result file has room at first; it grows."""
INTERRUPTED = "interrupted; go on with --resume"
"""Ending of a run that may go on."""
Watcher = Callable[[Increment], None]


@dataclass(frozen=True)
class Simulation:
    """A finished or broken-off simulation: what was built, the result file, why it stopped early, seconds.

    `inside`: the last state with all laws within their range.
    """

    built: Built
    results: Results
    trouble: str
    wall_s: float
    linear: str
    inside: Inside


def simulate(
    loaded: LoadedCase, folder: Path, *, resume: bool, force: bool, seed: int, watch: Watcher | None
) -> Simulation:
    """Run a case into `folder`; raises BadInput before anything is computed or written.

    A path that ends without equilibrium is no error here: `trouble` says what happened, the file keeps what converged.
    """
    path = folder / FILE_NAME
    check_targets(folder, ("maps/", *JUDGED, *(() if resume else (FILE_NAME,))))
    earlier = _earlier(path, loaded, resume=resume, force=force)
    built = build(loaded.case)
    begun = time.perf_counter()
    snapshot, done = None, 0
    if earlier is not None:
        snapshot, done = _continued(built, earlier)
    folder.mkdir(parents=True, exist_ok=True)
    remove(folder, JUDGED)
    writer = ResultWriter.reopen(path) if earlier is not None else _create(path, loaded, built, seed)
    trouble, inside, settling = "", _inside(built, earlier, snapshot, done), _settling(loaded, built, earlier)
    with writer:
        try:
            for increment in () if settling.over else _timed(built, snapshot, done, writer):
                if increment.output and inside.steps == increment.index and still_inside(built, increment):
                    inside = Inside(increment.state, increment.index + 1)
                if watch is not None:
                    watch(increment)
                if increment.output and settling.take(writer.steps - 1, increment.truss_plastic_strain):
                    break
        except NoEquilibrium as error:
            trouble = str(error)
            writer.finish(trouble, completed=False)
        except OSError as error:
            kept = f"{writer.steps} steps are kept in {path}, free some and go on with --resume"
            raise no_space(error, kept) from error
        except KeyboardInterrupt:
            writer.finish(INTERRUPTED, completed=False)
            raise
        else:
            writer.finish("completed")
    linear = settings(loaded.case).linear
    return Simulation(built, open_results(path), trouble, time.perf_counter() - begun, linear, inside)


def simulated(results: Results, case: Case) -> Simulation:
    """Return what a result file holds as a simulation; raises BadInput for a model that cannot be built."""
    built = build(case)
    trouble = "" if results.completed else results.ending
    wall = float(results.increments.wall_s.sum())
    return Simulation(built, results, trouble, wall, settings(case).linear, Inside())


def _inside(built: Built, earlier: Results | None, snapshot: Snapshot | None, done: int) -> Inside:
    """Return the state to go on from when it is within the range of all laws, else the flat piece."""
    if earlier is None or snapshot is None or np.any(reached_in(earlier, built) > identified_to(built)):
        return Inside()
    return Inside(snapshot, done)


def _settling(loaded: LoadedCase, built: Built, earlier: Results | None) -> Settling:
    """Return what is known of the growth of plastic strain before the first increment."""
    travel, tolerance = built.model.travel, loaded.case.motion.settled
    return Settling(travel, tolerance) if earlier is None else settling_of(earlier, travel, tolerance)


def _timed(built: Built, snapshot: Snapshot | None, done: int, writer: ResultWriter) -> Iterator[Increment]:
    """Yield increments after they are in the file."""
    then = time.perf_counter()
    for increment in advance(built.model, settings(built.case), snapshot=snapshot, first_index=done):
        now = time.perf_counter()
        writer.append(
            increment,
            wall_s=now - then,
            histories=_histories(built, increment) if increment.output else None,
        )
        yield increment
        then = time.perf_counter()


def _earlier(path: Path, loaded: LoadedCase, *, resume: bool, force: bool) -> Results | None:
    """Return the results to go on from, if any; raises BadInput for another case's folder."""
    if not path.exists():
        if resume:
            raise BadInput.of("there is no result file to resume from, run without --resume", file=str(path.parent))
        return None
    if force and not resume:
        return None
    results = open_results(path)
    if results.case.sha256 == loaded.sha256:
        return results if resume else None
    if resume:
        changed = _differences(results.case.effective, dump_case(loaded.case))
        raise BadInput.of(f"the case changed since this run, so it cannot be resumed:\n{changed}", file=str(path))
    raise BadInput.of(
        f"holds the results of another case ({_what_differs(results.case.effective, dump_case(loaded.case))}), "
        "choose another --output or overwrite it with --force",
        file=str(path.parent),
    )


def _what_differs(before: str, after: str) -> str:
    """Return the first lines of a case that differ, its title before all others, in one line."""
    pairs = zip_longest(before.splitlines(), after.splitlines(), fillvalue="nothing")
    lines = [f"{one.strip()} there, {two.strip()} here" for one, two in pairs if one != two]
    return "; ".join(lines[:3])[:300] if lines else "the code or a file that it names has changed"


def _differences(before: str, after: str) -> str:
    lines = difflib.unified_diff(before.splitlines(), after.splitlines(), "then", "now", lineterm="", n=1)
    return "\n".join(f"  {line}" for line in list(lines)[2:])


def _continued(built: Built, earlier: Results) -> tuple[Snapshot | None, int]:
    """Return the last converged state and the number of output steps already there."""
    kept = earlier.restart()
    return (None, 0) if kept is None else (rebuild(start(built.model), kept), earlier.steps)


def _create(path: Path, loaded: LoadedCase, built: Built, seed: int) -> ResultWriter:
    model = built.model
    lattice = model.lattice
    followers = model.followers
    cells, wire = lattice.trusses, np.full(len(lattice.trusses), -1)
    if followers is not None:
        cells, wire = np.concatenate([cells, followers.cells]), np.concatenate([wire, followers.wire])
    points = flat_points(built)
    clamped = np.zeros(len(points), dtype=bool)
    clamped[: len(lattice.points)] = model.fixed[: len(lattice.points)].all(axis=1)
    grid = UndeformedGrid(
        reference=points,
        cells=cells,
        family=np.concatenate([block.family for block in model.truss_blocks]).astype(np.int8),
        wire=wire.astype(np.int32),
        quads=np.concatenate([lattice.quads, lattice.edge_cells]),
        clamped=clamped,
        symmetry=lattice.symmetry,
        warp_angle_deg=lattice.warp_angle,
    )
    record = CaseRecord(
        text=loaded.source_text,
        effective=dump_case(loaded.case),
        sha256=loaded.sha256,
        source=str(loaded.path.name) if loaded.path else "",
        overrides=loaded.overrides,
        versions={name: metadata.version(name) for name in PACKAGES},
        seed=seed,
        travel_unit=loaded.case.motion.unit,
        created=datetime.now(UTC).isoformat(timespec="seconds"),
    )
    body = None
    if built.body is not None:
        vertices, faces = built.body.surface()
        skin = None if built.worn is None else built.worn.motion.limb.skin
        body = BodySurface(vertices, faces, model.direction, skin)
    return ResultWriter.create(
        path,
        grid,
        case=record,
        steps=min(len(model.travel), ROOM),
        wires=_wire_arrays(built),
        body=body,
        restart=start(model),
    )


def flat_points(built: Built) -> Array:
    """Return where all points (n, 3) mm lie on the flat piece: where they begin, but for a piece that is worn."""
    model = built.model
    if built.worn is None:
        return model.all_points(model.points)
    flat, followers = model.lattice.points, model.followers
    if followers is None:
        return flat
    around = flat[followers.nodes, 1]
    across = np.ptp(around, axis=1) > 0.5 * built.case.pattern[1]
    around += np.where(across[:, None] & (around < 0.0), built.case.pattern[1], 0.0)
    places = np.stack(
        [(followers.weights * values).sum(axis=1) for values in (flat[followers.nodes, 0], around)], axis=1
    )
    return np.concatenate([flat, np.pad(places, ((0, 0), (0, 1)))])


def _wire_arrays(built: Built) -> dict[str, Any] | None:
    if built.wires is None:
        return None
    layout = vars(built.wires.layout)
    arrays = {name: layout[name] for name in names(WIRES) if name in layout}
    own = {"names": [stored_name(name) for name in built.wires.layout.names]}
    return arrays | built.wires.elements | _part_arrays(built) | own


def _part_arrays(built: Built) -> dict[str, Any]:
    """Return names and lands of the parts of a case."""
    from loadcases.build_paths import drawn_wires

    wires = built.case.wires
    parts = drawn_wires(built.case).parts if wires is not None and wires.drawn else ()
    return (
        {
            "part_names": [stored_name(part.name) for part in parts],
            "part_at_mm": np.array([part.at for part in parts], dtype=float).reshape(-1, 2),
            "part_size_mm": np.array([part.size for part in parts], dtype=float).reshape(-1, 2),
        }
        if parts
        else {}
    )


def _histories(built: Built, increment: Increment) -> dict[str, Array] | None:
    """Return strains of loops and woven-in elements: spans as they are, wires after crimp or slack is taken up."""
    from wires.strain import wire_strains

    return None if built.wires is None else wire_strains(built.wires, built.model, increment)
