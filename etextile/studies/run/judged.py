"""Which criterion judges the wires of a run, with which numbers, and what it says."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.results.reader import Results, WireRecord
from etextile.types import Array
from loadcases.judging import judge_for, marked_strain
from loadcases.reader import stored_case
from loadcases.schema import Case
from wires.damage import FailureResult
from wires.history import WireHistory
from wires.judge import Judge


@dataclass(frozen=True)
class Judged:
    """A result file with its case, what became of its wires (None without), the own strain that maps mark as onset."""

    case: Case
    damage: FailureResult | None
    onset: float | None


def judged(results: Results, *, needed: bool = True) -> Judged:
    """Return what the judge of its own case says about a result file.

    Where no verdict is `needed`, a criterion from a file is not asked: that would run its code.
    """
    case = stored_case(results.case.effective, str(results.path))
    if not needed and case.failure.file is not None:
        return Judged(case, None, None)
    judge = judge_for(case)
    return Judged(case, verdict_of(results, judge), marked_strain(case, judge))


def verdict_of(results: Results, judge: Judge) -> FailureResult | None:
    """Return what became of wires and loops over the run, None without wires."""
    return None if results.wires is None else judge.judge(wire_history(results.wires))


def wire_history(record: WireRecord) -> WireHistory:
    """Return the histories of a result file with the flat fabric as their first step.

    Of a piece that is put on first, whose motion begins below 0, that is where its first step is.
    """

    def from_flat(values: Array) -> Array:
        return np.concatenate([np.zeros((1, *values.shape[1:])), values])

    return WireHistory(
        displacement_mm=np.concatenate([[min((0.0, *record.displacement_mm[:1]))], record.displacement_mm]),
        span_strain=from_flat(record.span_strain),
        wire_strain=from_flat(record.wire_strain),
        element_wire=record.element_wire,
        element_warp_mm=record.element_warp_mm,
        element_strain=from_flat(record.element_strain),
        element_along_mm=record.element_along_mm,
        element_length_mm=record.element_length_mm,
        layout=record.layout,
    )
