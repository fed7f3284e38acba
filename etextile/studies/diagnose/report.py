"""The report of a diagnosis as one dictionary: what diagnosis.json holds, and what text and page are drawn from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib import metadata
from typing import Any

import numpy as np

from etextile.diagnose.decide.gap import Gap
from etextile.diagnose.decide.heldout import HeldOut
from etextile.diagnose.decide.proof import FLOOR, ROWS
from etextile.diagnose.decide.rank import Kind
from etextile.diagnose.decide.verdict import Answer, Finalist
from etextile.diagnose.workflow import Diagnosis
from etextile.studies.diagnose.compare import fabric_words, place_row, tensile_rows
from etextile.studies.diagnose.evidence import evidence_words
from etextile.studies.diagnose.patch import found_effects
from etextile.studies.diagnose.proof import Proven, beyond_split, observed_states
from etextile.studies.diagnose.setting import DiagnosisTask
from etextile.studies.diagnose.why import candidate_rows
from etextile.vocabulary import FABRIC_FAMILIES
from wires.axis import axis_of


Data = dict[str, Any]
PACKAGES = ("etextile", "numpy", "scipy")


def report_of(
    task: DiagnosisTask, diagnosis: Diagnosis, proven: Proven, *, patch: str | None, provisional: str | None,
    command: str,
    notes: Sequence[str], wall_s: float, coming: Data | None = None,
) -> Data:  # fmt: skip
    """Return the report; the keys that users rely on come first, further ones after them."""
    verdict, unit = diagnosis.verdict, diagnosis.points.unit
    best = verdict.best
    base, patched = proven.base, proven.patched
    return {
        "verdict": verdict.kind,
        "class": list(dict.fromkeys(name for group in verdict.classes for name in group)),
        "classes": [list(group) for group in verdict.classes],
        "faults": [
            {
                "id": item.id,
                "words": item.words,
                "separate": item.separate,
                "probability": diagnosis.ranking.of_fault(item.id),
            }
            for item in verdict.faults
        ],
        "failed_checks": [{"id": item.id, "words": item.words, "p_value": item.p_value} for item in verdict.failed],
        "effects": effect_rows(diagnosis, best) if verdict.kind in (Answer.NAMED, Answer.AMBIGUOUS) else [],
        "restrictions": list(task.restrictions),
        "ambiguous_with": list(verdict.ambiguous_with),
        "ambiguous_sets": [list(ids) for ids in verdict.sets],
        "where": [place_row(item, unit) for item in diagnosis.places],
        "gap": [_gap_row(gap, proven) for gap in proven.proof.gaps],
        "candidates": candidate_rows(diagnosis),
        "next_measurement": diagnosis.next_measurement,
        "next": coming,
        "rounds": [asdict(item) for item in diagnosis.rounds],
        "patch": patch,
        "simulations": diagnosis.simulations,
        "wall_s": round(wall_s, 1),
        "case": {"title": task.loaded.case.title, "sha256": task.loaded.sha256},
        "measured": {
            "title": task.measured.title,
            "channels": list(task.measured.channels),
            f"up_to_{unit}": float(diagnosis.points.displacement.max()),
        },
        "fabric": fabric_words(task),
        "sentence": verdict.sentence,
        "evidence": evidence_words(diagnosis),
        "where_sentence": diagnosis.where,
        "partial": effect_rows(diagnosis, best) if verdict.kind not in (Answer.NAMED, Answer.AMBIGUOUS) else [],
        "provisional": provisional,
        "command": command,
        "load_unit": unit,
        f"split_{unit}": diagnosis.split,
        "held_out": [_held_out_row(part) for part in best.held_out] if best is not None else [],
        "rows": _rows(proven),
        "as_run": list(proven.as_run),
        "tensile": tensile_rows(task),
        "audit": [_audit_row(asdict(row), unit) for row in diagnosis.audit],
        "wires": wire_changes(base.report, patched.report) if base is not None and patched is not None else None,
        "observed": observed_states(task, proven),
        "stages": stage_numbers(diagnosis),
        "notes": list(notes),
        "seed": diagnosis.setting.seed,
        "versions": {name: metadata.version(name) for name in PACKAGES},
    }


def _audit_row(row: Data, unit: str) -> Data:
    """Return a row of the audit; the load at which a variable leaves its range is named with its unit."""
    return {f"leaves_{unit}" if key == "leaves" else key: value for key, value in row.items()}


def effect_rows(diagnosis: Diagnosis, best: Finalist | None) -> list[Data]:
    """Return the effects of a hypothesis with their parameters, intervals and what is known about them."""
    if best is None:
        return []
    rows = []
    for item in found_effects(diagnosis, best.contender.ids, best.contender.evidence):
        card = item.card
        rows.append(
            {
                "id": card.id,
                "parameters": {
                    name: {
                        "value": value,
                        "low": low,
                        "high": high,
                        "unit": card.parameter(name).unit,
                        "fixed": name not in item.intervals,
                        "meaning": card.parameter(name).meaning,
                    }
                    for name, (value, low, high) in item.written().items()
                },
                "probability": min(diagnosis.ranking.including(card.id), 1.0),
                "mechanism": card.mechanism,
                "separate": card.separate,
                "literature": card.literature,
            }
        )
    return rows


def _gap_row(gap: Gap, proven: Proven) -> Data:
    """Return a gap with the floor that a free smooth curve through everything leaves."""
    floor = next(
        (other for other in proven.proof.rows.get(FLOOR, ()) if (other.channel, other.part) == (gap.channel, gap.part)),
        None,
    )
    return {**asdict(gap), "floor_percent": None if floor is None else floor.after_percent}


def _rows(proven: Proven) -> list[Data]:
    """Return one row per prediction, channel and part: gap in per cent and in standard deviations."""
    return [
        {"row": name, "channel": gap.channel, "part": gap.part, "percent": gap.after_percent, "chi": gap.after_chi}
        for name in ROWS
        for gap in proven.proof.rows.get(name, ())
    ]


def _held_out_row(part: HeldOut) -> Data:
    return {
        "what": part.what,
        "before_chi": part.before,
        "after_chi": part.after,
        "closed": 1.0 - part.after / part.before if part.before > 0.0 else 0.0,
        "shrinks": part.shrinks,
        "square_closed": {"value": part.closed, "low": part.low, "high": part.high},
    }


def wire_changes(before: Mapping[str, Any], after: Mapping[str, Any]) -> Data:
    """Return what the effect changes in the verdicts of the wires, from the reports of two runs."""
    axis, rows = axis_of(before), []
    for old, new in zip(before["wires"], after["wires"], strict=True):
        rows.append(
            {
                "wire": old["wire"],
                "weft_mm": old["weft_mm"],
                **{
                    f"{name}_{when}": row[name]
                    for when, row in (("before", old), ("after", new))
                    for name in ("state", axis.failure_key, "max_strain", "failure_probability")
                },
            }
        )
    return {
        axis.key: axis.values(before)[-1],
        "before": before["verdict"]["sentence"],
        "after": after["verdict"]["sentence"],
        "changed": sum(row["state_before"] != row["state_after"] for row in rows),
        "rows": rows,
    }


def stage_numbers(diagnosis: Diagnosis) -> Data:
    """Return the numbers of stages 0 to 6."""
    bench, scan = diagnosis.bench, diagnosis.scan
    weights = np.array([item.weight for item in bench.scatters])
    scatter = {
        name: float(weights @ [getattr(item.scatter, name) for item in bench.scatters] / weights.sum())
        for name in ("gain", "shift", "drift")
    }
    base = diagnosis.setting.base
    tops = list(zip(diagnosis.ranking.contenders, diagnosis.ranking.probabilities, strict=True))[:8]
    return {
        "gate": {
            "coarsenings": [diagnosis.levels.table, *diagnosis.levels.gate],
            "lattice_error": _lattice_rows(diagnosis),
            "simulations": diagnosis.simulations,
        },
        "noise": {"instrument": _instrument_rows(diagnosis), "scatter": scatter},
        "base": {family: source for family, source in zip(FABRIC_FAMILIES, base.sources, strict=True)},
        "detect": {
            "largest": scan.largest, "critical": scan.critical, "p_value": scan.p_value, "detected": scan.detected,
        },
        "screen": {
            "scores": dict(sorted(diagnosis.screening.scores.items(), key=lambda item: -abs(item[1]))),
            "alike": [list(group) for group in diagnosis.screening.groups],
            "unseen": list(diagnosis.screening.unseen),
        },
        "rank": [{"label": item.label, "probability_exactly": float(p)} for item, p in tops],
        "free_probability": diagnosis.ranking.of_kind(Kind.FREE, Kind.REST),
        "finalists": [_finalist_row(item) for item in diagnosis.finalists],
    }  # fmt: skip


def _finalist_row(item: Finalist) -> Data:
    part = beyond_split(item)
    return {
        "label": item.label,
        "probability": min(item.probability, 1.0),
        "probability_alone": min(item.alone, 1.0),
        "probability_coarse": item.probability_coarse,
        "rest_p": item.rest_p,
        "closed": item.closed,
        "held_out": None if part is None else _held_out_row(part),
        "objections": list(item.objections()),
    }


def _lattice_rows(diagnosis: Diagnosis) -> list[Data]:
    """Return the lattice error that stays open, per channel, in per cent of the gap's measure."""
    raw, deviation = diagnosis.bench.raw, diagnosis.lattice.deviation
    moved = np.abs(diagnosis.bench.shape.motion)[diagnosis.bench.bins.bin_of]
    rows = []
    for channel in raw.channels:
        own = raw.of(channel)
        share = float(np.sqrt(np.mean(deviation[own] ** 2)) / max(float(np.sqrt(np.mean(moved[own] ** 2))), 1e-12))
        rows.append({"channel": channel, "percent": 100.0 * share})
    return rows


def _instrument_rows(diagnosis: Diagnosis) -> list[Data]:
    """Return the instrument's noise per quantity."""
    raw, white = diagnosis.bench.raw, diagnosis.bench.white_raw
    found: dict[tuple[str, str, str], list[float]] = {}
    for number, item in enumerate(raw.series):
        own = raw.owner == number
        if own.any():
            key = (item.channel, item.quantity, item.unit)
            found.setdefault(key, []).append(float(np.sqrt(np.mean(white[own] ** 2))))
    return [
        {"channel": channel, "quantity": quantity, "value": float(np.mean(values)), "unit": unit}
        for (channel, quantity, unit), values in found.items()
    ]
