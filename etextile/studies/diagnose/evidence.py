"""How far a verdict goes, as a careful colleague would say it: what it rests on, and what it is not."""

from __future__ import annotations

from etextile.diagnose.decide.verdict import Answer, Finalist, Verdict
from etextile.diagnose.workflow import Diagnosis


def evidence_words(diagnosis: Diagnosis) -> str:
    """Return the level of evidence in a few sentences; a class is called a class, and no name."""
    verdict = diagnosis.verdict
    if verdict.kind is Answer.NO_GAP:
        return "No gap to explain. An effect smaller than noise, scatter and lattice error would not have been seen."
    if verdict.kind is Answer.NAMED and verdict.best is not None:
        return f"A name, by exclusion within the library. {_grounds(verdict.best)} {_confirmed(diagnosis)}"
    if verdict.kind is Answer.AMBIGUOUS:
        return _open(verdict)
    if verdict.lattice_doubt:
        return "No statement on the cause: the lattice decides more than the measurement does."
    return "Where the gap is stands; what causes it is open. The effect that comes closest is no finding."


def _grounds(best: Finalist) -> str:
    """Return what a name rests on: odds against confusable effects, the noise that is left, held-out data."""
    told = [part.what for part in best.held_out if part.shrinks]
    foretold = f", and what it was not fitted to it foretells ({', '.join(told)})" if told else ""
    return (
        "Every effect that is known to do nearly the same is at least 1000 times less likely, noise explains what is "
        f"left{foretold}."
    )


def _confirmed(diagnosis: Diagnosis) -> str:
    """Return whether a further test has borne a name out."""
    if diagnosis.rounds:
        tests = ", ".join(dict.fromkeys(item.test.replace("_", " ") for item in diagnosis.rounds))
        return f"A further test bears it out ({tests})."
    return "It rests on one kind of test; a cause that no library holds could look the same."


def _open(verdict: Verdict) -> str:
    """Return how much an ambiguous verdict leaves open: a class, several explanations, or one without proof."""
    groups = [group for group in verdict.classes if len(group) > 1]
    if groups:
        return (
            f"A class, not a name: {' and '.join(' or '.join(group) for group in groups)}, whichever is listed first."
        )
    if len(verdict.sets) > 1:
        return f"{len(verdict.sets)} explanations are left, none of them is a name."
    return "One explanation leads, and something that a name needs is missing."
