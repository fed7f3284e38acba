"""What a diagnosis may claim: for every effect it found, those that the measured channels cannot tell from it."""

from __future__ import annotations

from etextile.diagnose.decide.classes import class_of
from etextile.diagnose.decide.verdict import AMBIGUOUS, NAMED
from etextile.diagnose.infer.free import form_modes
from etextile.diagnose.workflow import Diagnosis


def classes(diagnosis: Diagnosis) -> tuple[tuple[str, ...], ...]:
    """Return one class per effect of the best explanation, the effect itself first; none where nothing was found."""
    verdict = diagnosis.verdict
    if verdict.best is None or verdict.kind not in (NAMED, AMBIGUOUS):
        return ()
    form, found, start = form_modes(diagnosis.bench.points), [], 0
    tables = {name: table for name, table in diagnosis.tables.items() if name not in diagnosis.screening.unseen}
    ids = verdict.best.contender.ids
    for name in ids:
        table = diagnosis.tables[name]
        point = verdict.best.contender.evidence.best[start : start + len(table.bounds)]
        start += len(table.bounds)
        tables[name] = table
        found.append(class_of(name, table.curve(point), diagnosis.bench, tables, form, without=ids))
    return tuple(found)


def class_words(diagnosis: Diagnosis) -> list[str]:
    """Return a sentence for every effect that these channels cannot tell from others."""
    return [
        f"{name}: these channels alone cannot tell it from {' or '.join(others)} at this size; take the name as one "
        "of this class until a further measurement decides"
        for name, *others in classes(diagnosis)
        if others
    ]
