"""The verdict: no gap, a named effect, an ambiguous set, or unexplained; and why not the others.

`named` asks for all of it: effects that act with probability 0.9, most likely with no others beside them, residuals
that noise explains, a held-out gap that shrinks, parameters inside of their physical range, effects that move the force
as their cards say, all on the finer lattice and not there alone, and decisive evidence against effects that nearly do
the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from types import MappingProxyType

import numpy as np

from etextile.diagnose.decide.classes import Classes
from etextile.diagnose.decide.directed import Check, Fault, in_words
from etextile.diagnose.decide.heldout import HeldOut
from etextile.diagnose.decide.rank import Contender, Kind, Ranking
from etextile.diagnose.decide.residual_test import REST_LEVEL
from etextile.diagnose.decide.rivals import DECISIVE, Confused, confusable, widened
from etextile.units import probability


class Answer(StrEnum):
    """The four verdicts."""

    NO_GAP = "no_gap"
    NAMED = "named"
    AMBIGUOUS = "ambiguous"
    UNEXPLAINED = "unexplained"


# An effect is named when it acts with this probability, and acts alone with that.
SURE, ALONE = 0.90, 0.60
# A member of an ambiguous set has at least this share of the probability of the best.
SHARE = 0.05
# A hypothesis that led with this probability before its own runs on finer lattices stays a rival of one that had less
# than `SHARE` then: what depends on the lattice is not sure.
LED = 0.50


@dataclass(frozen=True)
class Finalist:
    """A contender with what decides: p-value of what it leaves, held-out scores, bounds it sits on, probabilities.

    `probability`: its effects act, whatever acts beside them; `alone`: they act and no others. A second effect that the
    data can neither show nor exclude lowers the second, not the first. `probability_coarse`: `alone` before the refit;
    `simulated`: its run on the finest lattice found an equilibrium; `faint`: effects whose own change noise could hide;
    `undeclared`: effects that move the force against the sign on their card.
    """

    contender: Contender
    probability: float
    rest_p: float
    held_out: tuple[HeldOut, ...]
    at_bound: tuple[str, ...]
    probability_coarse: float
    alone: float = 1.0
    simulated: bool = True
    faint: tuple[str, ...] = ()
    undeclared: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """Name in tables."""
        return self.contender.label

    @property
    def sound(self) -> bool:
        """Whether its parameters lie inside of their range and its effects do what their cards say."""
        return not self.at_bound and not self.undeclared

    @property
    def closed(self) -> float | None:
        """Share of the held-out gap that closes, over all parts with a gap, NaN-free; None without any."""
        parts = [part for part in self.held_out if part.before > 0.0]
        if not parts:
            return None
        before = sum(part.before**2 for part in parts)
        return 1.0 - float(np.sqrt(sum(part.after**2 for part in parts) / before))

    def objections(self) -> tuple[str, ...]:
        """Return everything that speaks against naming this hypothesis, most serious first."""
        return (*self.flaws(), *self.odds())

    def flaws(self) -> tuple[str, ...]:
        """Return what speaks against it by itself, whatever the others are."""
        found = []
        if self.at_bound:
            found.append(f"{', '.join(self.at_bound)} at the end of the physical range")
        if not self.simulated:
            found.append("its run on a finer lattice finds no equilibrium in any bearable time")
        if self.faint:
            found.append(f"the change by {' and '.join(self.faint)} is within the noise")
        if self.undeclared:
            found.append(f"{' and '.join(self.undeclared)} moves the force against its card")
        if self.rest_p < REST_LEVEL:
            found.append(f"leaves a rest that noise does not explain (p = {self.rest_p:.2g})")
        failing = [part.what for part in self.held_out if part.grows]
        if self.held_out and not any(part.shrinks for part in self.held_out):
            failing = [part.what for part in self.held_out]
        if failing:
            found.append(f"does not predict {', '.join(failing)} when fitted without")
        return tuple(found)

    def odds(self) -> tuple[str, ...]:
        """Return what its probability leaves to others."""
        if self.probability < SURE:
            return (f"probability {probability(self.probability)} is below {SURE:g}",)
        if self.alone < ALONE:
            return (f"probability {probability(self.alone)} to act without others is below {ALONE:g}",)
        return ()


@dataclass(frozen=True)
class Verdict:
    """One of the four verdicts with the effects it is about, and a sentence.

    `ambiguous_with`: effects that may act in place of these; `sets`: all explanations of an ambiguous verdict, the best
    first. `best`: the best finalist, sufficient or not. `lattice_doubt`: nothing is named because the lattice error is
    too large for the gap. `classes`: of every effect found, what neither these channels nor the data tell from it.
    `faults`: faults of the test that explain the gap too; `failed`: directed tests of what no effect changes.
    """

    kind: Answer
    effects: tuple[str, ...]
    ambiguous_with: tuple[str, ...]
    sentence: str
    best: Finalist | None
    lattice_doubt: bool = False
    sets: tuple[tuple[str, ...], ...] = ()
    classes: Classes = ()
    faults: tuple[Fault, ...] = ()
    failed: tuple[Check, ...] = ()


def decide(
    ranking: Ranking, finalists: Sequence[Finalist], *, detected: bool, lattice_doubt: bool,
    confused: Confused = MappingProxyType({}), classes: Classes = (),
    faults: Sequence[Fault] = (), checks: Sequence[Check] = (),
) -> Verdict:  # fmt: skip
    """Return the verdict; `confused`: what every effect is confused with, by its card.

    `classes`: of every effect of the leading hypothesis, what these channels cannot tell from it whatever the data are.
    A name needs decisive odds against each such rival, by a run that found an equilibrium, and against every one of
    `faults`; and no directed test of `checks` that fails.
    """
    if not detected or ranking.of_kind(Kind.NONE) > 0.5:
        return Verdict(
            Answer.NO_GAP, (), (), "Simulation and measurement agree within noise, scatter and lattice error.", None
        )
    if lattice_doubt:
        return Verdict(
            Answer.UNEXPLAINED,
            (),
            (),
            "The lattice error exceeds a third of the gap: refine the case before naming anything.",
            None,
            lattice_doubt=True,
        )
    sound = [item for item in finalists if item.sound]
    if not sound:
        nearest = max(finalists, key=lambda item: item.alone, default=None)
        card = " and as its card says" if any(item.undeclared for item in finalists) else ""
        sentence = f"No effect of the library explains the gap within its physical range{card}."
        return Verdict(Answer.UNEXPLAINED, (), (), sentence, nearest)
    best = max(sound, key=lambda item: item.alone)
    objections = best.objections()
    chances = {item.id: ranking.of_fault(item.id) for item in faults}
    shadows = tuple(item for item in faults if chances[item.id] > 0.0 and DECISIVE * chances[item.id] >= best.alone)
    failed = tuple(item for item in checks if item.failed)
    free = ranking.of_kind(Kind.FREE, Kind.REST) + sum(chances.values())
    classes = classes if tuple(group[0] for group in classes) == best.contender.ids else ()
    open_to = _left_in(classes, best, ranking, finalists)
    rivals = [*_undecided(best, sound, widened(confused, classes)), *_led(best, sound)]
    rivals += [item for item in _members(open_to, best, sound) if item not in rivals]
    if not (objections or rivals or shadows or failed) and all(len(group) == 1 for group in open_to):
        names, sure = " and ".join(best.contender.ids), probability(best.probability)
        verb = "explains" if len(best.contender.ids) == 1 else "together explain"
        return Verdict(
            Answer.NAMED, best.contender.ids, (), f"{names} {verb} the gap (probability {sure}).", best,
            classes=open_to,
        )  # fmt: skip
    adequate = [item for item in sound if item.rest_p >= REST_LEVEL and item.alone >= SHARE * best.alone]
    adequate += [item for item in rivals if item not in adequate]
    told = _told(shadows, failed)
    if objections and (free > 0.5 or not adequate or best.rest_p < REST_LEVEL):
        leads = bool(shadows) and max(chances.values()) > max(best.alone, 0.5)
        against = "a fault of the test explains it better" if leads else objections[0]
        sentence = (
            f"No effect of the library explains the gap; {best.label} comes closest and is not sufficient ({against})."
            f"{told}"
        )
        return Verdict(Answer.UNEXPLAINED, (), (), sentence, best, faults=shadows, failed=failed)
    found = _ambiguous(adequate, best, open_to)
    return replace(found, sentence=found.sentence + told, faults=shadows, failed=failed)


def _told(faults: Sequence[Fault], failed: Sequence[Check]) -> str:
    """Return what faults and failed tests add to a sentence, empty without any."""
    text = f" It may as well be {in_words(faults)}." if faults else ""
    return text + "".join(f" No effect of the library does this: {item.words}." for item in failed)


def _left_in(classes: Classes, best: Finalist, ranking: Ranking, finalists: Sequence[Finalist]) -> Classes:
    """Return the classes without the members that the data rule out: decisive odds, by a run with an equilibrium."""
    lost = {frozenset(item.contender.ids) for item in finalists if not item.simulated}
    bad = {frozenset(item.contender.ids) for item in finalists if item.simulated and item.undeclared}
    ids = set(best.contender.ids)
    least = ranking.probability(best.contender.ids) / DECISIVE
    found = []
    for own, *others in classes:
        sets = {other: frozenset({*ids, other} - {own}) for other in others}
        kept = [
            other for other, rival in sets.items()
            if rival not in bad and (rival in lost or ranking.probability(tuple(rival)) >= least)
        ]  # fmt: skip
        found.append((own, *kept))
    return tuple(found)


def _members(classes: Classes, best: Finalist, sound: Sequence[Finalist]) -> list[Finalist]:
    """Return the finalists that have a member of a class in the place of its first."""
    ids = set(best.contender.ids)
    sets = [{*ids, other} - {own} for own, *others in classes for other in others]
    return [item for item in sound if set(item.contender.ids) in sets]


def _undecided(best: Finalist, sound: Sequence[Finalist], confused: Confused) -> list[Finalist]:
    """Return the hypotheses with one effect for another it is confused with that are not decisively less likely."""
    return [
        item for item in sound
        if item.rest_p >= REST_LEVEL and DECISIVE * item.alone >= best.alone
        and confusable(best.contender.ids, item.contender.ids, confused)
    ]  # fmt: skip


def _led(best: Finalist, sound: Sequence[Finalist]) -> list[Finalist]:
    """Return the adequate hypothesis that led before the refit when the best came up by that alone.

    One that only adds an effect to the best is no other explanation; and sets of three are looked for by the refit
    alone, so the pair in one of them led before.
    """
    if best.probability_coarse >= SHARE:
        return []
    own = set(best.contender.ids)
    return [
        item for item in sound
        if item.probability_coarse >= LED and item.rest_p >= REST_LEVEL and not item.faint
        and not own <= set(item.contender.ids) and not (len(own) > 2 and set(item.contender.ids) < own)
    ]  # fmt: skip


def _ambiguous(adequate: Sequence[Finalist], best: Finalist, classes: Classes = ()) -> Verdict:
    """Return the verdict when several hypotheses stay possible, or one that its held-out score does not confirm.

    A hypothesis that only adds an effect to the best is no other explanation.
    """
    first = best.contender.ids
    rivals = [item for item in adequate if not set(first) <= set(item.contender.ids)]
    sets = (first, *(item.contender.ids for item in rivals))
    members = {name for group in classes for name in group}
    others = tuple(sorted({*members, *(name for ids in sets for name in ids)} - set(first)))
    apart = "".join(f"; these channels cannot tell {own} from {_or(others)}" for own, *others in classes if others)
    if not rivals:
        against = best.objections()
        sentence = f"{_classed(best, classes)} is the best explanation" + (f", but {against[0]}" if against else "")
        return Verdict(Answer.AMBIGUOUS, first, others, f"{sentence}{apart}.", best, sets=sets, classes=classes)
    common = set(first).intersection(*sets)
    certain = (
        f"; {' and '.join(sorted(common))} {'takes' if len(common) == 1 else 'take'} part in all" if common else ""
    )
    sentence = f"{best.label} explains the gap, and so does {_or([item.label for item in rivals])}{certain}{apart}."
    return Verdict(Answer.AMBIGUOUS, first, others, sentence, best, sets=sets, classes=classes)


def _classed(best: Finalist, classes: Classes) -> str:
    """Return the effects of the best as what they are known as: a class is told as a whole, not by its first."""
    groups = {own: (own, *others) for own, *others in classes}
    return " + ".join(_or(groups.get(name, (name,))) for name in best.contender.ids)


def _or(names: Sequence[str]) -> str:
    return " or ".join(names)
