"""What was measured, as one vector, and what a trial predicts of it: force, height, motion of material points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from etextile.diagnose.data.measured import Measurements
from etextile.diagnose.data.points import force_drop
from etextile.diagnose.data.surface import Surface, heights, motions, pulls
from etextile.diagnose.predict.bent import STATIONS, bent_record
from etextile.diagnose.predict.run_tables import PULLED
from etextile.diagnose.predict.worn import flexion_of, worn_surface
from etextile.errors import BadInput, NoEquilibrium, Problem
from etextile.identify.calibration import Data
from etextile.solve.path import advance
from etextile.studies.calibrate.cycles import Cycle, along_path, run_cycle
from etextile.studies.calibrate.parameters import Change
from etextile.studies.diagnose.channels import of_load
from etextile.types import Array, BoolArray, IntArray
from etextile.vocabulary import BEND, CYCLE, FIELD, FORCE, HEIGHT, MOMENT, PULL, SLIP
from loadcases.build import build, settings, travel_points
from loadcases.build_bent import bent_piece
from loadcases.schema import Case
from loadcases.schema_parts import Effect


MOST_STATIONS = 60
"""Loads at which a field was measured are output steps of the run up to so many."""
UNITS = {
    FORCE: "N", PULL: "N", HEIGHT: "mm", FIELD: "mm", MOMENT: "N mm", BEND: "N m/m", CYCLE: "N", SLIP: "mm",
}  # fmt: skip
CHANNELS = tuple(UNITS)


@dataclass(frozen=True)
class Observed:
    """All readings: value (n,), load (n,), specimen (n,), channel (n,) into CHANNELS, component (n,) of a motion.

    stated (n,): noise as stated, NaN without; `names`: files of the specimens; test (n,): number of the test of each
    reading where there are several.
    """

    measured: Measurements
    value: Array
    load: Array
    specimen: IntArray
    channel: IntArray
    stated: Array
    names: tuple[str, ...]
    notes: tuple[str, ...] = ()
    test: IntArray | None = None

    def of(self, channel: str) -> BoolArray:
        """Return the mask (n,) of a channel."""
        return np.asarray(self.channel == CHANNELS.index(channel))

    @property
    def present(self) -> tuple[str, ...]:
        """Names of the channels that are there."""
        return tuple(name for name in CHANNELS if self.of(name).any())

    def readings(self, predicted: Array) -> dict[str, tuple[Array, Array, Array, IntArray]]:
        """Return load, measured, predicted and specimen of every channel, for drawing."""
        chosen = {name: self.of(name) for name in self.present}
        return {
            name: (self.load[own], self.value[own], predicted[own], self.specimen[own]) for name, own in chosen.items()
        }

    def data(self, noise: Array, mask: BoolArray) -> Data:
        """Return noise and clusters of the points of a mask for the search."""
        return Data(noise, self.load_number, 10 * self.specimen + self.channel).where(mask)

    @property
    def load_number(self) -> IntArray:
        """Number (n,) of the load of each reading."""
        test = np.zeros(len(self.load)) if self.test is None else self.test
        pairs = np.stack([test, np.round(self.load, 9)], axis=1)
        return np.unique(pairs, axis=0, return_inverse=True)[1].reshape(-1).astype(np.int64)


def joined(parts: Sequence[Observed]) -> Observed:
    """Return the readings of several tests as one vector; specimens are numbered on from test to test."""
    if len(parts) == 1:
        return parts[0]
    before = np.cumsum([0, *(len(part.names) for part in parts[:-1])])

    def all_of(name: str) -> Array:
        return np.concatenate([getattr(part, name) for part in parts])

    return Observed(
        parts[0].measured, all_of("value"), all_of("load"),
        np.concatenate([part.specimen + start for part, start in zip(parts, before, strict=True)]),
        np.concatenate([part.channel for part in parts]), all_of("stated"),
        tuple(name for part in parts for name in part.names), tuple(note for part in parts for note in part.notes),
        np.repeat(np.arange(len(parts)), [len(part.value) for part in parts]),
    )  # fmt: skip


def observed_of(case: Case, measured: Measurements) -> Observed:
    """Return the readings of a folder that the case predicts; raises BadInput for channels of another motion."""
    problems = list(_misfits(case, measured))
    if problems:
        raise BadInput(problems)
    parts: list[tuple[str, str, Array, Array, float | None]] = []
    notes = list(measured.notes)
    if measured.moment_curvature:
        notes += bent_piece(case).told(item.id for item in case.effects)
    for curve in measured.punch_force:
        end = force_drop(curve)
        if end < len(curve.force):
            notes.append(f"{curve.file} is cut at {curve.displacement[end - 1]:.4g} mm, where its force drops")
        parts.append(("punch_force", curve.file, curve.displacement[:end], curve.force[:end], curve.noise))
    parts += [("clamp_force", item.file, item.displacement, item.force, item.noise) for item in measured.clamp_force]
    parts += [
        ("pressure_height", item.file, item.pressure, item.height, item.noise) for item in measured.pressure_height
    ]
    for field_ in measured.displacement_field:
        motion = field_.motion.ravel()
        parts.append(("displacement_field", field_.file, np.repeat(field_.load, 3), motion, field_.noise))
    parts += [("joint_moment", item.file, item.angle, item.moment, item.noise) for item in measured.joint_moment]
    parts += [(BEND, item.file, item.curvature, item.moment, item.noise) for item in measured.moment_curvature]
    parts += [(CYCLE, item.file, item.travelled, item.force, item.noise) for item in measured.cyclic_force]
    if measured.mark_slip is not None:
        seen = measured.mark_slip
        parts += [(SLIP, name, seen.angle[rows], seen.slip[rows], seen.noise) for name, rows in seen.marks.items()]
    files = tuple(dict.fromkeys(name for _, name, *_ in parts))
    size = [len(value) for *_, value, _ in parts]
    return Observed(
        measured,
        np.concatenate([value for *_, value, _ in parts]),
        np.concatenate([load for _, _, load, _, _ in parts]),
        np.repeat([files.index(name) for _, name, *_ in parts], size),
        np.repeat([CHANNELS.index(channel) for channel, *_ in parts], size),
        np.repeat([np.nan if noise is None else noise for *_, noise in parts], size),
        files,
        tuple(notes),
    )


def _misfits(case: Case, measured: Measurements) -> list[Problem]:
    """Return what keeps case and measurements apart."""
    found = []
    if not any(getattr(measured, name) for name in CHANNELS):
        found.append(Problem(f"no channel to go by, give one of {', '.join(CHANNELS)}", file=measured.file))
    found += of_load(case, measured)
    if case.motion.path is not None and np.any(np.diff((0.0, *case.motion.path)) < 0.0):
        found.append(Problem("a motion that goes back cannot be calibrated, leave the path away", key="motion.path"))
    return found


def _changed(effect: Effect, change: Change) -> Effect:
    """Return an effect with the parameters of a trial."""
    own = {name: value for (name_of, name), value in change.effects.items() if name_of == effect.id}
    return Effect.model_validate({"id": effect.id, **effect.parameters, **own})


def percent(left: Array, value: Array) -> float:
    """Return the root mean square of differences (n,) in per cent of that of the measured values (n,)."""
    size = float(np.sqrt(np.mean(value**2)))
    return 100.0 * float(np.sqrt(np.mean(left**2))) / size if size > 0.0 else 0.0


def sum_of_mean_absolute(left: Array) -> float:
    """Return the mean of |dx| + |dy| + |dz| of a field, mm, whose differences (n,) stand one behind the other."""
    return 3.0 * float(np.abs(left).mean())


@dataclass
class Models:
    """Several tests of one fabric, each with its case; trials are run in all of them."""

    parts: tuple[CaseModel, ...]

    @property
    def case(self) -> Case:
        """The case of the first test."""
        return self.parts[0].case

    @cached_property
    def observed(self) -> Observed:
        """All readings, test after test."""
        return joined([part.observed for part in self.parts])

    @property
    def count(self) -> int:
        """Runs made."""
        return sum(part.count for part in self.parts)

    def predict(self, changes: Sequence[Change], *, finer: float = 1.0) -> list[Array]:
        """Return predicted readings (n,) of every trial; `finer`: every case's coarsening over this, at least 1."""
        return [
            np.concatenate(found)
            for found in zip(*(part.predict(changes, finer=finer) for part in self.parts), strict=True)
        ]

    def residuals(
        self, change_of: Callable[[Array], Change], mask: BoolArray
    ) -> Callable[[Sequence[Array]], list[Array]]:
        """Return predicted minus measured over a mask, as a function of points of the search."""

        def of(points: Sequence[Array]) -> list[Array]:
            found = self.predict([change_of(y) for y in points])
            return [(item - self.observed.value)[mask] for item in found]

        return of


