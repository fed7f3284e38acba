"""The wire's own strain, everywhere on it, against the limit that the paper's coupons give.

What is known (Beex et al., sections 2.3 and 5.2): up to 6 % fabric strain wires are plastic but whole, at about 7 % the
first filaments break, at 8 % a substantial part, and breaks are seen at the loops. The 7 % are *fabric* strain over
loops as they were in the coupons. A loop with slack q takes it up first, so the wire's own strain there was

    e_loop = (1 + onset) / (1 + q) - 1                          4.9 % for q = 2 %,

and the wire in the weave, with the crimp k, was at (1 + onset) / (1 + k) - 1, as much for k = 2 %. Equally strained,
the loops broke and the weave did not: at its exit and entry a loop turns out of the weave, which bends the filaments.
With the bending strain b (`wires.bending`, 1.8 % for 2 % slack) on top of e_loop the wire breaks at

    e_loop + b = 6.7 %,

close to the elongation of soft copper wire of 30 um, 7 %. So the weave stands `stress_raiser` = (e_loop + b) / e_loop =
1.37 times the strain that it had when the loops gave way:

    e_weave = stress_raiser ((1 + onset) / (1 + k) - 1)         6.7 %.

In X-ray images filaments are told apart at loops only, so the paper excludes no break in the weave, it saw none. With
these numbers a piece of 16 mm is broken at 6, 7, 8 % with a chance of less than 1, 3 and 35 %, a loop of 3, 50 and
99 %: loops first. The raiser does not depend on slack: at its onset a loop is straight, whatever its slack was.

Slack and crimp of the coupons are estimates. Their standard deviations are doubt about the limit, common to all wires,
and are carried into every probability (`wires.dependence`, c). A case whose loops *are* the coupon's is free of it.
Length counts by the weakest link (`wires.weakest_link`), for a loop by its span, for the weave by each piece
between loops; filament diameter and material by their elongation at break. Pretension is in the strains.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from etextile.results.wire_history import WireHistory
from etextile.types import Array
from etextile.vocabulary import INTACT, OPEN, PARTIAL, PLASTIC
from wires.chances import Chances
from wires.criteria.span_strain import COUPON_SLACK, YIELD
from wires.damage import BUNDLE, SHARED, STRENGTH, CriterionParameter, FailureResult
from wires.history import first_crossing, running_maximum
from wires.weakest_link import BreakLaw, links
from wires.woven import WovenPieces


_OF_BUNDLE = {parameter.name: parameter for parameter in BUNDLE}

PARAMETERS = (
    CriterionParameter(
        "onset",
        0.07,
        "",
        "stated",
        "fabric strain at which first filaments break in the coupons, about 7 % (Beex et al., section 2.3)",
        open_minimum=True,
    ),
    CriterionParameter(
        "coupon_slack", COUPON_SLACK, "", "estimated", "slack of the coupons' loops; their photograph is lost"
    ),
    CriterionParameter(
        "coupon_slack_std",
        0.005,
        "",
        "estimated",
        "doubt about it: below 4 %, since loops are seen flowing plastically at 6 % fabric strain, and above 0",
    ),
    CriterionParameter("coupon_crimp", 0.02, "", "estimated", "excess length of the wire in the coupons' weave"),
    CriterionParameter("coupon_crimp_std", 0.005, "", "estimated", "doubt about it, as about the slack"),
    CriterionParameter(
        "stress_raiser",
        1.37,
        "",
        "derived",
        "strain at exit and entry of a loop over that of the wire: (4.9 % + 1.8 % bending) / 4.9 %",
        minimum=1.0,
    ),
    CriterionParameter(
        "stress_raiser_std", 0.1, "", "estimated", "doubt about its logarithm: the bending turns over one to two cells"
    ),
    CriterionParameter(
        "weibull_shape",
        15,
        "",
        "estimated",
        "scatter along the wire and between loops, coefficient of variation about 8 %; a case takes it from its wire "
        "material",
        open_minimum=True,
    ),
    CriterionParameter(
        "reference_length",
        4.0,
        "mm",
        "estimated",
        "length of the coupons' loops, some millimetres (Beex et al., section 2.1)",
        open_minimum=True,
    ),
    CriterionParameter(
        "length_exponent",
        1.0,
        "",
        "estimated",
        "links = (length / reference)^exponent, 1 for the plain weakest link; published yarn lives ask for 2.28",
    ),
    CriterionParameter(
        "scale",
        0.026,
        "",
        "estimated",
        "fabric strain beyond the onset over which 63 % of a coupon's filaments break: some of seven at 8 %, all near "
        "13 %",
        open_minimum=True,
    ),
    _OF_BUNDLE["shape"],
    _OF_BUNDLE["filaments"],
    YIELD,
    STRENGTH,
    *SHARED,
)


@dataclass(frozen=True)
class Calibrated:
    """The wire's own strain in loops and weave, against onsets worked out from the paper's coupons."""

    name: str = "calibrated"
    summary: str = "the wire's own strain in loops and weave, its limit worked out from the paper's coupons"
    ignores: str = (
        "how sharply a loop of this case bends (its limit holds the bending of the coupons' loops), filaments of "
        "unequal length, wear of the metal (cycles to failure have their own law)"
    )
    parameters: tuple[CriterionParameter, ...] = PARAMETERS
    strain_kind: str = "wire"

    def evaluate(self, history: WireHistory, parameters: Mapping[str, float]) -> FailureResult:
        """Return the damage of typical loops."""
        worst = running_maximum(np.maximum(history.wire_strain, 0.0))
        ratio = worst / loop_onsets(history, parameters)
        width, growth = law_of(parameters).width, parameters["shape"]
        share = -np.expm1(-((np.maximum(ratio - 1.0, 0.0) / width) ** growth))
        state = np.select(
            [share > 1.0 - 0.5 / parameters["filaments"], ratio >= 1.0, worst >= parameters["yield_strain"]],
            [OPEN, PARTIAL, PLASTIC],
            INTACT,
        )
        law = law_of(parameters)
        return FailureResult(
            criterion=self.name,
            parameters=dict(parameters),
            displacement_mm=history.displacement_mm,
            state=state,
            filaments_broken=share,
            first_failure_mm=first_crossing(history.displacement_mm, ratio, 1.0),
            max_strain=worst[-1],
            failure_probability=law.broken(ratio[-1]),
            open_probability=law.opened(ratio[-1]),
            layout=history.layout,
            strain_kind=self.strain_kind,
        )

    def limit(self, parameters: Mapping[str, float]) -> float:
        """Return the wire's own strain at which a coupon's loop of this wire loses its first filament."""
        return own_onset(parameters) * parameters["strength_factor"]

    def chances(
        self, history: WireHistory, parameters: Mapping[str, float], factors: Array
    ) -> tuple[Chances, Chances | None]:
        """Return the chances of loops and of woven pieces given factors (G,) on the strain they stand."""
        law = law_of(parameters)
        loops = running_maximum(np.maximum(history.wire_strain, 0.0)) / loop_onsets(history, parameters)
        pieces = WovenPieces.of(history)
        strain = pieces.mean(history.element_strain, parameters["weibull_shape"])
        woven = running_maximum(strain) / woven_onsets(pieces, parameters)
        return _given(law, loops, factors), _given(law, woven, factors)

    def doubt(self, parameters: Mapping[str, float]) -> tuple[float, float]:
        """Return the standard deviations of ln onset of loops and weave that the coupons' slack and crimp leave.

        To first order: d ln e / d q = -(1 + onset) / ((1 + q)^2 e).
        """
        onset = parameters["onset"]
        loops = parameters["coupon_slack_std"] * _sensitivity(onset, parameters["coupon_slack"])
        woven = parameters["coupon_crimp_std"] * _sensitivity(onset, parameters["coupon_crimp"])
        return loops, float(np.hypot(woven, parameters["stress_raiser_std"]))


def own_onset(parameters: Mapping[str, float]) -> float:
    """Return the wire's own strain at which half of the coupon's loops have lost a filament, e_loop."""
    return (1.0 + parameters["onset"]) / (1.0 + parameters["coupon_slack"]) - 1.0


def woven_onset(parameters: Mapping[str, float]) -> float:
    """Return the wire's own strain at which as long a piece of it in the weave has, e_weave."""
    return parameters["stress_raiser"] * ((1.0 + parameters["onset"]) / (1.0 + parameters["coupon_crimp"]) - 1.0)


