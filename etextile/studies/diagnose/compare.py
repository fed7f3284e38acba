"""The gap alone: how far a case is from a measurement, where it begins, and nothing about why."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from etextile.diagnose.data.measured import Measurements
from etextile.diagnose.data.observe import Record
from etextile.diagnose.data.points import gather
from etextile.diagnose.data.pulled import ClampForce
from etextile.diagnose.data.punched import PunchForce
from etextile.diagnose.decide.gap import gap_percent
from etextile.diagnose.decide.localise import Scan, scan
from etextile.diagnose.decide.proof import base_gap, model_deviation, raw_deviation, to_raw
from etextile.diagnose.decide.where import GapPlace, agreeing, headline, places
from etextile.diagnose.infer.whitened import Workbench, scale
from etextile.diagnose.predict.run_tables import Levels
from etextile.diagnose.predict.simulate import Runner
from etextile.diagnose.setting import Prepared
from etextile.diagnose.workflow import prepare
from etextile.environment import cores
from etextile.errors import BadInput, NoEquilibrium, Problem
from etextile.identify.coupon import loading_curve
from etextile.identify.result import DIRECTION_OF, FAMILY_OF
from etextile.identify.segments import split
from etextile.studies.calibrate.compare import compare_surface, is_surface
from etextile.studies.cases import AnyCase
from etextile.studies.diagnose.curves import ComparedCurves as Shown
from etextile.studies.diagnose.curves import Predicted, panels
from etextile.studies.diagnose.folder import Folder, claim
from etextile.studies.diagnose.patch import longer_motion
from etextile.studies.diagnose.proof import NO_WIRES, diagnosed_case
from etextile.studies.diagnose.question import AnyMeasured, Listener, Silence, question
from etextile.studies.diagnose.setting import POSITIONS, DiagnosisTask, assemble
from etextile.studies.identify.identify import named_laws
from etextile.units import load_text
from loadcases.fabric import load_fabric
from loadcases.reader import LoadedCase, as_loaded


Tell = Callable[[str, str], None]
RUN = "run"
"""Folder of the ordinary run whose wires are compared with observed ones."""
FORCE_RATIO = (0.05, 20.0)
"""Measured over simulated force at the measured peak: beyond, one of the two is in another unit."""
FILES = ("compare.json", "compare.png", RUN)
"""What compare writes."""


@dataclass(frozen=True)
class Compared:
    """What compare leaves: its folder, and data as in compare.json."""

    folder: Path
    data: dict[str, Any]


def compare(
    case: AnyCase,
    measured: AnyMeasured,
    folder: str | Path,
    *,
    own_fabric: bool = False,
    jobs: int | None = None,
    seed: int = 0,
    force: bool = False,
    listener: Listener | None = None,
) -> Compared:
    """Say how far a case is from a measurement, per channel, and where it begins; write compare.json and a picture.

    `own_fabric`: keep the case's fabric in spite of a tensile channel; `jobs`: worker processes, as many as cores by
    default; `force`: overwrite files of another case or measurement. Raises NoEquilibrium when the case finds none.
    """
    loaded, found = question(case, measured)
    if is_surface(loaded, found):
        return Compared(Path(folder), compare_surface(loaded, found, Path(folder), force=force, wires=_worn_wires))
    with loaded.locating():
        task = assemble(loaded, found, name_effects=False, own_fabric=own_fabric, seed=seed)
    place, show = claim(Path(folder), task, FILES, verb="compare", force=force), listener or Silence()
    with closing(Runner(task.simulator, place.cache, workers=jobs or cores(), watch=show.watch)) as runner:
        return compare_task(task, place, runner, tell=show.tell)


def compare_task(task: DiagnosisTask, folder: Folder, runner: Runner, *, tell: Tell) -> Compared:
    """Simulate, compare, write compare.json and the picture; raises NoEquilibrium when the base finds none."""
    begun = time.perf_counter()
    there = any(getattr(task.measured, name) for name in POSITIONS)
    data = _channels(task, folder, runner, tell) if there else dict(NOTHING)
    data["tensile"] = tensile_rows(task)
    data["wires"], notes = _wires(task, folder, tell)
    data["notes"] = [*data["notes"], *notes]
    data = {
        "case": {"title": task.loaded.case.title, "sha256": task.loaded.sha256},
        "measured": {"title": task.measured.title, "channels": list(task.measured.channels)},
        "fabric": fabric_words(task),
        "restrictions": list(task.restrictions),
        **data,
        "simulations": runner.count,
        "wall_s": round(time.perf_counter() - begun, 1),
    }
    folder.write("compare.json", json.dumps(data, indent=2, ensure_ascii=False) + "\n")
    return Compared(folder.path, data)


def _channels(task: DiagnosisTask, folder: Folder, runner: Runner, tell: Tell) -> dict[str, Any]:
    """Return the gap of all channels that a simulation predicts."""
    from viz.diagnosis_plots import save_panels

    require_base(task, runner)
    ready = prepare(task.setting, runner, tell)
    bench, raw = ready.bench, ready.bench.raw
    found = find_gap(bench, seed=task.setting.seed)
    spots = places(bench, found)
    base = ready.lattice.value
    before = Predicted(base, to_raw(bench, model_deviation(bench)))
    drawn = panels(raw, Shown(before, raw_deviation(bench)), places=spots)
    save_panels(drawn, folder.path / "compare.png", title=f"{task.loaded.case.title}: {task.measured.title}")
    return {
        "agree": not found.detected,
        "p_value": found.p_value,
        "sentence": headline(spots, agreeing(bench, spots)),
        "gap": gap_rows(ready),
        "where": [place_row(item, raw.unit) for item in spots],
        "load_unit": raw.unit,
        "notes": list(raw.cuts),
    }


NOTHING: dict[str, Any] = {"agree": None, "p_value": None, "sentence": "", "gap": [], "where": [], "notes": []}
"""What is said when no channel of the punch test was measured."""


def _wires(task: DiagnosisTask, folder: Folder, tell: Tell) -> tuple[dict[str, Any] | None, tuple[str, ...]]:
    """Return observed wire states beside those of an ordinary run, and notes; None without observations or wires."""
    observed = task.measured.wires
    if observed is None:
        return None, ()
    if task.loaded.case.wires is None:
        return None, (NO_WIRES,)
    from etextile.studies.run.observed import observed_in
    from etextile.studies.run.run import run

    levels = Levels.of(task.setting.coarsening, float(observed.displacement.max()), unit=observed.unit)
    loaded, notes = diagnosed_case(task, levels, Folder(folder.path / RUN, folder.key))
    tell("wires", "an ordinary run for the wires")
    run(loaded, folder.path / RUN, force=True)
    return observed_in(folder.path / RUN, task.measured.file).as_dict(), notes


def _worn_wires(loaded: LoadedCase, measured: Measurements, folder: Folder) -> dict[str, Any] | None:
    """Return observed wire states beside those of an ordinary run that goes as far; None for a case without wires."""
    observed, case = measured.wires, loaded.case
    if observed is None or case.wires is None:
        return None
    from etextile.studies.run.observed import observed_in
    from etextile.studies.run.run import run

    levels = Levels.of(float(case.fabric.coarsening), float(observed.displacement.max()), unit=observed.unit)
    motion = case.motion.model_copy(update=longer_motion(case, levels))
    longer = replace(as_loaded(case.model_copy(update={"motion": motion})), path=loaded.path)
    run(longer, folder.path / RUN, force=True)
    return observed_in(folder.path / RUN, measured.file).as_dict()


def find_gap(bench: Workbench, *, seed: int) -> Scan:
    """Scan all channels for a gap that noise does not explain."""
    whiteners = [sample.whiten for sample in bench.samples]
    weights = np.array([item.weight for item in bench.scatters])
    return scan(bench.points, bench.residual, whiteners, weights, size=scale(bench), seed=seed)


def gap_rows(ready: Prepared) -> list[dict[str, Any]]:
    """Return the size of the gap per channel."""
    raw = ready.bench.raw
    return [
        {
            "channel": gap.channel,
            "percent": gap.before_percent,
            "chi": gap.before_chi,
            "points": int(raw.of(gap.channel).sum()),
            f"up_to_{raw.unit}": float(raw.displacement[raw.of(gap.channel)].max()),
        }
        for gap in base_gap(ready.bench, ready.lattice.value, ready.runs.finer)
    ]


def tensile_rows(task: DiagnosisTask) -> list[dict[str, Any]]:
    """Return per direction how far the law of the fabric is from the loading curves of the coupons, as recorded."""
    fabric = task.fabric or load_fabric(task.loaded.case.fabric.set)
    laws, rows = named_laws(fabric, ""), []
    for direction, curves in task.measured.tensile.items():
        parts = [split(curve) for curve in curves]
        if not parts:
            continue
        named = laws[FAMILY_OF[direction]]
        strain, stress = (np.concatenate([getattr(part, name) for part in parts]) for name in ("strain", "stress"))
        predicted = loading_curve(named.law, np.log1p(strain)).stress / named.area_ratio
        rows.append({
            "direction": direction, "percent": gap_percent(stress - predicted, stress), "specimens": len(parts),
            "up_to_strain": float(strain.max()),
        })  # fmt: skip
    return rows


def place_row(item: GapPlace, unit: str) -> dict[str, Any]:
    """Return where a gap is, as in diagnosis.json; the onset is named with the unit of the load."""
    return {
        "channel": item.channel,
        "quantity": item.quantity,
        f"onset_{unit}": item.onset.at,
        "onset_low": item.onset.low,
        "onset_high": item.onset.high,
        "gap_percent": item.gap_percent,
        "sentence": item.sentence,
    }


def fabric_words(task: DiagnosisTask) -> str:
    """Return where the fabric's parameters come from."""
    if task.fabric is None:
        return f"the case's own, {Path(task.loaded.case.fabric.set).stem}"
    *first, last = [name for name in DIRECTION_OF.values() if task.measured.tensile.get(name)]
    return f"identified from the {', '.join(first)}{' and ' if first else ''}{last} coupons"


