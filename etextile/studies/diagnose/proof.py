"""Stage 7: the ordinary command without and with the patch, and what becomes of gaps and wires.

Both runs are made as `etextile run` makes them, wires included, on the fabric that was identified from the coupons. A
third one has the effect as it was fitted without the held-out displacements: it is what held-out gaps are judged by.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from etextile.diagnose.data.observe import PEAKS, Record, observe
from etextile.diagnose.decide.heldout import HeldOut, is_beyond
from etextile.diagnose.decide.proof import EFFECT, Proof, RunPair, change_by_runs, prove
from etextile.diagnose.decide.verdict import Finalist
from etextile.diagnose.predict.run_tables import Levels
from etextile.diagnose.predict.simulate import Runner, places
from etextile.diagnose.predict.worn import slips
from etextile.diagnose.workflow import Diagnosis
from etextile.errors import NoEquilibrium
from etextile.results.reader import Results
from etextile.studies.diagnose.folder import Folder
from etextile.studies.diagnose.patch import (
    FABRIC,
    PATCH,
    Found,
    effects_of,
    found_effects,
    longer_motion,
    measured_levels,
    patch_of,
    patch_text,
    strains_up_to,
)
from etextile.studies.diagnose.setting import DiagnosisTask
from etextile.studies.identify.identify import HEADER
from etextile.studies.run.outcome import Run
from etextile.studies.run.run import run
from etextile.studies.run.simulate import simulate
from etextile.types import Array
from etextile.units import load_text
from etextile.vocabulary import FABRIC_FAMILIES
from loadcases.build import build
from loadcases.build_worn import Worn
from loadcases.fabric import dump_fabric
from loadcases.reader import LoadedCase, as_loaded, stored_case
from loadcases.schema import Case
from loadcases.schema_parts import Effect


BASE, PATCHED, HELD_OUT = "base", "patched", "held_out"
"""Folders of the three runs."""
NO_WIRES = "wire states were observed, but the case has no wires"
BENT = "a bending test is no run of the case: the gaps are those of its piece laid around a cylinder"
Advance = Callable[[float, float, str], None]


@dataclass(frozen=True)
class Proven:
    """Gaps by the ordinary runs; `as_run`: the same without taking off lattice error and the share of the wires.

    `base`, `patched`: outcomes of the ordinary command; `notes`: what a reader has to know; `lost`: measured points
    are in no gap because a run broke off.
    """

    proof: Proof
    base: Run | None
    patched: Run | None
    as_run: tuple[dict[str, Any], ...]
    notes: tuple[str, ...]
    lost: str = ""


def without_effect(diagnosis: Diagnosis) -> Proven:
    """Return the gaps when there is nothing to add: nothing is run."""
    return Proven(_prove(diagnosis, None, None), None, None, (), ())


def prove_patch(
    task: DiagnosisTask, diagnosis: Diagnosis, finalist: Finalist, patch: Path, *, folder: Folder, runner: Runner,
    advance: Advance,
) -> Proven:  # fmt: skip
    """Run the ordinary command without and with a patch file, and return the gaps by these runs.

    The file is completed with the strains that the run with the patch reaches within the measured displacement.
    """
    if diagnosis.levels.bent:
        return _bending_proof(diagnosis, finalist, runner)
    loaded, notes = diagnosed_case(task, diagnosis.levels, folder)
    plain = _run(loaded, folder.path / BASE, None, advance)
    patched = _run(loaded, folder.path / PATCHED, patch, advance)
    strain = strains_up_to(float(diagnosis.points.displacement.max()), patched.report)
    full = patch_of(task, diagnosis, finalist, sha256=loaded.sha256, strain=strain)
    folder.write(patch.name, patch_text(task, full, finalist, folder=folder.path, proven=patch.name == PATCH))
    ids, flat, added = finalist.contender.ids, record_of(plain.results), record_of(patched.results)
    own = _by_simulator(diagnosis, found_effects(diagnosis, ids, finalist.contender.evidence), runner)
    change, beyond = _change(diagnosis, RunPair(flat, added), own), None
    runs = {"the ordinary run": flat, "the run with the patch": added} | _named(own, "the effect")
    part = beyond_split(finalist)
    if part is not None:
        found = found_effects(diagnosis, ids, part.fit, at_mean=True)
        kept = _run_held_out(loaded, effects_of(found), folder, advance)
        own = _by_simulator(diagnosis, found, runner)
        beyond = _change(diagnosis, RunPair(flat, kept), own)
        early = "the effect as fitted without the held-out displacements"
        runs |= {f"the run with {early}": kept} | _named(own, early)
    proof = _prove(diagnosis, change, beyond)
    if patched.exit_code == NoEquilibrium.exit_code:
        notes = (*notes, f"with the patch the ordinary run finds no equilibrium beyond {_at(added, diagnosis)}")
    lost = lost_points(proof, runs, diagnosis.points.unit)
    notes = (*notes, lost) if lost else notes
    return Proven(proof, plain, patched, _as_run(diagnosis, flat, added), notes, lost)


def _bending_proof(diagnosis: Diagnosis, finalist: Finalist, runner: Runner) -> Proven:
    """Return the gaps of a bending test, which the ordinary command does not make: by the diagnosis' own simulator."""
    plain = diagnosis.base_runs.coarse
    ids, part = finalist.contender.ids, beyond_split(finalist)

    def change(found: Sequence[Found]) -> tuple[Record, Array]:
        own = _by_simulator(diagnosis, found, runner)
        return own[0], _change(diagnosis, RunPair(plain, own[0]), own)

    added, fitted = change(found_effects(diagnosis, ids, finalist.contender.evidence))
    beyond = None if part is None else change(found_effects(diagnosis, ids, part.fit, at_mean=True))[1]
    proof = _prove(diagnosis, fitted, beyond)
    return Proven(proof, None, None, _as_run(diagnosis, plain, added), (BENT,))


