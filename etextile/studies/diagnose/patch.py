"""The patch file of a diagnosis: the effect with its parameters and intervals, ready for `etextile run --patch`."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from etextile.diagnose.data.points import gather
from etextile.diagnose.decide.verdict import Finalist
from etextile.diagnose.infer.fit import Evidence
from etextile.diagnose.predict.run_tables import Levels, specs_at
from etextile.diagnose.predict.simulate import EffectSpec
from etextile.diagnose.predict.table import EffectTable, each_with_its_own
from etextile.diagnose.workflow import Diagnosis
from etextile.effects.base import Card
from etextile.studies.diagnose.setting import DiagnosisTask
from etextile.types import Array
from etextile.units import probability
from loadcases.patch import FABRIC_BESIDE, Interval, Patch, PatchedCase, Strains, Validity, dump_patch
from loadcases.schema import Case
from loadcases.schema_parts import Effect
from wires.axis import axis_of


PATCH, PROVISIONAL, FABRIC = "patch.yaml", "provisional.yaml", FABRIC_BESIDE
"""A named effect; the best of several, which is not proven; the fabric identified from the coupons."""
DIGITS = 5


@dataclass(frozen=True)
class Found:
    """An effect as it was found: its specification, and the 95 % intervals of the parameters that were searched."""

    spec: EffectSpec
    card: Card
    intervals: Mapping[str, tuple[float, float]]

    def written(self) -> dict[str, tuple[float, float, float]]:
        """Return value, low and high of every parameter as files tell them: rounded, the interval holds the value."""
        found = {}
        for name, value in self.spec.parameters:
            low, high = self.intervals.get(name, (value, value))
            told = _rounded(value)
            found[name] = (told, min(_rounded(low), told), max(_rounded(high), told))
        return found


def found_effects(
    diagnosis: Diagnosis, ids: Sequence[str], evidence: Evidence, *, at_mean: bool = False
) -> tuple[Found, ...]:
    """Return the effects of a hypothesis at its likeliest point (or posterior mean), with posterior intervals."""
    tables, point = [diagnosis.tables[name] for name in ids], evidence.mean if at_mean else evidence.best
    specs = specs_at(tables, diagnosis.setting.candidates, point)
    own = each_with_its_own(tables, np.arange(len(point)))
    return tuple(
        Found(spec, table.grid.card, _intervals(table, evidence, dimensions))
        for spec, (table, dimensions) in zip(specs, own, strict=True)
    )


def _intervals(table: EffectTable, evidence: Evidence, dimensions: Array) -> dict[str, tuple[float, float]]:
    """Return the 95 % intervals of an effect's searched parameters; `dimensions`: where they stand in the evidence."""
    found = {}
    for axis, dimension in zip(table.grid.axes, dimensions, strict=True):
        _, low, high = evidence.interval(dimension)
        one, other = sorted((float(axis.to_value(low)), float(axis.to_value(high))))
        found[axis.parameter.name] = (one, other)
    return found


def effects_of(found: Sequence[Found]) -> tuple[Effect, ...]:
    """Return the effects as a case or a patch lists them; a user's file is named by its full path."""
    effects = []
    for item in found:
        file = {"file": str(Path(item.spec.file).resolve())} if item.spec.file else {}
        numbers = {name: value for name, (value, _, _) in item.written().items()}
        effects.append(Effect.model_validate({"id": item.spec.id, **file, **numbers}))
    return tuple(effects)


def patch_of(
    task: DiagnosisTask, diagnosis: Diagnosis, finalist: Finalist, *, sha256: str, strain: Strains | None = None
) -> Patch:
    """Return the patch of a hypothesis.

    `sha256`: hash of the case as it was diagnosed; `strain`: largest strains with the patch, once it has been run.
    """
    ids = finalist.contender.ids
    found = found_effects(diagnosis, ids, finalist.contender.evidence)
    intervals = [
        Interval(effect=item.spec.id, parameter=name, low=low, high=high, unit=item.card.parameter(name).unit)
        for item in found
        for name, (_, low, high) in item.written().items()
        if name in item.intervals
    ]
    return Patch(
        schema_version=1,
        title=f"{' and '.join(ids)}, from {task.measured.title}",
        base=PatchedCase(title=task.loaded.case.title, sha256=sha256),
        effects=effects_of(found),
        intervals=tuple(intervals),
        valid=Validity(displacement=(0.0, _rounded(float(diagnosis.points.displacement.max()))), strain=strain),
    )


def strains_up_to(reach: float, report: Mapping[str, Any]) -> Strains:
    """Return the largest engineering strain of every family up to a load, from the report of a run."""
    displacement = [0.0, *axis_of(report).values(report)]
    found = {}
    for name in Strains.model_fields:
        largest = np.maximum.accumulate([0.0, *report["strain"][f"{name}_max"]])
        found[name] = _rounded(float(np.interp(reach, displacement, largest)))
    return Strains(**found)


def patch_text(task: DiagnosisTask, patch: Patch, finalist: Finalist, *, folder: Path, proven: bool) -> str:
    """Return the file's text: how to use it, how sure it is, and the patch."""
    name = PATCH if proven else PROVISIONAL
    lines = [f"# Written by etextile diagnose, probability {probability(finalist.probability)}. To use it:"]
    lines.append(f"#   {run_command(task, folder / name)}")
    if not proven:
        lines.insert(0, "# NOT PROVEN: the best of several explanations that the measurement does not tell apart.")
    return "\n".join(lines) + "\n" + dump_patch(patch)


def measured_levels(task: DiagnosisTask) -> Levels:
    """Return lattices and travel of the diagnosis' own runs."""
    return Levels.for_points(task.setting.coarsening, gather(task.measured))


def longer_motion(case: Case, levels: Levels) -> dict[str, float | int | None]:
    """Return the values of `motion` that have to change for a case to go straight as far as was measured."""
    motion = case.motion
    straight = motion.path is None or bool(np.all(np.diff((0.0, *motion.path)) > 0.0))
    if motion.reach >= levels.total and straight:
        return {}
    wanted = motion.straight(max(levels.total, motion.reach), max(motion.steps, levels.steps))
    return {name: value for name, value in wanted.items() if value != getattr(motion, name)}


def run_command(task: DiagnosisTask, patch: Path) -> str:
    """Return the ordinary command that adds the patch to the case as it was diagnosed."""
    path = task.loaded.path
    shipped = path is not None and path.parent == Path(str(_shipped_root()))
    case = path.stem if path is not None and shipped else str(path or "CASE")
    ours = {
        f"motion.{name}": "null" if value is None else f"{value:g}"
        for name, value in longer_motion(task.loaded.case, measured_levels(task)).items()
    }
    if task.fabric is not None:
        ours["fabric.set"] = str(patch.parent / FABRIC)
    theirs = [item for item in task.loaded.overrides if item.partition("=")[0].strip() not in ours]
    settings = [f"--set {_quoted(item)}" for item in (*theirs, *(f"{key}={value}" for key, value in ours.items()))]
    return " ".join(["etextile run", _quoted(case), *settings, "--patch", _quoted(str(patch))])


def _shipped_root() -> Path:
    from loadcases.catalogue import ROOT

    return ROOT


def _quoted(text: str) -> str:
    return json.dumps(text) if any(letter in text for letter in " '\"$&;()[]{}") else text


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