def require_base(task: DiagnosisTask, runner: Runner) -> None:
    """Raise NoEquilibrium when the case itself cannot be simulated as far as it was measured.

    Raises BadInput when the forces of the two have nothing to do with each other.
    """
    points = gather(task.measured)
    reach, unit = float(points.displacement.max()), points.unit
    record = runner([Levels.for_points(task.setting.coarsening, points).request(task.setting.base.laws)])[0]
    if not record.completed:
        raise NoEquilibrium(
            f"the case finds no equilibrium beyond {load_text(record.reach, unit)} {unit}, but was measured up to "
            f"{load_text(reach, unit)} {unit}; "
            "cut the measurement there, or make the case run (etextile run) before it is diagnosed"
        )
    problems = [*_other_forces((*task.measured.punch_force, *task.measured.clamp_force), record)]
    if problems:
        raise BadInput(problems)


def _other_forces(curves: Sequence[PunchForce | ClampForce], record: Record) -> Iterator[Problem]:
    """Yield the specimens whose peak force is too far from the simulated one for any effect to explain."""
    for curve in curves:
        row = int(np.abs(curve.force).argmax())
        at = min(float(curve.displacement[row]), record.reach)
        simulated = float(np.interp(at, record.displacement, record.force))
        ratio = float(curve.force[row]) / simulated if simulated > 0.0 else 1.0
        if not FORCE_RATIO[0] <= ratio <= FORCE_RATIO[1]:
            message = (
                f"peaks at {curve.force[row]:.4g}, where the case takes {simulated:.4g}; "
                f"{'kN?' if ratio < 1.0 else 'mN? gf?'} convert to N, displacements to mm, or check the fabric of the "
                "case and the stresses of the coupons"
            )
            yield Problem(message, file=curve.file, line=curve.line(row), key="force_N")