def _at(run: Record, diagnosis: Diagnosis) -> str:
    return f"{load_text(run.reach, diagnosis.points.unit)} {diagnosis.points.unit}"


def lost_points(proof: Proof, runs: Mapping[str, Record], unit: str = "mm") -> str:
    """Say how many measured points are in no gap because a run that the gaps need ends before them; empty if none."""
    lost = ~np.isfinite(proof.predictions[EFFECT])
    if not lost.any():
        return ""
    ends = [
        f"{words} finds no equilibrium beyond {load_text(run.reach, unit)} {unit}"
        for words, run in runs.items()
        if not run.completed
    ]
    return (
        f"{np.count_nonzero(lost)} of {len(lost)} measured points, {np.count_nonzero(lost & proof.held_out)} of them "
        f"held out, are in no gap: {', '.join(ends)}"
    )


def _by_simulator(diagnosis: Diagnosis, found: Sequence[Found], runner: Runner) -> list[Record]:
    """Return the runs with the effect by the diagnosis' own simulator: on the case's lattice and on the finest."""
    specs, laws, levels = [item.spec for item in found], diagnosis.setting.base.laws, diagnosis.levels
    return runner([levels.request(laws, specs), levels.request(laws, specs, coarsening=levels.gate[-1])])


def _named(own: Sequence[Record], words: str) -> dict[str, Record]:
    coarse, finest = own
    return {f"without wires the run with {words}": coarse, f"on the finest lattice the run with {words}": finest}


def _change(diagnosis: Diagnosis, ordinary: RunPair, own: Sequence[Record]) -> Array:
    """Return the change (N,) by the effect in the ordinary runs, less the lattice error of each."""
    runs, (coarse, finest) = diagnosis.base_runs, own
    return change_by_runs(
        diagnosis.bench, ordinary, coarse=RunPair(runs.coarse, coarse), finest=RunPair(runs.finer, finest)
    )


def observed_states(task: DiagnosisTask, proven: Proven) -> dict[str, Any] | None:
    """Return observed wire states beside those of both runs; None without observations, wires or runs."""
    if task.measured.wires is None or task.loaded.case.wires is None or proven.base is None or proven.patched is None:
        return None
    from etextile.studies.run.observed import observed_in

    runs = {"without": proven.base.folder, "with": proven.patched.folder}
    return {name: observed_in(path, task.measured.file).as_dict() for name, path in runs.items()}


def unseen_states(task: DiagnosisTask, proven: Proven) -> str:
    """Say why observed wire states are not compared; empty when they are, or when there are none."""
    if task.measured.wires is None:
        return ""
    if task.loaded.case.wires is None:
        return NO_WIRES
    if proven.patched is None:
        return "observed wire states are not compared without a run with an effect; etextile compare does that"
    return ""


def case_to_run(task: DiagnosisTask, folder: Folder) -> Case:
    """Return the case that a patch belongs to: on the fabric from the coupons and as far as was measured."""
    return diagnosed_case(task, measured_levels(task), folder)[0].case


def diagnosed_case(task: DiagnosisTask, levels: Levels, folder: Folder) -> tuple[LoadedCase, tuple[str, ...]]:
    """Return the case as it was diagnosed: on the coupons' fabric (written to the folder), as far as was measured."""
    case = task.loaded.case
    notes: tuple[str, ...] = ()
    if task.fabric is not None:
        path = folder.write(FABRIC, f"{HEADER}\n{dump_fabric(task.fabric)}")
        case = case.model_copy(update={"fabric": case.fabric.model_copy(update={"set": str(path.resolve())})})
    motion = longer_motion(case, levels)
    if motion:
        case = case.model_copy(update={"motion": case.motion.model_copy(update=motion)})
        notes = (
            f"the ordinary run goes straight to {case.motion.reach:g} {case.motion.unit} in {case.motion.steps} steps",
        )
    return replace(as_loaded(case), path=task.loaded.path, overrides=task.loaded.overrides), notes


