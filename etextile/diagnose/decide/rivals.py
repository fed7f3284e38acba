"""Explanations that have one effect for another that it is confused with, by its card or because channels cannot tell.

The two differ by the form of their laws, which no library knows exactly: where the hidden form is another, odds of some
hundred turn up for a wrong one. So such a rival is simulated for itself (`refit`), and a name needs decisive odds
against it (`verdict`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from etextile.diagnose.decide.rank import Contender, Ranking


# Odds that a name needs against such a rival.
DECISIVE = 1000.0
# A hypothesis that comes up when others are refitted is refitted too from this probability on.
COMES_UP = 0.05

Confused = Mapping[str, Sequence[str]]
"""What every effect is confused with: by its card, or because the measured channels cannot tell it (`classes`)."""


def widened(confused: Confused, groups: Sequence[Sequence[str]]) -> dict[str, tuple[str, ...]]:
    """Return what effects are confused with when the members of `groups`, an effect first in each, are added to it."""
    found = {name: tuple(others) for name, others in confused.items()}
    for name, *others in groups:
        found[name] = tuple(dict.fromkeys((*found.get(name, ()), *others)))
    return found


def confusable(ids: Sequence[str], others: Sequence[str], confused: Confused) -> bool:
    """Tell whether two sets of effects differ by one that is confused with the other."""
    own, other = set(ids) - set(others), set(others) - set(ids)
    if len(own) != 1 or len(other) != 1:
        return False
    (a,), (b,) = own, other
    return b in confused.get(a, ()) or a in confused.get(b, ())


def possible(ranking: Ranking, confused: Confused) -> list[Contender]:
    """Return the hypotheses that may be the verdict, and those the best is confused with short of decisive odds."""
    if not ranking.effects:
        return []
    first = ranking.effects[0].ids
    least = ranking.probability(first) / DECISIVE
    probable = [(item, ranking.probability(item.ids)) for item in ranking.effects]
    return [item for item, p in probable if p > COMES_UP or (p >= least and confusable(first, item.ids, confused))]
