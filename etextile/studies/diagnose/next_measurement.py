"""What to measure next: what would tell the explanations apart, or confirm the one that was named."""

from __future__ import annotations

from etextile.diagnose.decide.verdict import Answer, Finalist
from etextile.diagnose.workflow import Diagnosis


WORN = {
    "joint_moment": "the moment over the angle on a jig, less that of the bare dummy",
    "mark_slip": "how far marks on the fabric slip along the skin",
}
"""What can be measured of a worn piece, by channel."""


def next_measurement(diagnosis: Diagnosis) -> str:
    """Return the next measurement in words, empty when there is no gap.

    For verdicts of which no measurement was planned: what excludes faults of the test, then what the cards of the
    effects say.
    """
    verdict = diagnosis.verdict
    if verdict.kind is Answer.NO_GAP:
        return ""
    if diagnosis.next_measurement:
        return diagnosis.next_measurement
    rival = _rival(diagnosis) if diagnosis.points.unit != "deg" else None
    if verdict.best is not None and rival is not None:
        return _between(diagnosis, verdict.best, rival)
    if verdict.lattice_doubt:
        return "Refine the case (fabric.coarsening), then diagnose again; no measurement helps before that."
    if verdict.best is None:
        return (
            "No effect that these channels can show is left: measure another channel, or add the effect that is missed."
        )
    if diagnosis.points.unit == "deg":
        return _on_a_joint(diagnosis)
    cards = [diagnosis.tables[name].grid.card for name in verdict.best.contender.ids]
    words = " ".join(card.separate for card in cards if card.separate)
    if verdict.kind is Answer.NAMED:
        return f"To confirm {verdict.best.label}: {words}" if words else ""
    first = " ".join(dict.fromkeys(item.separate for item in verdict.faults))
    channels = diagnosis.bench.points.channels
    punched = "punch_force" in channels
    missing = [name for name in ("strain field", "clamp line", "free edge") if punched and name.replace(" ", "_") not in
               channels]  # fmt: skip
    more = f"Channels that were not measured: {', '.join(missing)}." if missing else ""
    test = f"To test {verdict.best.label}, which comes closest: {words}" if words else ""
    return " ".join(part for part in (first, more, test) if part)


def _on_a_joint(diagnosis: Diagnosis) -> str:
    """Return what of a worn piece was not measured: what cards say is of flat tests."""
    missing = [words for name, words in WORN.items() if name not in diagnosis.bench.points.channels]
    return f"Not measured yet: {'; '.join(missing)}." if missing else ""


def _rival(diagnosis: Diagnosis) -> Finalist | None:
    """Return the most probable other explanation of an ambiguous verdict, None without one."""
    others = [item for item in diagnosis.finalists if item.contender.ids in diagnosis.verdict.sets[1:]]
    return max(others, key=lambda item: item.alone, default=None)


def _between(diagnosis: Diagnosis, first: Finalist, second: Finalist) -> str:
    """Return what the cards say of telling two finalists apart, where no measurement of the catalogue would."""
    differing = set(first.contender.ids) ^ set(second.contender.ids)
    cards = [diagnosis.tables[name].grid.card for name in sorted(differing) if name in diagnosis.tables]
    advice = " ".join(card.separate for card in cards if card.separate)
    return f"To tell {first.label} from {second.label}: {advice}" if advice else ""