def _run(loaded: LoadedCase, path: Path, patch: Path | None, advance: Advance) -> Run:
    total = loaded.case.motion.travel
    words = "the ordinary run" if patch is None else "the run with the patch"
    return run(
        loaded,
        path,
        force=True,
        patch=patch,
        watch=lambda item: advance(item.displacement_mm, total, words),
    )


def _run_held_out(loaded: LoadedCase, effects: Sequence[Effect], folder: Folder, advance: Advance) -> Record:
    """Return the ordinary run with the effect's mean as fitted up to the split.

    The posterior mean predicts better than the likeliest point where a part of the data leaves a parameter open.
    """
    case = loaded.case.model_copy(update={"effects": (*loaded.case.effects, *effects)})
    total = case.motion.travel
    done = simulate(
        as_loaded(case), folder.path / HELD_OUT, resume=False, force=True, seed=0,
        watch=lambda item: advance(item.displacement_mm, total, "the run with held-out displacements"),
    )  # fmt: skip
    return record_of(done.results)


def beyond_split(finalist: Finalist) -> HeldOut | None:
    """Return the held-out score on displacements beyond the split."""
    return next((part for part in finalist.held_out if is_beyond(part.what)), None)


def _prove(diagnosis: Diagnosis, change: Array | None, beyond: Array | None) -> Proof:
    free = diagnosis.free_columns if diagnosis.scan.detected else None
    return prove(
        diagnosis.bench, diagnosis.lattice.value, diagnosis.base_runs.finer, split=diagnosis.split,
        free_columns=free, fitted_effect=change, held_out_effect=beyond,
    )  # fmt: skip


def _as_run(diagnosis: Diagnosis, plain: Record, patched: Record) -> tuple[dict[str, Any], ...]:
    """Return the gap of the two runs as they are, over the whole measurement."""
    from etextile.diagnose.decide.gap import gaps
    from etextile.diagnose.decide.proof import raw_deviation, rest_values

    raw, bench = diagnosis.bench.raw, diagnosis.bench
    found = gaps(
        raw, observe(plain, raw), observe(patched, raw), deviation=raw_deviation(bench),
        rest=rest_values(bench, diagnosis.base_runs.finer), held_out=np.zeros(len(raw), dtype=bool),
    )  # fmt: skip
    return tuple(
        {"channel": gap.channel, "before_percent": gap.before_percent, "after_percent": gap.after_percent}
        for gap in found
    )


def record_of(results: Results) -> Record:
    """Return a result file as a record, the flat start or the straight limb included, wires left out."""
    fabric = results.grid.family < len(FABRIC_FAMILIES)
    count = int(results.grid.cells[fabric].max()) + 1
    flat = results.grid.reference[:count]
    x, y, shape = places(flat)
    case = stored_case(results.case.effective, str(results.path))
    worn = build(case.model_copy(update={"wires": None, "effects": ()})).worn if case.worn else None
    if worn is not None:
        return _worn_record(results, worn, flat)
    steps = [flat, *(results.points(step)[:count] for step in range(results.steps))]
    return Record(
        x=x,
        y=y,
        symmetry=results.grid.symmetry,
        displacement=np.concatenate([[0.0], results.displacement_mm]),
        force=np.concatenate([[0.0], results.curves.punch_force_N]),
        positions=np.array([points.reshape(shape) for points in steps]),
        peaks=np.zeros((results.steps + 1, len(PEAKS))),
        completed=results.completed,
        angle=results.grid.warp_angle_deg,
    )


def _worn_record(results: Results, worn: Worn, flat: Array) -> Record:
    """Return a result file of a worn piece as a record.

    The straight limb is given no moment: the fabric lies evenly around it, but for the tip, whose part (a tenth of the
    moment at 3 degrees under the kneecap of a tight sleeve, nothing at an elbow) matters before the first step.
    """
    x, y, shape = places(flat)
    bends = np.flatnonzero(results.displacement_mm > 0.0)
    straight = np.flatnonzero(results.displacement_mm <= 0.0)
    start = results.points(int(straight[-1]))[: len(flat)] if len(straight) else worn.piece.places
    positions = np.array([start, *(results.points(int(step))[: len(flat)] for step in bends)])
    angle, moment = results.displacement_mm[bends], np.degrees(results.curves.punch_force_N[bends])
    angle = np.concatenate([[0.0], angle])
    return Record(
        x=x,
        y=y,
        symmetry=results.grid.symmetry,
        displacement=angle,
        force=np.concatenate([[0.0], moment]),
        positions=positions.reshape(-1, *shape),
        peaks=np.zeros((len(angle), len(PEAKS))),
        completed=results.completed,
        angle=results.grid.warp_angle_deg,
        slip=slips(worn.motion, positions, angle).reshape(-1, *shape[:2]),
    )
