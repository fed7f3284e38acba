"""A diagnosis from a case and measurements to files: stages, patch, proof, report. All that the verb does."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from etextile.diagnose.decide.verdict import Answer
from etextile.diagnose.predict.simulate import Runner
from etextile.diagnose.workflow import Diagnosis, with_next
from etextile.diagnose.workflow import diagnose as find_effect
from etextile.environment import cores
from etextile.studies.cases import AnyCase
from etextile.studies.diagnose.compare import require_base
from etextile.studies.diagnose.drawing import draw, field_maps
from etextile.studies.diagnose.folder import Folder, claim
from etextile.studies.diagnose.next_folder import folder_of, next_data, next_words, write_folder
from etextile.studies.diagnose.next_measurement import next_measurement
from etextile.studies.diagnose.patch import FABRIC, PATCH, PROVISIONAL, patch_of, patch_text, run_command
from etextile.studies.diagnose.plan import plan
from etextile.studies.diagnose.proof import (
    BASE,
    HELD_OUT,
    PATCHED,
    Proven,
    case_to_run,
    prove_patch,
    unseen_states,
    without_effect,
)
from etextile.studies.diagnose.question import AnyMeasured, Listener, Silence, question
from etextile.studies.diagnose.report import report_of
from etextile.studies.diagnose.rounds import go_on
from etextile.studies.diagnose.setting import DiagnosisTask, assemble
from etextile.studies.run.outcome import Run
from loadcases.reader import case_sha256


FILES = (
    "diagnosis.json", "report.html", PATCH, PROVISIONAL, FABRIC, "gap.png", "evidence.png", BASE, PATCHED, HELD_OUT,
)  # fmt: skip
"""What a diagnosis writes, files and folders of runs; `claim` guards them."""


@dataclass(frozen=True)
class DiagnosisOutcome:
    """What a diagnosis leaves: folder, report as in diagnosis.json, the diagnosis itself, what casts doubt on it."""

    folder: Path
    data: dict[str, Any]
    diagnosis: Diagnosis
    doubts: tuple[str, ...]

    @property
    def exit_code(self) -> int:
        """Code 4 where the lattice error forbids a name, a trust limit was passed, or a run of the proof broke off."""
        return 4 if self.doubts else 0


def diagnose(
    case: AnyCase,
    measured: AnyMeasured,
    folder: str | Path,
    *,
    effects: Sequence[str | Path] = (),
    among: Sequence[str] = (),
    own_fabric: bool = False,
    jobs: int | None = None,
    seed: int = 0,
    force: bool = False,
    listener: Listener | None = None,
) -> DiagnosisOutcome:
    """Find where simulation and measurement part and name the missing effect; write diagnosis.json, page and patch.

    `effects`: Python files with effects of your own; `among`: names to choose from, all when empty; `own_fabric`: keep
    the case's fabric in spite of a tensile channel; `jobs`: worker processes, as many as cores by default; `force`:
    overwrite files of another case or measurement. Runs in the folder's cache are used again.
    """
    loaded, found = question(case, measured)
    with loaded.locating():
        task = assemble(
            loaded, found, effects=[Path(item) for item in effects], among=among, own_fabric=own_fabric, seed=seed
        )  # fmt: skip
    place, show = claim(Path(folder), task, FILES, verb="diagnose", force=force), listener or Silence()
    with closing(Runner(task.simulator, place.cache, workers=jobs or cores(), watch=show.watch)) as runner:
        return diagnose_task(task, place, runner, show=show)


def diagnose_task(task: DiagnosisTask, folder: Folder, runner: Runner, *, show: Listener) -> DiagnosisOutcome:
    """Diagnose, prove, write all files.

    Exit codes: 0, 4 when the lattice or a trust limit casts doubt.

    Raises NoEquilibrium when the case itself cannot be simulated as far as it was measured.
    """
    begun = time.perf_counter()
    require_base(task, runner)
    diagnosis = find_effect(task.setting, runner, show.tell)
    told = runner.count
    diagnosis = go_on(task, diagnosis, runner, show)
    coming = plan(task, diagnosis, runner)
    place = folder_of(diagnosis, folder.path)
    write_folder(coming, task, diagnosis, place)
    diagnosis = with_next(diagnosis, next_words(coming) or next_measurement(diagnosis))
    if diagnosis.next_measurement:
        show.tell("next", diagnosis.next_measurement)
    name, patch, proven = _patched(task, diagnosis, folder, runner, show)
    diagnosis = replace(diagnosis, simulations=diagnosis.simulations + runner.count - told)
    data = report_of(
        task,
        diagnosis,
        proven,
        patch=PATCH if name == PATCH else None,
        provisional=PROVISIONAL if name == PROVISIONAL else None,
        command="" if patch is None else run_command(task, patch),
        notes=_notes(task, diagnosis, proven),
        coming=next_data(coming, place.name),
        wall_s=time.perf_counter() - begun,
    )
    write(data, diagnosis, proven, folder)
    return DiagnosisOutcome(folder.path, data, diagnosis, _doubts(diagnosis, proven))


def _patched(
    task: DiagnosisTask, diagnosis: Diagnosis, folder: Folder, runner: Runner, show: Listener
) -> tuple[str, Path | None, Proven]:
    """Write the patch of a named effect (provisional for the best of several) and prove it by the ordinary command."""
    verdict = diagnosis.verdict
    if verdict.best is None or verdict.kind not in (Answer.NAMED, Answer.AMBIGUOUS):
        return "", None, without_effect(diagnosis)
    name = PATCH if verdict.kind is Answer.NAMED else PROVISIONAL
    found = patch_of(task, diagnosis, verdict.best, sha256=case_sha256(case_to_run(task, folder)))
    text = patch_text(task, found, verdict.best, folder=folder.path, proven=name == PATCH)
    path = folder.write(name, text)
    proven = prove_patch(task, diagnosis, verdict.best, path, folder=folder, runner=runner, advance=show.advance)
    show.tell("prove", _gap_words(proven))
    return name, path, proven


def _gap_words(proven: Proven) -> str:
    """Return the gaps of the proof in one line."""
    return "; ".join(
        f"{gap.channel.replace('_', ' ')} {gap.part.replace('_', ' ')} {gap.before_percent:.1f} % to "
        f"{gap.after_percent:.1f} %"
        for gap in proven.proof.gaps
    )


def _notes(task: DiagnosisTask, diagnosis: Diagnosis, proven: Proven) -> tuple[str, ...]:
    """Return what a reader has to know beside the verdict."""
    unseen = unseen_states(task, proven)
    return (
        *diagnosis.opened,
        *diagnosis.points.cuts,
        *proven.notes,
        *_passed_limits(proven),
        *([unseen] if unseen else []),
    )


def _doubts(diagnosis: Diagnosis, proven: Proven) -> tuple[str, ...]:
    """Return, as sentences, why a diagnosis ends with code 4; nothing for 0."""
    lattice = ["the lattice is too coarse to name an effect"] if diagnosis.verdict.lattice_doubt else []
    lost = [proven.lost] if proven.lost else []
    return (*lattice, *lost, *_passed_limits(proven), *_broken_off(proven))


def _passed_limits(proven: Proven) -> list[str]:
    """Return the trust limits that the ordinary runs passed, as sentences."""
    found = []
    for words, outcome in _ordinary(proven):
        if outcome.exit_code == 4:
            limits = "; ".join(str(item["sentence"]) for item in outcome.report["trust"]["limits"])
            found.append(f"the ordinary run {words} the patch passed a trust limit: {limits}")
    return found


def _broken_off(proven: Proven) -> list[str]:
    return [
        f"the ordinary run {words} the patch ended with code {outcome.exit_code}"
        for words, outcome in _ordinary(proven)
        if outcome.exit_code not in (0, 4)
    ]


def _ordinary(proven: Proven) -> list[tuple[str, Run]]:
    """Return the ordinary runs that were made, named by what stands before "the patch"."""
    pairs = (("without", proven.base), ("with", proven.patched))
    return [(words, outcome) for words, outcome in pairs if outcome is not None]


def write(data: Mapping[str, Any], diagnosis: Diagnosis, proven: Proven, folder: Folder) -> None:
    """Write diagnosis.json, the pictures and the page."""
    from viz.diagnosis_html import render_diagnosis_html

    folder.write("diagnosis.json", json.dumps(data, indent=2, ensure_ascii=False, default=float) + "\n")
    panels = draw(data, diagnosis, proven, folder.path)
    folder.write("report.html", render_diagnosis_html(data, panels=panels, runs=field_maps(proven)))
