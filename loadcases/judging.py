"""From a case to its judge: the failure criterion with what wires, material and scatter tell it, and its life law."""

from __future__ import annotations

from loadcases.agreement import terms
from loadcases.schema import Case
from loadcases.wire_material import wire_numbers
from wires.criteria.by_make import ByMake, Make, by_make
from wires.failure import CRITERIA, resolve
from wires.fatigue import CoffinManson, StrainLife, StrainTable
from wires.judge import Judge
from wires.life import LifeSpec


OWN_KEYS = ("material", "filaments", "filament_diameter")
"""What of a wire changes the strain it stands."""


def judge_for(case: Case, *, criterion: str | None = None) -> Judge:
    """Return the judge of a case, or with the defaults of another criterion by its name.

    Numbers of the section `failure` come before those of wires and scatter. Raises BadInput for what is wrong.
    """
    failure = case.failure
    name = failure.criterion if criterion is None else criterion
    chosen = CRITERIA.load(name, failure.file if name == failure.criterion else None)
    known = {parameter.name for parameter in chosen.parameters}
    numbers = {"garment_scatter": case.scatter.strength}
    if case.wires is not None:
        numbers |= wire_numbers(case.wires)
    given = {key: value for key, value in numbers.items() if key in known}
    own: dict[str, float] = {}
    if name == failure.criterion:
        own = dict(failure.parameters)
        if "onset" not in known:
            del own["onset"]
        given |= own
    makes = _makes(case, known - own.keys())
    return Judge.of(by_make(chosen, makes), resolve(name, given))


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


def _makes(case: Case, free: set[str]) -> tuple[Make, ...]:
    """Return the wires whose own filaments change numbers of the criterion that the section `failure` leaves free."""
    wires = case.wires
    groups: dict[tuple[tuple[str, object], ...], list[str]] = {}
    for path in () if wires is None else wires.paths:
        own = {name: value for name in OWN_KEYS if (value := getattr(path, name)) is not None}
        if any(value != getattr(wires, name) for name, value in own.items()):
            groups.setdefault(tuple(own.items()), []).append(path.name)
    found = []
    for own_keys, names in groups.items():
        numbers = wire_numbers(wires.model_copy(update=dict(own_keys))) if wires is not None else {}
        found.append(Make(frozenset(names), {key: value for key, value in numbers.items() if key in free}))
    return tuple(found)


def make_notes(case: Case) -> tuple[str, ...]:
    """Return what to say of wires of makes of their own: what they are of, and that their own limit judges them."""
    if case.wires is None:
        return ()
    said = []
    for make in _makes(case, set(wire_numbers(case.wires))):
        path = next(path for path in case.wires.paths if path.name in make.wires)
        material, filaments, diameter = (getattr(path, k) or getattr(case.wires, k) for k in OWN_KEYS)
        names = ", ".join(sorted(make.wires))
        said.append(f"wires {names}: {filaments} filaments of {diameter:g} mm {material}, judged by their own limit")
    return tuple(said)


def break_strain(case: Case, judge: Judge) -> float:
    """Return the strain at which the typical loop loses its first filament, with the case's material and diameter.

    Of criteria of a user's own it is the onset of the case; `strain_kind` of the criterion says whose strain.
    """
    limit = getattr(judge.criterion, "limit", None)
    return case.failure.onset if limit is None else float(limit(judge.parameters))


def marked_strain(case: Case, judge: Judge) -> float | None:
    """Return the wire's own strain that maps mark as the onset, None where there is no one of all wires."""
    if isinstance(judge.criterion, ByMake):
        return None
    return None if judge.criterion.name == "span_strain" else break_strain(case, judge)
