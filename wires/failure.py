"""Failure criteria by name: the registry, the check of a case's numbers, the evaluation.

A criterion of your own is an object with `name`, `summary`, `parameters` and `evaluate` (`wires.damage.Criterion`): in
a file that the case names, in an installed package (`wires.criteria_of_users`), or added by `CRITERIA.register`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from etextile.errors import BadInput, Problem, nearest
from etextile.results.wire_history import WireHistory
from wires.criteria.calibrated import Calibrated
from wires.criteria.filament_bundle import FilamentBundle
from wires.criteria.span_strain import SpanStrain
from wires.criteria.wire_strain import WireStrain
from wires.criteria_of_users import Criteria
from wires.damage import CriterionParameter, FailureResult
from wires.judge import Judge


CRITERIA = Criteria()
CRITERIA.register("calibrated", Calibrated())
CRITERIA.register("span_strain", SpanStrain())
CRITERIA.register("wire_strain", WireStrain())
CRITERIA.register("filament_bundle", FilamentBundle())

DEFAULT_CRITERION = "calibrated"


def resolve(criterion: str, given: Mapping[str, float]) -> dict[str, float]:
    """Return the criterion's parameters with the given values over the defaults.

    Raises BadInput that lists every unknown name and every value that is not allowed.
    """
    known = {parameter.name: parameter for parameter in CRITERIA[criterion].parameters}
    problems = [_unknown(criterion, name, known) for name in given if name not in known]
    values = {name: float(given.get(name, parameter.default)) for name, parameter in known.items()}
    problems += [
        _out_of_range(known[name], value) for name, value in values.items() if not _allowed(known[name], value)
    ]
    problems += [] if problems else _no_onset(values)
    if problems:
        raise BadInput(problems)
    return values


def judge_of(criterion: str = DEFAULT_CRITERION, parameters: Mapping[str, float] | None = None) -> Judge:
    """Return the judge by a criterion; `parameters` are those that differ from the defaults. Raises BadInput."""
    return Judge.of(CRITERIA[criterion], resolve(criterion, parameters or {}))


def evaluate(
    history: WireHistory, criterion: str = DEFAULT_CRITERION, *, parameters: Mapping[str, float] | None = None
) -> FailureResult:
    """Return what a criterion alone says of typical wires (reports take `judge_of`, which knows all scatter)."""
    return CRITERIA[criterion].evaluate(history, resolve(criterion, parameters or {}))


def _allowed(parameter: CriterionParameter, value: float) -> bool:
    if not math.isfinite(value):
        return False
    return value > parameter.minimum if parameter.open_minimum else value >= parameter.minimum


def _out_of_range(parameter: CriterionParameter, value: float) -> Problem:
    bound = "greater than" if parameter.open_minimum else "at least"
    return Problem(f"must be finite and {bound} {parameter.minimum:g} (got {value:g})", key=f"failure.{parameter.name}")


def _no_onset(values: Mapping[str, float]) -> list[Problem]:
    """Return what is wrong with coupons whose wires were slack still when they broke."""
    onset = values.get("onset", 1.0)
    return [
        Problem(f"must be below the onset {onset:g} of the coupons (got {values[name]:g})", key=f"failure.{name}")
        for name in ("coupon_slack", "coupon_crimp")
        if values.get(name, 0.0) >= onset
    ]


def _unknown(criterion: str, name: str, known: Mapping[str, CriterionParameter]) -> Problem:
    allowed = ", ".join(known)
    return Problem(f"criterion {criterion!r} takes {allowed}{nearest(name, known)}", key=f"failure.{name}")
