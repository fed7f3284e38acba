"""The paper's own reading: the engineering strain of the fabric span at each loop decides.

It needs no model of the wire in the loop: tests of the fabric with the wires in it gave the strain of the *fabric* at
which filaments break at the clearances (Beex et al., sections 2.3 and 5.2). Slack therefore shifts only the onset of
plastic flow, which begins once the slack is taken up and copper yields.

The 7 % belong to the loops of the paper's coupons. A loop with more slack stands more fabric strain, a pretensioned
specimen less, a wire of thinner filaments less, and the wire in the weave is not looked at: `calibrated` is the reading
that knows these.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from etextile.types import Array
from wires.chances import Chances
from wires.damage import BUNDLE, FailureResult, Parameter, bundle_chances, bundle_damage
from wires.history import WireHistory


YIELD = Parameter(
    "yield_strain",
    0.001,
    "",
    "estimated",
    "soft copper yields at 79 MPa, with a modulus of 70 to 120 GPa at about 0.1 %",
)


@dataclass(frozen=True)
class SpanStrain:
    """Strain of the fabric between exit and entry; plastic from the loop's slack plus the yield strain on."""

    name: str = "span_strain"
    summary: str = "the paper's own reading: fabric strain at each loop, blind to slack, filaments and weave"
    parameters: tuple[Parameter, ...] = (*BUNDLE, YIELD)

    def evaluate(self, history: WireHistory, parameters: Mapping[str, float]) -> FailureResult:
        """Return the damage of bundles driven by the span strain."""
        slack = history.layout.loop_slack
        taken_up = slack + (1.0 + slack) * parameters["yield_strain"]
        return bundle_damage(
            history,
            history.span_strain,
            yield_strain=taken_up,
            criterion=self.name,
            parameters=parameters,
            strain_kind="fabric",
        )

    def chances(
        self, history: WireHistory, parameters: Mapping[str, float], factors: Array
    ) -> tuple[Chances, Chances | None]:
        """Return the chances of the loops given factors (G,) on the strain they stand."""
        return bundle_chances(history.span_strain, parameters, factors), None
