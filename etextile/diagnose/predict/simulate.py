"""Simulator runs for the diagnosis: asked for by content, kept on disk, spread over local processes.

The workflow knows a simulator only as a callable from `Request` to `Record`; who composes it from case, fabric and
effects stands above. Equal requests are run once: within a diagnosis, and between diagnoses that share a cache folder.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Protocol

import numpy as np

from etextile.diagnose.data.observe import PEAKS, Record
from etextile.diagnose.predict.worn import flexion_of, slips, straight
from etextile.errors import EtextileError, NoEquilibrium
from etextile.kept import keep, recall
from etextile.lattice.weave import DIAGONAL, WARP, WEFT
from etextile.mechanics.model import Model
from etextile.motion.flexion import Flexion
from etextile.process import LocalPool
from etextile.solve.newton import Settings
from etextile.solve.path import Increment, advance
from etextile.solve.system import System
from etextile.types import Array, IntArray


FORMAT = 4
"""Version of cached records: raise it when what a record means changes."""


@dataclass(frozen=True)
class Patience:
    """Linear solves and cut-backs after which a run is given up; an ordinary one takes 60 to 200 and none.

    Between increments, that is: within one at twice as many.
    """

    solves: int
    cut_backs: int

    def within(self, affordable: int | None, *, times: int = 1) -> Patience:
        """Return the patience with at most so many times what is affordable."""
        return self if affordable is None else replace(self, solves=min(self.solves, times * affordable))


TABLE = Patience(2500, 4)
"""For runs with effects over their whole range: some have no equilibrium, and others stand beside."""
EFFORT, LEAST = 6, 300
"""Such a run is given up, too, when it takes so many times the linear solves of the run without effects."""
KEPT = ("x", "y", "symmetry", "displacement", "force", "positions", "peaks", "completed", "angle", "slip", "solves")
"""What is kept of a record."""
SHEAR = PEAKS.index("shear_angle")
VERDICT, LONGER = Patience(8000, 8), 4
"""For the runs that a verdict hangs on, and how many times the solves of others they may take."""


@dataclass(frozen=True)
class EffectSpec:
    """An effect with its parameters in the card's units; `file`: a user's Python file, empty for the library."""

    id: str
    parameters: tuple[tuple[str, float], ...]
    file: str = ""

    @classmethod
    def of(cls, name: str, parameters: Mapping[str, float], file: str = "") -> EffectSpec:
        """Return the specification with parameters rounded to nine digits, so that equal means equal."""
        return cls(name, tuple((key, float(f"{value:.9g}")) for key, value in sorted(parameters.items())), file)


Law = tuple[float, float, float, float]
"""E, sigma_y0, H (MPa) and n of one family."""


@dataclass(frozen=True)
class Request:
    """One run: laws of warp, weft and diagonals, effects, coarsening, travel (mm) and number of output steps.

    `patient`: it is given up later than others. `solves`: linear solves after which it is given up. `back` (mm): the
    way back down to there is wanted, not the way there. `stations`: loads that are output steps, not equal ones.
    `bent`: pure bending to `total` 1/m, no run.
    """

    laws: tuple[Law, Law, Law]
    effects: tuple[EffectSpec, ...]
    coarsening: float
    total: float
    steps: int
    patient: bool = False
    back: float | None = None
    stations: tuple[float, ...] = ()
    bent: bool = False
    solves: int | None = None

    def key(self, fingerprint: str) -> str:
        """Return the name under which the record is kept, for a base case with this fingerprint."""
        laws = [[float(f"{value:.9g}") for value in law] for law in self.laws]
        effects = [[item.id, item.parameters, item.file] for item in self.effects]
        content: list[object] = [FORMAT, fingerprint, laws, effects, self.coarsening, self.total, self.steps]
        content += ["patient"] if self.patient else []
        content += [["back", self.back]] if self.back is not None else []
        content += [["stations", self.stations]] if self.stations else []
        content += ["bent"] if self.bent else []
        content += [["solves", self.solves]] if self.solves is not None else []
        return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:32]


class Simulator(Protocol):
    """Runs a request on the base case; has to be picklable. `fingerprint` identifies the base case."""

    @property
    def fingerprint(self) -> str:
        """What tells the runs of one base case from those of another."""
        ...

    def __call__(self, request: Request) -> Record:
        """Return the record of one run."""
        ...


@dataclass
class Runner:
    """Runs requests through memory, disk and processes; `count` simulator runs were really made."""

    simulator: Simulator
    folder: Path | None = None
    workers: int = 1
    watch: Callable[[int, int], None] | None = None
    count: int = 0
    _known: dict[str, Record] = field(default_factory=dict)
    _pool: LocalPool | None = None

    def __call__(self, requests: Sequence[Request]) -> list[Record]:
        """Return the records of all requests in their order."""
        keys = [request.key(self.simulator.fingerprint) for request in requests]
        missing = {key: request for key, request in zip(keys, requests, strict=True) if self._recall(key) is None}
        for done, (key, record) in enumerate(self._run(missing), start=1):
            self.count += 1
            self._keep(key, record)
            if self.watch is not None:
                self.watch(done, len(missing))
        return [self._known[key] for key in keys]

    def missing(self, requests: Sequence[Request]) -> int:
        """Return how many different runs it would take to answer the requests."""
        keys = {request.key(self.simulator.fingerprint) for request in requests}
        return sum(self._recall(key) is None for key in keys)

    def close(self) -> None:
        """Stop the worker processes."""
        if self._pool is not None:
            self._pool.close(now=True)
            self._pool = None

    def _run(self, missing: Mapping[str, Request]) -> Iterator[tuple[str, Record]]:
        if self.workers == 1 or len(missing) < 2:
            for key, request in missing.items():
                yield key, self.simulator(request)
            return
        if self._pool is None:
            self._pool = LocalPool(self.workers)
        # the longest runs first, so that no process is left with one at the end
        order = {request: key for key, request in sorted(missing.items(), key=lambda item: item[1].coarsening)}
        for outcome in self._pool.run(self.simulator, list(order)):
            if outcome.result is None:
                raise outcome.error or EtextileError("a run of the diagnosis left no result")
            yield order[outcome.task], outcome.result

    def _recall(self, key: str) -> Record | None:
        if key not in self._known and self.folder is not None:
            record = load_record(self.folder / f"{key}.npz")
            if record is not None:
                self._known[key] = record
        return self._known.get(key)

    def _keep(self, key: str, record: Record) -> None:
        """Keep a record as its file will give it back, so that a repeated diagnosis is the same to the last digit."""
        record = replace(record, positions=record.positions.astype(np.float32).astype(float))
        self._known[key] = record
        if self.folder is not None:
            self.folder.mkdir(parents=True, exist_ok=True)
            save_record(record, self.folder / f"{key}.npz")


def save_record(record: Record, path: Path) -> None:
    """Write a record (positions in single precision); a killed process leaves no half file."""
    keep(path, {name: getattr(record, name) for name in KEPT} | {"positions": record.positions.astype(np.float32)})


def load_record(path: Path) -> Record | None:
    """Return a kept record, None when there is none or it cannot be read."""
    found = recall(path, KEPT)
    if found is None:
        return None
    symmetry = (bool(found["symmetry"][0]), bool(found["symmetry"][1]))
    return Record(
        found["x"], found["y"], symmetry, found["displacement"], found["force"],
        found["positions"].astype(float), found["peaks"], bool(found["completed"]), float(found["angle"]),
        found["slip"], int(found["solves"]),
    )  # fmt: skip


def run_model(model: Model, settings: Settings, *, patience: Patience | None = None, back: bool = False) -> Record:
    """Run a model and keep what the diagnosis needs; `back`: of the way back of a flat piece alone.

    A run without equilibrium, or one that takes more to find it than there is patience, ends early: its record is not
    completed.
    """
    increments: list[Increment] = []
    system = System(model, linear=settings.linear, most_solves=None if patience is None else 2 * patience.solves)
    if patience is not None:
        settings = replace(settings, max_cut_backs=min(settings.max_cut_backs, patience.cut_backs))
    completed = True
    try:
        for item in advance(model, settings, system=system):
            increments += [item] if item.output else []
            at_end = item.displacement_mm == model.travel[-1]
            if patience is not None and not at_end and system.counters.linear_solves > patience.solves:
                completed = False
                break
    except NoEquilibrium:
        completed = False
    found = _record(model, increments, back=back, completed=completed)
    return replace(found, solves=system.counters.linear_solves)


def _record(model: Model, increments: Sequence[Increment], *, back: bool, completed: bool) -> Record:
    """Return what the diagnosis needs of the increments of a run."""
    if back:
        return _way_back(model, increments, completed=completed)
    motion = flexion_of(model)
    if motion is not None:
        return _worn(model, motion, increments, completed=completed)
    lattice = model.lattice
    x, y, shape = places(lattice.points)
    positions = [lattice.points.reshape(shape)]
    positions += [item.positions[: len(lattice.points)].reshape(shape) for item in increments]
    displacement = np.array([0.0, *(item.displacement_mm for item in increments)])
    peaks = np.zeros((len(displacement), len(PEAKS)))
    for row, item in enumerate(increments, start=1):
        peaks[row, :5] = _peaks(model, item, item.positions)
    step = np.diff(displacement, prepend=-1.0)
    if model.unit == "mm":
        peaks[:, 5] = np.maximum.accumulate(np.diff(peaks[:, 0], prepend=0.0) / step) * model.speed
    return Record(
        x, y, lattice.symmetry, displacement, np.array([0.0, *(item.punch_force_N for item in increments)]),
        np.array(positions), peaks, completed, lattice.warp_angle,
    )  # fmt: skip


def affordable(plain: Record) -> int:
    """Return the linear solves after which a run with effects is given up, from the run without any."""
    return max(LEAST, EFFORT * plain.solves)


def _worn(model: Model, motion: Flexion, increments: Sequence[Increment], *, completed: bool) -> Record:
    """Return the record of a worn piece: the flexion from the straight limb on, which it was put on before."""
    lattice = model.lattice
    x, y, shape = places(lattice.points)
    start, moment = straight(model, increments)
    bends = [item for item in increments if item.displacement_mm > 0.0]
    positions = np.array([start, *(item.positions[: len(start)] for item in bends)])
    angle = np.array([0.0, *(item.displacement_mm for item in bends)])
    peaks = np.zeros((len(angle), len(PEAKS)))
    for row, item in enumerate(bends, start=1):
        family = _family_strains(model, item)
        peaks[row, : len(family)] = family
        peaks[row, SHEAR] = _shear_angle(item.positions, lattice.quads)
    return Record(
        x, y, lattice.symmetry, angle, np.array([moment, *(np.degrees(item.punch_force_N) for item in bends)]),
        positions.reshape(-1, *shape), peaks, completed, lattice.warp_angle,
        slips(motion, positions, angle).reshape(-1, *shape[:2]),
    )  # fmt: skip


def places(flat: Array) -> tuple[Array, Array, tuple[int, int, int]]:
    """Return x, y and the shape of positions as a record keeps them, for flat nodes (N, 3).

    Lines along x and y where the nodes stand on all their crossings, x slowest; else the nodes' own coordinates.
    """
    x, y = np.unique(flat[:, 0]), np.unique(flat[:, 1])
    if len(x) * len(y) == len(flat):
        crossings = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        if np.array_equal(crossings, flat[:, :2]):
            return x, y, (len(x), len(y), 3)
    return flat[:, 0], flat[:, 1], (len(flat), 1, 3)


def _way_back(model: Model, increments: Sequence[Increment], *, completed: bool) -> Record:
    """Return the steps from the largest displacement on, in rising order; internal variables are not kept."""
    lattice = model.lattice
    x, y, shape = places(lattice.points)
    top = int(np.argmax([item.displacement_mm for item in increments])) if increments else 0
    steps = list(reversed(increments[top:]))
    positions = [item.positions[: len(lattice.points)].reshape(shape) for item in steps]
    return Record(
        x, y, lattice.symmetry, np.array([item.displacement_mm for item in steps]),
        np.array([item.punch_force_N for item in steps]), np.array(positions), np.zeros((len(steps), len(PEAKS))),
        completed, lattice.warp_angle,
    )  # fmt: skip


def _peaks(model: Model, item: Increment, positions: Array) -> list[float]:
    """Return largest strains of the three families, clamp line force in N/mm and shear angle in degrees."""
    return [*_family_strains(model, item), _line_force(model, item), _shear_angle(positions, model.lattice.quads)]


def _family_strains(model: Model, item: Increment) -> list[float]:
    """Return the largest strains of warp, weft and diagonals."""
    family = model.lattice.family
    strain = item.truss_strain[: len(family)]
    return [float(strain[family == name].max(initial=0.0)) for name in (WARP, WEFT, DIAGONAL)]


def _line_force(model: Model, item: Increment) -> float:
    """Return the largest pull of the trusses on a node of the clamped edge x_max per width of the clamp, N/mm.

    Nothing for pieces without such an edge, and for those whose ends do not all stand on the lattice's lines.
    """
    lattice = model.lattice
    edge = lattice.edges.get("x_max", np.zeros(len(lattice.points), dtype=np.bool_))
    if not edge.any() or lattice.warp_angle % 90.0:
        return 0.0
    trusses = lattice.trusses
    ends = item.positions[trusses]
    vector = ends[:, 1] - ends[:, 0]
    pull = item.truss_force[: len(trusses), None] * vector / np.linalg.norm(vector, axis=1, keepdims=True)
    total = np.zeros((len(lattice.points), 3))
    np.add.at(total, trusses[:, 0], pull)
    np.add.at(total, trusses[:, 1], -pull)
    width = float(np.diff(np.unique(lattice.points[:, 1])).mean())
    return float((np.linalg.norm(total[edge], axis=1) / (width * lattice.share[edge] * 2.0)).max())


def _shear_angle(positions: Array, quads: IntArray) -> float:
    """Return the largest change of the right angle between warp and weft in whole cells (Q, 4), degrees."""
    corners = positions[quads]
    along, across = corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]
    cosine = np.einsum("qc,qc->q", along, across)
    cosine /= np.linalg.norm(along, axis=-1) * np.linalg.norm(across, axis=-1)
    return float(np.degrees(np.arcsin(np.clip(np.abs(cosine), 0.0, 1.0))).max(initial=0.0))
