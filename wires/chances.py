"""Chances of a part of a wire: what criteria give, and the limits from which states follow."""

from __future__ import annotations

from dataclasses import dataclass

from etextile.types import Array


WHOLE_BELOW = 0.05
"""Probability that a filament is broken below which a part of a wire is called intact or plastic."""
OPEN_FROM = 0.5
"""Probability that all filaments are broken from which on it is called open."""


@dataclass(frozen=True)
class Chances:
    """Probabilities of n parts over S steps, given G factors on the strain they stand: (G, S, n) each."""

    broken: Array
    """That at least one filament is broken."""
    opened: Array
    """That all are."""
    share: Array
    """Expected share of broken filaments."""
