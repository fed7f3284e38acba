"""The paper's own reading: the engineering strain of the fabric span at each loop decides.

It needs no model of the wire in the loop: tests of the fabric with the wires in it gave the strain of the *fabric* at
which filaments break at the clearances (Beex et al., sections 2.3 and 5.2). Slack therefore shifts only the onset of
plastic flow, which begins once the slack is taken up and copper yields.

The 7 % belong to the loops of the paper's coupons. A loop with more slack stands more fabric strain, a pretensioned
specimen less, and the wire in the weave is not looked at: `calibrated` is the reading that knows these. Of the wire
itself it knows how far its filaments stretch, since the paper's coupons say nothing of others: with the slack q of the
coupons' loops and the elongation at break f times that of their filaments, the fabric strain at the onset is

    onset' = q + f (onset - q),

the wire's own strain there, (1 + onset') / (1 + q) - 1, being f times what it was.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from etextile.results.wire_history import WireHistory
from etextile.types import Array
from wires.chances import Chances
from wires.damage import BUNDLE, STRENGTH, CriterionParameter, FailureResult, bundle_chances, bundle_damage


YIELD = CriterionParameter(
    "yield_strain",
    0.001,
    "",
    "estimated",
    "soft copper yields at 79 MPa, with a modulus of 70 to 120 GPa at about 0.1 %",
)

COUPON_SLACK = 0.02
"""Slack of the loops in the paper's coupons, estimated."""


@dataclass(frozen=True)
class SpanStrain:
    """Strain of the fabric between exit and entry; plastic from the loop's slack plus the yield strain on."""

    name: str = "span_strain"
    summary: str = "the paper's own reading: fabric strain at each loop, blind to slack and weave"
    ignores: str = (
        "slack and crimp of the case's own wires, pretension, the wire in the weave, the length of a loop, bending at "
        "its ends, filaments of unequal length"
    )
    parameters: tuple[CriterionParameter, ...] = (*BUNDLE, YIELD, STRENGTH)
    strain_kind: str = "fabric"

    def evaluate(self, history: WireHistory, parameters: Mapping[str, float]) -> FailureResult:
        """Return the damage of bundles driven by the span strain."""
        slack = history.layout.loop_slack
        taken_up = slack + (1.0 + slack) * parameters["yield_strain"]
        found = bundle_damage(
            history,
            history.span_strain,
            yield_strain=taken_up,
            criterion=self.name,
            parameters=_of_this_wire(parameters),
            strain_kind=self.strain_kind,
        )
        return replace(found, parameters=dict(parameters))

    def chances(
        self, history: WireHistory, parameters: Mapping[str, float], factors: Array
    ) -> tuple[Chances, Chances | None]:
        """Return the chances of the loops given factors (G,) on the strain they stand."""
        return bundle_chances(history.span_strain, _of_this_wire(parameters), factors), None

    def limit(self, parameters: Mapping[str, float]) -> float:
        """Return the fabric strain at which a loop of this wire loses its first filament."""
        return _of_this_wire(parameters)["onset"]


def _of_this_wire(parameters: Mapping[str, float]) -> dict[str, float]:
    """Return the parameters with the onset of wire of this material and diameter."""
    onset = parameters["onset"]
    slack = COUPON_SLACK if onset > COUPON_SLACK else 0.0
    return {**parameters, "onset": slack + parameters["strength_factor"] * (onset - slack)}
