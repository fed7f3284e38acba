"""The strain of the free wire in the loop against the elongation at break of its filaments.

Unlike the paper's criterion it credits a loop with its slack: a span strain e strains the wire by
(1 + e) / (1 + slack) - 1 only. It is the one to compare loops of different slack with.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wires.criteria.span_strain import YIELD
from wires.damage import BUNDLE, FailureResult, Parameter, bundle_damage
from wires.history import WireHistory


@dataclass(frozen=True)
class WireStrain:
    """Strain of the free wire after its slack is taken up; plastic from the yield strain on."""

    name: str = "wire_strain"
    summary: str = "strain of the free wire after its slack is taken up, against the elongation at break"
    parameters: tuple[Parameter, ...] = (*BUNDLE, YIELD)

    def evaluate(self, history: WireHistory, parameters: Mapping[str, float]) -> FailureResult:
        """Return the damage of bundles driven by the wire strain."""
        level = np.full(history.layout.n_loops, parameters["yield_strain"])
        return bundle_damage(
            history, history.wire_strain, yield_strain=level, criterion=self.name, parameters=parameters
        )