@dataclass
class CaseModel:
    """Runs trials of a case as far as it was measured; equal trials are run once. `count`: runs made."""

    case: Case
    observed: Observed
    count: int = 0
    _known: dict[str, Surface | None] = field(default_factory=dict)
    _cycles: dict[str, Cycle | None] = field(default_factory=dict)

    def predict(self, changes: Sequence[Change], *, finer: float = 1.0) -> list[Array]:
        """Return predicted readings (n,) of every trial; NaN where it finds no equilibrium."""
        coarsening = None if finer == 1.0 else max(self.case.fabric.coarsening / finer, 1.0)
        return [self._read(change, coarsening) for change in changes]

    def _read(self, change: Change, coarsening: float | None) -> Array:
        observed, parts = self.observed, []
        if set(observed.present) - {CYCLE}:
            surface = self.surface(change, coarsening=coarsening)
            if surface is None:
                return np.full(len(observed.value), np.nan)
            parts += self._of_surface(surface, change)
        for item in observed.measured.cyclic_force:
            parts.append(along_path(self._cycle(change, item.path, coarsening), item.path, item.travelled))
        return np.concatenate(parts)

    def _of_surface(self, surface: Surface, change: Change) -> list[Array]:
        """Return what a run that goes on and on says of every specimen, in the order of the readings."""
        measured, parts = self.observed.measured, []
        for curve in measured.punch_force:
            end = force_drop(curve)
            parts.append(surface.at_load(surface.force, np.maximum(curve.displacement[:end], 0.0)))
        parts += [pulls(surface, item.displacement, item.preload) for item in measured.clamp_force]
        parts += [heights(surface, item) for item in measured.pressure_height]
        parts += [motions(surface, item, centre=change.centre).ravel() for item in measured.displacement_field]
        parts += [surface.at_load(np.degrees(surface.force), item.angle) for item in measured.joint_moment]
        parts += [surface.at_load(surface.force, item.curvature) for item in measured.moment_curvature]
        if measured.mark_slip is not None:
            seen = measured.mark_slip
            rows = np.concatenate(list(seen.marks.values()))
            parts.append(surface.slips(np.stack([seen.warp0, seen.weft0], axis=1)[rows], seen.angle[rows]))
        return parts

    def surface(self, change: Change, *, coarsening: float | None = None) -> Surface | None:
        """Return the run of a trial, None when it finds no equilibrium as far as was measured."""
        key = repr((change.fabric, sorted(change.effects.items()), coarsening))
        if key not in self._known:
            self._known[key] = self._run(change, coarsening)
            self.count += 1
        return self._known[key]

    def _cycle(self, change: Change, path: tuple[float, ...], coarsening: float | None) -> Cycle | None:
        """Return the run of a trial along a path there and back, None when it finds no equilibrium."""
        key = repr((change.fabric, sorted(change.effects.items()), coarsening, path))
        if key not in self._cycles:
            self._cycles[key] = run_cycle(self._case(change, coarsening), change.fabric, path)
            self.count += 1
        return self._cycles[key]

    def _case(self, change: Change, coarsening: float | None) -> Case:
        """Return the case of a trial, without wires."""
        fabric = self.case.fabric
        if coarsening is not None:
            fabric = fabric.model_copy(update={"coarsening": coarsening})
        effects = tuple(_changed(item, change) for item in self.case.effects)
        return self.case.model_copy(update={"effects": effects, "fabric": fabric, "wires": None})

    def _run(self, change: Change, coarsening: float | None) -> Surface | None:
        case = self._case(change, coarsening)
        if self.observed.measured.moment_curvature:
            return bent_record(bent_piece(case, fabric=change.fabric).model, self.travel).surface
        built = build(case, fabric=change.fabric)
        growth = built.model.travel[built.model.travel <= 0.0]
        model = replace(built.model, travel=np.concatenate([growth, self.travel]))
        try:
            increments = [item for item in advance(model, settings(case)) if item.output]
        except NoEquilibrium:
            return None
        steps = [
            (item.displacement_mm, item.punch_force_N, item.positions)
            for item in increments
            if item.displacement_mm > 0.0
        ]
        found, flexion = Surface.of(model, steps), flexion_of(model)
        return found if flexion is None else worn_surface(found, model, flexion, increments)

    @property
    def travel(self) -> Array:
        """Output steps: the loads of heights and fields when they are few, else those of the case, as far as needed."""
        observed = self.observed
        onward = observed.load[~observed.of(CYCLE)]
        reach = float(onward.max()) * (PULLED if observed.of("clamp_force").any() else 1.0)
        loads = np.unique(np.round(onward[onward > 0.0], 9))
        if observed.measured.moment_curvature:
            return np.asarray(loads if len(loads) <= STATIONS else np.linspace(0.0, reach, STATIONS + 1)[1:])
        forces = observed.of("punch_force").any() or observed.of("clamp_force").any()
        if not forces and len(loads) <= MOST_STATIONS:
            return np.asarray(loads)
        spacing = float(np.diff(travel_points(self.case), prepend=0.0).max())
        count = max(4, int(np.ceil(reach / spacing - 1e-9)))
        return np.linspace(0.0, reach, count + 1)[1:]
