"""The strain of the free wire in the loop against the elongation at break of its filaments.

Unlike the paper's reading it credits a loop with its slack: a span strain e strains the wire by
(1 + e) / (1 + slack) - 1 only. Its onset is an elongation at break of the wire, 7 % unless the case gives another, and
not what the paper's coupons say about loops: those broke at 4.9 % if they had 2 % slack (`calibrated`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from etextile.results.wire_history import WireHistory
from etextile.types import Array
from wires.chances import Chances
from wires.criteria.span_strain import YIELD
from wires.damage import BUNDLE, STRENGTH, CriterionParameter, FailureResult, bundle_chances, bundle_damage


@dataclass(frozen=True)
class WireStrain:
    """Strain of the free wire after its slack is taken up; plastic from the yield strain on."""

    name: str = "wire_strain"
    summary: str = "strain of the free wire after its slack is taken up, against the elongation at break"
    ignores: str = (
        "what the paper's coupons say of loops, the wire in the weave, the length of a loop, bending at its ends, "
        "filaments of unequal length"
    )
    parameters: tuple[CriterionParameter, ...] = (*BUNDLE, YIELD, STRENGTH)
    strain_kind: str = "wire"

    def evaluate(self, history: WireHistory, parameters: Mapping[str, float]) -> FailureResult:
        """Return the damage of bundles driven by the wire strain."""
        level = np.full(history.layout.n_loops, parameters["yield_strain"])
        found = bundle_damage(
            history,
            history.wire_strain,
            yield_strain=level,
            criterion=self.name,
            parameters=_of_this_wire(parameters),
            strain_kind=self.strain_kind,
        )
        return replace(found, parameters=dict(parameters))

    def chances(
        self, history: WireHistory, parameters: Mapping[str, float], factors: Array
    ) -> tuple[Chances, Chances | None]:
        """Return the chances of the loops given factors (G,) on the strain they stand."""
        return bundle_chances(history.wire_strain, _of_this_wire(parameters), factors), None

    def limit(self, parameters: Mapping[str, float]) -> float:
        """Return the wire's own strain at which a loop of this wire loses its first filament."""
        return _of_this_wire(parameters)["onset"]


def _of_this_wire(parameters: Mapping[str, float]) -> dict[str, float]:
    """Return the parameters with the onset of wire of this material and diameter."""
    return {**parameters, "onset": parameters["onset"] * parameters["strength_factor"]}
