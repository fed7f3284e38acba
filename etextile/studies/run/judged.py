"""Which criterion judges the wires of a run, with which numbers, and what it says."""

from __future__ import annotations

from dataclasses import dataclass

from etextile.results.reader import Results
from loadcases.judging import judge_for, marked_strain
from loadcases.reader import stored_case
from loadcases.schema import Case
from wires.damage import FailureResult


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
    return Judged(case, judge.verdict(results.wires), marked_strain(case, judge))
