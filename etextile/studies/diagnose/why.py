"""Why not the others: every candidate with its probability, its held-out gap, and what speaks against it."""

from __future__ import annotations

from typing import Any

import numpy as np

from etextile.diagnose.decide.gap import HELD_OUT, gaps
from etextile.diagnose.decide.heldout import hold_out, prediction
from etextile.diagnose.decide.proof import raw_deviation, rest_values, to_raw
from etextile.diagnose.decide.rank import Contender, Kind
from etextile.diagnose.decide.signature import mismatch
from etextile.diagnose.decide.verdict import Answer, Finalist
from etextile.diagnose.infer.fit import Evidence
from etextile.diagnose.infer.free import form_modes
from etextile.diagnose.infer.lattice_doubt import facing
from etextile.diagnose.workflow import Diagnosis
from etextile.types import Array, BoolArray


PAIRS = 3
"""Pairs that are listed beside the single effects."""
SMALL = 5e-4


def candidate_rows(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return one row per single effect and for the likeliest pairs, the most probable first.

    probability: that the effects act, whatever acts beside them; the same number for an effect wherever it stands.

    held_out_percent: gap left in the channel with the strongest gap, on displacements beyond the split, fitted up to
    it. rejected_because: empty for what the verdict names, and for every explanation of an ambiguous one.
    """
    shown = [item for item in diagnosis.ranking.effects if item.kind is Kind.ONE]
    shown += [item for item in diagnosis.ranking.effects if item.kind is not Kind.ONE][:PAIRS]
    test = _held_out_points(diagnosis)
    form = form_modes(diagnosis.bench.points)
    finalists = {item.contender.ids: item for item in diagnosis.finalists}
    rows = [
        {
            "id": " + ".join(item.ids),
            "probability": min(diagnosis.ranking.including(*item.ids), 1.0),
            "held_out_percent": _left(diagnosis, item, test, form=form),
            "rejected_because": _why_not(diagnosis, item, finalists.get(item.ids)),
        }
        for item in shown
    ]
    return sorted(rows, key=lambda row: -float(row["probability"]))


def _held_out_points(diagnosis: Diagnosis) -> BoolArray:
    return diagnosis.bench.points.displacement > diagnosis.split


def _left(diagnosis: Diagnosis, item: Contender, test: BoolArray, *, form: Array) -> float | None:
    """Return what is left of the held-out gap in the channel with the strongest gap, per cent."""
    if not diagnosis.places or not test.any() or test.all() or not _reaches(item):
        return None
    tables = [diagnosis.tables[name] for name in item.ids]
    bench = facing(diagnosis.bench, tables, item.doubt)
    fit: Evidence = hold_out(bench, tables, form, test, what="", offset=item.offset).fit
    change = prediction(fit, tables) @ fit.weights + (0.0 if item.offset is None else item.offset)
    base, raw = diagnosis.lattice.value, bench.raw
    found = gaps(
        raw, base, base + to_raw(bench, change), deviation=raw_deviation(bench),
        rest=rest_values(bench, diagnosis.base_runs.finer), held_out=raw.displacement > diagnosis.split,
    )  # fmt: skip
    wanted = (diagnosis.places[0].channel, HELD_OUT)
    return next((gap.after_percent for gap in found if (gap.channel, gap.part) == wanted), None)


def _why_not(diagnosis: Diagnosis, item: Contender, finalist: Finalist | None) -> str:
    """Return what speaks against a hypothesis, most serious first."""
    verdict = diagnosis.verdict
    if item.ids in ((verdict.effects,) if verdict.kind is Answer.NAMED else verdict.sets):
        return ""
    if not diagnosis.scan.detected:
        return "there is no gap to explain"
    unseen = [name for name in item.ids if name in diagnosis.screening.unseen]
    if unseen:
        return f"these channels cannot show {' or '.join(unseen)}"
    reasons = [] if finalist is None else list(finalist.flaws())
    best = diagnosis.ranking.effects[0]
    behind = best.score - item.score
    if _reaches(item) and not np.isfinite(item.log_prior):
        reasons.insert(0, f"ruled out: {best.label} explains what it leaves")
    elif behind > 0.0 and item.ids != best.ids:
        reasons.insert(0, _behind(behind, best))
    if item.ids != best.ids:
        reasons += _physical(diagnosis, item)
    alike = [name for name in diagnosis.screening.partners(item.ids[0]) if len(item.ids) == 1]
    if alike:
        reasons.append(f"looks like {', '.join(alike)}")
    if not reasons:
        reasons = list(finalist.objections()) if finalist is not None else []
    return "; ".join(reasons) or "one of several that fit"


def _reaches(item: Contender) -> bool:
    """Tell whether the hypothesis has any parameters, within their range, at which it could be simulated."""
    return bool(np.isfinite(item.evidence.log_evidence))


def _physical(diagnosis: Diagnosis, item: Contender) -> list[str]:
    """Return what sign and onset of a single effect have against the strongest gap."""
    if len(item.ids) != 1 or not diagnosis.places or not _reaches(item):
        return []
    table = diagnosis.tables[item.ids[0]]
    words = mismatch(diagnosis.bench, diagnosis.places[0], table, item.evidence.best)
    return [words] if words else []


def _behind(difference: float, best: Contender) -> str:
    """Return in words how much less probable a hypothesis is than the best."""
    if not np.isfinite(difference):
        return "cannot reach what was measured within its physical range"
    if difference > 14.0:
        return f"fits far worse than {best.label}"
    if difference < 0.5:
        return f"about as probable as {best.label}"
    return f"{np.exp(difference):,.0f} times less probable than {best.label}".replace(",", " ")