def law_of(parameters: Mapping[str, float]) -> BreakLaw:
    """Return the law of breaking; its width is the scale as a share of the onset, both in the wire."""
    width = parameters["scale"] / (1.0 + parameters["coupon_slack"]) / own_onset(parameters)
    return BreakLaw(parameters["weibull_shape"], width, parameters["shape"], round(parameters["filaments"]))


def loop_onsets(history: WireHistory, parameters: Mapping[str, float]) -> Array:
    """Return the median own strain (L,) at which loops lose their first filament."""
    return own_onset(parameters) * _stood(history.layout.loop_span_mm, parameters)


def woven_onsets(pieces: WovenPieces, parameters: Mapping[str, float]) -> Array:
    """Return the median own strain (P,) at which pieces in the weave lose their first filament."""
    return woven_onset(parameters) * _stood(pieces.length_mm, parameters)


def _stood(length_mm: Array, parameters: Mapping[str, float]) -> Array:
    """Return the factor of length, material and diameter on the strain that pieces of wire stand."""
    count = links(length_mm, parameters["reference_length"], parameters["length_exponent"])
    return parameters["strength_factor"] * np.maximum(count, 1e-12) ** (-1.0 / parameters["weibull_shape"])


def _given(law: BreakLaw, ratio: Array, factors: Array) -> Chances:
    given = ratio / factors[:, None, None]
    return Chances(law.broken(given), law.opened(given), law.share(given))


def _sensitivity(onset: float, excess: float) -> float:
    """Return -d ln e / d excess of e = (1 + onset) / (1 + excess) - 1."""
    return (1.0 + onset) / ((1.0 + excess) * (onset - excess)) if onset > excess else 0.0
