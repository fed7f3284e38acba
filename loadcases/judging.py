"""From a case to its judge: the failure criterion with what wires, material and scatter tell it, and its life law."""

from __future__ import annotations

from etextile.errors import BadInput, Problem
from loadcases.agreement import terms
from loadcases.schema import Case
from loadcases.wire_material import wire_numbers
from wires.failure import CRITERIA, resolve
from wires.fatigue import CoffinManson, StrainLife, StrainTable
from wires.judge import Judge
from wires.life import LifeSpec


def judge_for(case: Case, *, criterion: str | None = None) -> Judge:
    """Return the judge of a case, or with the defaults of another criterion by its name.

    Numbers of the section `failure` come before those of wires and scatter. Raises BadInput for what is wrong.
    """
    _of_one_make(case)
    failure = case.failure
    name = failure.criterion if criterion is None else criterion
    chosen = CRITERIA.load(name, failure.file if name == failure.criterion else None)
    known = {parameter.name for parameter in chosen.parameters}
    numbers = {"garment_scatter": case.scatter.strength}
    if case.wires is not None:
        numbers |= wire_numbers(case.wires)
    given = {key: value for key, value in numbers.items() if key in known}
    if name == failure.criterion:
        own = dict(failure.parameters)
        if "onset" not in known:
            del own["onset"]
        given |= own
    return Judge.of(chosen, resolve(name, given))


def life_spec(case: Case) -> LifeSpec | None:
    """Return the strain-life law of a case with what is required and agreed, None where it gives none."""
    cyclic = case.failure.cyclic
    if cyclic is None:
        return None
    law: StrainLife
    if cyclic.table is not None:
        law = StrainTable(cyclic.table.strain_range, cyclic.table.cycles, cyclic.source)
    else:
        law = CoffinManson(cyclic.coefficient or 0.0, cyclic.exponent or 0.0, cyclic.source)
    agreed = cyclic.agreed.model_copy(update={"required_cycles": cyclic.required})
    return LifeSpec(law, cyclic.scatter, cyclic.required, dict(terms(agreed)))


def _of_one_make(case: Case) -> None:
    """Raise BadInput for wires whose own filaments the one limit of the judge would be wrong for."""
    if case.wires is None:
        return
    problems = [
        Problem(
            f"this wire would be judged by the limit of the others (got {value}, they have {common}); one make of "
            "filaments is judged at a time, give it to all wires or run a case for each",
            key=f"wires.paths.{number}.{name}",
        )
        for number, path in enumerate(case.wires.paths)
        for name in ("material", "filaments", "filament_diameter")
        if (value := getattr(path, name)) is not None and value != (common := getattr(case.wires, name))
    ]
    if problems:
        raise BadInput(problems)


def break_strain(case: Case, judge: Judge) -> float:
    """Return the strain at which the typical loop loses its first filament, with the case's material and diameter.

    Of criteria of a user's own it is the onset of the case; `strain_kind` of the criterion says whose strain.
    """
    limit = getattr(judge.criterion, "limit", None)
    return case.failure.onset if limit is None else float(limit(judge.parameters))


def marked_strain(case: Case, judge: Judge) -> float | None:
    """Return the wire's own strain that maps mark as the onset, None where the criterion has none of the wire."""
    return None if judge.criterion.name == "span_strain" else break_strain(case, judge)
