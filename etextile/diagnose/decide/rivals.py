"""Explanations that have one effect for another with which its card says it is confused.

The two differ by the form of their laws, which no library knows exactly: where the hidden form is another, odds of some
hundred turn up for a wrong one. So such a rival is simulated for itself (`refit`), and a name needs decisive odds
against it (`verdict`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence


# Odds that a name needs against such a rival.
DECISIVE = 1000.0

Confused = Mapping[str, Sequence[str]]
"""What every effect is confused with, by its card."""


def confusable(ids: Sequence[str], others: Sequence[str], confused: Confused) -> bool:
    """Tell whether two sets of effects differ by one that either card says is confused with the other."""
    own, other = set(ids) - set(others), set(others) - set(ids)
    if len(own) != 1 or len(other) != 1:
        return False
    (a,), (b,) = own, other
    return b in confused.get(a, ()) or a in confused.get(b, ())
