"""Which criterion judges the wires of a run, with which numbers, and what it says."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.results.reader import Results, WireRecord
from etextile.types import Array
from loadcases.reader import read_case
from loadcases.schema import Case
from loadcases.wire_material import wire_numbers
from wires.damage import FailureResult
from wires.failure import CRITERIA, evaluate
from wires.history import WireHistory


@dataclass(frozen=True)
class Judged:
    """A result file with its case, the damage of its wires (None without wires) and the strain from which it begins."""

    case: Case
    damage: FailureResult | None
    onset: float


def judged(results: Results) -> Judged:
    """Return what the criterion of its own case says about a result file."""
    case = read_case(results.case.effective, file=str(results.path)).case
    parameters = judged_by(case)
    return Judged(case, judge(results, case.failure.criterion, parameters), parameters["onset"])


def judged_by(case: Case) -> dict[str, float]:
    """Return the parameters of the failure criterion as they will be used; raises BadInput for what is wrong."""
    from wires.failure import resolve

    failure = case.failure
    known = {parameter.name for parameter in CRITERIA.load(failure.criterion, failure.file).parameters}
    given = {name: value for name, value in failure.parameters.items() if name != "onset" or name in known}
    if case.wires is not None:
        given |= {name: value for name, value in wire_numbers(case.wires).items() if name in known}
    return {"onset": failure.onset, **resolve(failure.criterion, given)}


def judge(results: Results, criterion: str, parameters: dict[str, float]) -> FailureResult | None:
    """Return the damage of wires and loops over the run, None without wires."""
    if results.wires is None:
        return None
    known = {parameter.name for parameter in CRITERIA[criterion].parameters}
    used = {name: value for name, value in parameters.items() if name in known}
    return evaluate(wire_history(results.wires), criterion, parameters=used)


def wire_history(record: WireRecord) -> WireHistory:
    """Return the histories of a result file with the flat fabric as their first step."""

    def from_flat(values: Array) -> Array:
        return np.concatenate([np.zeros((1, *values.shape[1:])), values])

    return WireHistory(
        displacement_mm=from_flat(record.displacement_mm),
        span_strain=from_flat(record.span_strain),
        wire_strain=from_flat(record.wire_strain),
        element_wire=record.element_wire,
        element_warp_mm=record.element_warp_mm,
        element_strain=from_flat(record.element_strain),
        element_along_mm=record.element_along_mm,
        element_length_mm=record.element_length_mm,
        layout=record.layout,
    )
