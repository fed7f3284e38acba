"""The pictures of a diagnosis: curves before and after per quantity, and the evidence for every effect."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from etextile.diagnose.decide.heldout import prediction
from etextile.diagnose.decide.proof import EFFECT, model_deviation, to_raw
from etextile.diagnose.workflow import Diagnosis
from etextile.studies.diagnose.curves import ComparedCurves, Predicted, panels
from etextile.studies.diagnose.proof import Proven
from etextile.studies.run.drawing import drawn_scenes
from etextile.studies.run.judged import judged
from etextile.types import Array
from viz.diagnosis_plots import Panel, save_evidence, save_panels


def draw(data: Mapping[str, Any], diagnosis: Diagnosis, proven: Proven, folder: Path) -> tuple[Panel, ...]:
    """Write gap.png and evidence.png; return the panels for the page."""
    found = diagnosis_panels(diagnosis, proven)
    title = f"{data['case']['title']}: {data['measured']['title']}"
    label = after_label(data)
    save_panels(found, folder / "gap.png", title=title, after_label=label)
    if diagnosis.scan.detected:
        save_evidence(data["candidates"], folder / "evidence.png", title="Evidence for each effect")
    return found


def field_maps(proven: Proven) -> list[dict[str, Any]]:
    """Return the fields of the runs without and with the effect for the page, none without runs."""
    from viz.fields_page import field_map

    maps = []
    for name, run in (("without the effect", proven.base), ("with the effect", proven.patched)):
        if run is None:
            return []
        found = judged(run.results)
        scenes = drawn_scenes(run.results, run.report, damage=found.damage, title="")
        if not scenes:
            return []
        maps.append(field_map(name, scenes, run.report))
    return maps


def after_label(data: Mapping[str, Any]) -> str:
    """Return the name of the curve with the effect."""
    return "with " + " and ".join(str(item["id"]) for item in data["effects"]) if data["effects"] else ""


def diagnosis_panels(diagnosis: Diagnosis, proven: Proven) -> tuple[Panel, ...]:
    """Return the panels of all quantities with the proof's predictions."""
    bench, proof = diagnosis.bench, proven.proof
    model = model_deviation(bench)
    before = Predicted(diagnosis.lattice.value, to_raw(bench, model))
    after = None
    if proof.patched is not None:
        own = np.hypot(model, effect_deviation(diagnosis))
        after = Predicted(proof.patched, to_raw(bench, own))
    split = None if after is None else diagnosis.split
    shown = ComparedCurves(before, proof.deviation, after, proof.predictions.get(EFFECT), split)
    return panels(bench.raw, shown, places=diagnosis.places)


def effect_deviation(diagnosis: Diagnosis) -> Array:
    """Return the posterior standard deviation (n,) of the change by the effect of the verdict."""
    best = diagnosis.verdict.best
    if best is None:
        return np.zeros(len(diagnosis.bench.points))
    evidence = best.contender.evidence
    changes = prediction(evidence, [diagnosis.tables[name] for name in best.contender.ids])
    weights = evidence.weights / evidence.weights.sum()
    mean = changes @ weights
    return np.asarray(np.sqrt(np.maximum((changes - mean[:, None]) ** 2 @ weights, 0.0)))
