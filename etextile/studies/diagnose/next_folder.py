"""The folder of the next measurement: a measured.yaml, files with headers to be filled, and what is foretold in them.

When the files are filled, `etextile diagnose CASE --measured FOLDER -o SAME_OUTPUT` goes on from the diagnosis that
asked for them; its runs are kept and are not made again.
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np

from etextile.diagnose.workflow import Diagnosis
from etextile.files import write_whole
from etextile.studies.diagnose.catalogue import UNLOADING
from etextile.studies.diagnose.plan import MeasurementPlan, Option, files_of, noise_of
from etextile.studies.diagnose.setting import DiagnosisTask
from etextile.vocabulary import CLAMP, EDGE, FORCE, STRAIN


NAME = "next"
PREDICTIONS = "predictions.csv"
HEADERS = {
    FORCE: "displacement_mm,force_N",
    UNLOADING: "displacement_mm,force_N",
    EDGE: "displacement_mm,warp0_mm,warp_mm,weft_mm,height_mm",
    STRAIN: "displacement_mm,warp0_mm,weft0_mm,strain_warp,strain_weft",
    CLAMP: "displacement_mm,weft0_mm,slip_mm",
}
UNITS = {FORCE: " N", UNLOADING: " N", EDGE: " mm", CLAMP: " mm", STRAIN: ""}
BAND = 1.96


def next_data(plan: MeasurementPlan, folder: str) -> dict[str, Any] | None:
    """Return the plan as it stands in diagnosis.json, `folder` beside it; None without one."""
    best = plan.best
    if best is None:
        return None
    return {
        "test": best.trial.id,
        "channel": best.trial.channel,
        "words": best.trial.words,
        "cost": best.trial.cost,
        "expected_probability": best.gain.probability,
        "decides": best.decides,
        "folder": folder,
        "between": [item.label for item in best.foretold],
        "options": [
            {
                "test": item.trial.id, "channel": item.trial.channel, "words": item.trial.words,
                "cost": item.trial.cost, "bits": item.gain.bits, "expected_probability": item.gain.probability,
                "decisive": item.gain.decisive,
            }
            for item in plan.options
        ],
        "repeats": None if plan.repeats is None else {
            "specimens": plan.repeats.specimens, "power": plan.repeats.wished,
            "power_by_specimens": [round(float(value), 4) for value in plan.repeats.power],
        },
    }  # fmt: skip


def next_words(plan: MeasurementPlan) -> str:
    """Return the plan in sentences: what to measure, what each explanation says there, and what repeats would do."""
    best = plan.best
    if best is None:
        return ""
    first, *others = best.foretold
    head = f"To tell {first.label} from {' or '.join(item.label for item in others)}: {best.trial.words}"
    surest = (
        f"with a chance of {_percent(best.gain.decisive)} it decides, at odds of 1000 (cost {best.trial.cost:g}, "
        "relative to one more specimen)"
    )
    text = f"{head}. {_there(best)}; {surest}."
    if not best.decides:
        text += " No measurement of the catalogue is expected to decide alone."
    return f"{text} {_more_specimens(plan)}".strip()


def _percent(share: float) -> str:
    """Return a chance in per cent that claims no certainty."""
    return "more than 99 %" if share > 0.99 else f"{100.0 * share:.0f} %"


def _there(option: Option) -> str:
    """Return what explanations say at the reading that separates the likeliest two most."""
    first, second = option.foretold[:2]
    points = option.points
    off = np.abs(first.mean - second.mean) / np.hypot(first.deviation, second.deviation)
    i = int(np.argmax(off))
    series = points.series[int(points.owner[i])]
    places = [
        f"{name} = {value:.0f} mm" for name, value in (("x", points.warp0[i]), ("y", points.weft0[i]))
        if np.isfinite(value)
    ]  # fmt: skip
    where = f" at {', '.join(places)}" if places else ""
    unit = UNITS[option.trial.channel]
    form = ".4f" if not unit else ".4g" if unit == " N" else ".2f"
    said = ", ".join(
        f"{item.label} foretells {item.mean[i]:{form}}{unit} (+- {BAND * item.deviation[i]:{form}})"
        for item in option.foretold
    )
    quantity = series.quantity.replace("_", " ")
    deep = f"{points.displacement[i]:.0f} mm deep"
    back = " on the way back" if option.trial.back else ""
    return f"The {quantity}{where}, {deep}{back}: {said}"


def _more_specimens(plan: MeasurementPlan) -> str:
    if plan.repeats is None:
        return ""
    if plan.repeats.specimens is None:
        return "More specimens of the same test would not tell them apart."
    return (
        f"Of the same test {plan.repeats.specimens} specimens in all would, with a chance of "
        f"{100 * plan.repeats.wished:.0f} %."
    )


def write_folder(plan: MeasurementPlan, task: DiagnosisTask, diagnosis: Diagnosis, folder: Path) -> Path | None:
    """Write the folder to be filled; files that somebody has filled already are left as they are."""
    best = plan.best
    if best is None:
        return None
    folder.mkdir(parents=True, exist_ok=True)
    write_whole(folder / "measured.yaml", _measured(best, task, diagnosis, folder))
    for name in files_of(best.trial, diagnosis):
        path = folder / name
        if not path.exists() or len(path.read_text(encoding="utf-8").splitlines()) < 2:
            write_whole(path, HEADERS[best.trial.channel] + "\n")
    write_whole(folder / PREDICTIONS, "\n".join(_predictions(best)) + "\n")
    return folder


def folder_of(diagnosis: Diagnosis, output: Path) -> Path:
    """Return the folder of the next measurement in an output folder: next, next_2, ..."""
    count = len(diagnosis.rounds) + 1
    return output / (NAME if count == 1 else f"{NAME}_{count}")


def _measured(option: Option, task: DiagnosisTask, diagnosis: Diagnosis, folder: Path) -> str:
    """Return the measured.yaml: the first measurements, and the further test with its files."""
    trial, files = option.trial, files_of(option.trial, diagnosis)
    unit = UNITS[trial.channel]
    noise = f"{noise_of(trial, diagnosis):.3g}{unit}"
    listed = f"files: [{', '.join(files)}]" if trial.channel in (FORCE, UNLOADING) else f"file: {files[0]}"
    lines = [
        f"# {trial.words}. Fill the files ({HEADERS[trial.channel]}; in time order), correct the noise, then diagnose",
        f"# this folder with the same --output. What the explanations foretell: {PREDICTIONS}.",
        f"title: {json.dumps(task.measured.title + ', ' + trial.id.replace('_', ' '), ensure_ascii=False)}",
        f"after: {json.dumps(_first(task, folder), ensure_ascii=False)}",
        "tests:",
        f"- name: {trial.id}",
    ]
    if trial.case:
        lines.append(f"  case: {{{', '.join(_pair(item) for item in trial.case)}}}")
    if trial.without:
        lines.append(f"  without: [{', '.join(trial.without)}]")
    lines += ["  channels:", f"    {trial.channel}: {{{listed}, noise: {noise}}}"]
    return "\n".join(lines) + "\n"


def _first(task: DiagnosisTask, folder: Path) -> str:
    """Return the folder of the measurements so far as seen from the new one."""
    return os.path.relpath(Path(task.measured.latest or task.measured.folder).resolve(), folder.resolve())


def _pair(text: str) -> str:
    key, _, value = text.partition("=")
    return f"{key}: {value}"


def _predictions(option: Option) -> list[str]:
    """Return the rows of the predictions: place, and per explanation mean and 95 % band."""
    points = option.points
    names = [item.label.replace(" + ", "+") for item in option.foretold]
    head = ["quantity", "displacement_mm", "warp0_mm", "weft0_mm"]
    rows = [",".join([*head, *(f"{name} {what}" for name in names for what in ("mean", "low", "high"))])]
    first = points.series[int(points.owner[0])].specimen
    for i in range(len(points)):
        series = points.series[int(points.owner[i])]
        if series.specimen != first:
            continue
        place = [f"{value:.4g}" if np.isfinite(value) else "" for value in (points.warp0[i], points.weft0[i])]
        cells = [
            f"{value:.6g}"
            for item in option.foretold
            for value in (
                item.mean[i], item.mean[i] - BAND * item.deviation[i], item.mean[i] + BAND * item.deviation[i]
            )
        ]  # fmt: skip
        rows.append(",".join([series.quantity, f"{points.displacement[i]:.4g}", *place, *cells]))
    return rows
