"""Damage of the parts of a wire, whatever criterion finds it: states, breaking of filaments, the result.

A wire is a bundle of N filaments. The strain measure e that a criterion looks at counts at its greatest value so far,
since broken filaments do not heal. In the older readings (`span_strain`, `wire_strain`) the filaments break over a
range of strains described by a Weibull law that starts at an onset, the strain at which the first filament breaks:

    share broken = 1 - exp(-((e - onset) / scale)^shape)   for e > onset.

The loop is open when less than half a filament is left of the bundle, share > 1 - 0.5 / N. Between loops the onset
scatters normally about its value (cut off at zero strain).

A criterion alone says what becomes of a typical wire (`Criterion.evaluate`). What is reported is the judgement of
`wires.judge`, whose states follow from probabilities over all scatter: intact or plastic while the probability that a
filament is broken is below `WHOLE_BELOW` of `wires.chances`, open from `OPEN_FROM` on for the probability that all are,
partial between.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from etextile.results.wire_history import WireHistory
from etextile.types import Array, IntArray
from etextile.vocabulary import INTACT, OPEN, PARTIAL, PLASTIC
from wires.chances import Chances
from wires.history import first_crossing, running_maximum
from wires.layout import WireLayout
from wires.reliability import Reliability
from wires.woven import WovenPieces


Origin = Literal["stated", "derived", "estimated"]

_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(33)
"""Gauss-Hermite quadrature over the scatter of the onset."""

T = TypeVar("T", bound=np.generic)


@dataclass(frozen=True)
class CriterionParameter:
    """A number of a criterion: default, unit, where the default comes from and what is allowed."""

    name: str
    default: float
    unit: str
    origin: Origin
    """'stated' in the paper, 'derived' from what is stated, or 'estimated' by us."""
    source: str
    minimum: float = 0.0
    open_minimum: bool = False
    """True when the minimum itself is not allowed."""


@dataclass(frozen=True)
class WovenResult:
    """What became of the P pieces of wire in the weave."""

    pieces: WovenPieces
    state: IntArray
    """(S, P) index into STATES."""
    max_strain: Array
    """(P,) greatest strain of the wire along the piece."""
    failure_probability: Array
    """(P,) probability that at least one filament is broken somewhere on the piece."""
    open_probability: Array
    """(P,) probability that all are, at one place of it."""
    first_failure_mm: Array
    """(P,) displacement at which that first probability passes one half; NaN when it does not."""


@dataclass(frozen=True)
class WireChances:
    """States (S, W) of whole wires and their probabilities (W,) of a broken filament and of an interruption."""

    state: IntArray
    failure: Array
    opened: Array


@dataclass(frozen=True)
class FailureResult:
    """What became of L loops over S steps, and of the wires they belong to."""

    criterion: str
    parameters: Mapping[str, float]
    displacement_mm: Array
    """(S,)"""
    state: IntArray
    """(S, L) index into STATES; never decreases."""
    filaments_broken: Array
    """(S, L) expected share of the filaments that is broken; never decreases."""
    first_failure_mm: Array
    """(L,) displacement at which the first filament breaks (in half of all loops like this), interpolated between the
    steps; NaN when none does."""
    max_strain: Array
    """(L,) greatest value of the criterion's strain measure."""
    failure_probability: Array
    """(L,) probability that at least one filament is broken at the end."""
    open_probability: Array
    """(L,) probability that all filaments are broken at the end."""
    layout: WireLayout
    exit_strain: Array | None = None
    """(L,) bending strain at the loop's ends, from criteria that look at it."""
    broken_counts: Array | None = None
    """(L, N + 1) probability that k of N filaments are broken at the end, from criteria that count them."""
    strain_kind: str = ""
    """Which strain `max_strain` is: `wire` (the wire's own), `fabric` (of the span), or what an own criterion says."""
    open_mm: Array | None = None
    """(L,) displacement at which the loop opens, NaN when it does not; from a judgement."""
    woven: WovenResult | None = None
    """The pieces in the weave, from a judgement by a criterion that looks at them."""
    wires: WireChances | None = None
    """Whole wires with everything they share, from a judgement."""
    reliability: Reliability | None = None
    """The garment as a whole, from a judgement."""
    filaments: Array | None = None
    """(W,) number of filaments of each wire, where wires are of different makes."""

    @property
    def loop_filaments(self) -> Array:
        """(L,) number of filaments of the wire of each loop."""
        if self.filaments is not None:
            return np.asarray(np.rint(self.filaments[self.layout.loop_wire]))
        return np.full(self.layout.n_loops, float(round(self.parameters["filaments"])))

    @property
    def loop_state(self) -> IntArray:
        """(L,) state at the end."""
        return np.asarray(self.state[-1])

    @property
    def loop_broken(self) -> Array:
        """(L,) share of the filaments broken at the end."""
        return np.asarray(self.filaments_broken[-1])

    @property
    def wire_states(self) -> IntArray:
        """(S, W) state of each wire: from its own probabilities, or that of the worst loop without a judgement."""
        if self.wires is not None:
            return self.wires.state
        worst = np.zeros((self.layout.n_wires, len(self.state)), dtype=np.int64)
        np.maximum.at(worst, self.layout.loop_wire, self.state.T)
        return worst.T

    @property
    def wire_state(self) -> IntArray:
        """(W,) state at the end; intact for a wire without loops."""
        return np.asarray(self.wire_states[-1])

    @property
    def wire_max_strain(self) -> Array:
        """(W,) greatest strain over the loops, and over the weave where it is judged; 0 for a wire without either."""
        found = self._over_loops(np.maximum, self.max_strain, 0.0)
        if self.woven is not None:
            np.maximum.at(found, self.woven.pieces.wire, self.woven.max_strain)
        return found

    @property
    def wire_broken(self) -> Array:
        """(W,) greatest share of broken filaments over the loops."""
        return self._over_loops(np.maximum, self.loop_broken, 0.0)

    @property
    def wire_first_failure_mm(self) -> Array:
        """(W,) displacement at which the first loop or woven piece fails; NaN when none does."""
        found = self._over_loops(np.fmin, self.first_failure_mm, np.nan)
        if self.woven is not None:
            np.fmin.at(found, self.woven.pieces.wire, self.woven.first_failure_mm)
        return found

    @property
    def wire_failure_probability(self) -> Array:
        """(W,) probability that some filament of the wire is broken.

        From a judgement with what its parts share; else for loops alone, independent: 1 - prod (1 - p). Loops that a
        symmetry plane mirrors count twice: the wire has them on both sides.
        """
        return self._any_loop(self.failure_probability) if self.wires is None else self.wires.failure

    @property
    def wire_open_probability(self) -> Array:
        """(W,) probability that the wire is interrupted somewhere, as `wire_failure_probability`."""
        return self._any_loop(self.open_probability) if self.wires is None else self.wires.opened

    def _any_loop(self, probability: Array) -> Array:
        survival = (1.0 - probability) ** self.layout.loop_copies
        return 1.0 - self._over_loops(np.multiply, survival, 1.0)

    def _over_loops(self, reduce: np.ufunc, values: NDArray[T], empty: float) -> NDArray[T]:
        result = np.full(self.layout.n_wires, empty, dtype=values.dtype)
        reduce.at(result, self.layout.loop_wire, values)
        return result


class Criterion(Protocol):
    """A failure criterion: a pure function from histories to damage, and the numbers it needs."""

    @property
    def name(self) -> str:
        """Name in case files."""

    @property
    def summary(self) -> str:
        """One line for `etextile list criteria`."""

    @property
    def parameters(self) -> tuple[CriterionParameter, ...]:
        """The numbers that a case may set."""

    def evaluate(self, history: WireHistory, parameters: Mapping[str, float]) -> FailureResult:
        """Return the damage of a typical wire; `parameters` holds a value for every entry of `self.parameters`."""


@runtime_checkable
class JudgedDirectly(Protocol):
    """A criterion that gives the probabilities over all steps itself; others are evaluated step by step."""

    def chances(
        self, history: WireHistory, parameters: Mapping[str, float], factors: Array
    ) -> tuple[Chances, Chances | None]:
        """Return the chances of loops, and of woven pieces where it looks at them, given `factors` (G,)."""


GARMENT = CriterionParameter(
    "garment_scatter",
    0.05,
    "",
    "estimated",
    "standard deviation between garments of the logarithm of the strain that wires stand, between spools; a case takes "
    "it from scatter.strength",
)
WIRE = CriterionParameter(
    "wire_scatter", 0.03, "", "estimated", "the same between the wires of a garment: twist, and how they were fed"
)
SHARED = (GARMENT, WIRE)
"""What parts of a wire and wires of a garment share (`wires.dependence`); a criterion that lists them is judged so."""

STRENGTH = CriterionParameter(
    "strength_factor",
    1.0,
    "",
    "derived",
    "elongation at break of this wire over that of the coupons' (soft copper, 30 um, on one gauge); a case takes it "
    "from its wire material and filament diameter",
    open_minimum=True,
)


BUNDLE = (
    CriterionParameter(
        "onset",
        0.07,
        "",
        "stated",
        "first filaments break at about 7 % (Beex et al., section 2.3); soft copper wire of 30 um breaks at 7.0 % by a "
        "power law through 9, 10, 13, 17 % at 41, 51, 71, 102 um",
        open_minimum=True,
    ),
    CriterionParameter(
        "scale",
        0.026,
        "",
        "estimated",
        "some filaments of seven broken at 8 %, all near 13 %; mean elongation at break then 9.4 %",
        open_minimum=True,
    ),
    CriterionParameter(
        "shape", 1.2, "", "estimated", "damage sets in abruptly at the onset: between 1 and 1.5", open_minimum=True
    ),
    CriterionParameter(
        "scatter", 0.005, "", "estimated", "standard deviation of the onset between loops, half a per cent of strain"
    ),
    CriterionParameter("filaments", 7, "", "estimated", "six filaments twisted about one", minimum=1),
)
"""Parameters of the filament bundle, shared by the older strain criteria."""


def bundle_damage(
    history: WireHistory,
    strain: Array,
    *,
    yield_strain: Array,
    criterion: str,
    parameters: Mapping[str, float],
    strain_kind: str = "",
) -> FailureResult:
    """Return the damage of bundles driven by `strain` (S, L) that flow plastically from `yield_strain` (L,) on."""
    worst = running_maximum(np.maximum(strain, 0.0))
    final = worst[-1]
    broken = share_broken(worst, parameters["onset"], parameters)
    state = np.select(
        [broken > 1.0 - 0.5 / parameters["filaments"], worst >= parameters["onset"], worst >= yield_strain],
        [OPEN, PARTIAL, PLASTIC],
        INTACT,
    )
    return FailureResult(
        criterion=criterion,
        parameters=dict(parameters),
        displacement_mm=history.displacement_mm,
        state=state,
        filaments_broken=broken,
        first_failure_mm=first_crossing(history.displacement_mm, worst, parameters["onset"]),
        max_strain=final,
        failure_probability=onset_probability(final, parameters["onset"], parameters["scatter"]),
        open_probability=open_probability(final, parameters),
        layout=history.layout,
        strain_kind=strain_kind,
    )


def bundle_chances(strain: Array, parameters: Mapping[str, float], factors: Array) -> Chances:
    """Return the chances of bundles driven by `strain` (S, L), given factors (G,) on the strain they stand."""
    worst = running_maximum(np.maximum(strain, 0.0)) / factors[:, None, None]
    return Chances(
        broken=onset_probability(worst, parameters["onset"], parameters["scatter"]),
        opened=open_probability(worst, parameters),
        share=share_broken(worst, parameters["onset"], parameters),
    )


def share_broken(strain: Array, onset: float | Array, parameters: Mapping[str, float]) -> Array:
    """Return 1 - exp(-((e - onset) / scale)^shape), 0 up to the onset."""
    beyond = np.maximum(strain - onset, 0.0) / parameters["scale"]
    return -np.expm1(-(beyond ** parameters["shape"]))


def onset_probability(strain: Array, onset: float, scatter: float) -> Array:
    """Return P(onset <= e) for an onset spread normally about its value and cut off at zero strain."""
    if scatter == 0.0:
        return np.where(strain >= onset, 1.0, 0.0)
    nothing = ndtr(-onset / scatter)
    probability: Array = (ndtr((strain - onset) / scatter) - nothing) / (1.0 - nothing)
    return np.clip(probability, 0.0, 1.0)


def open_probability(strain: Array, parameters: Mapping[str, float]) -> Array:
    """Return P(all N filaments broken) = mean of share^N over the scatter of the onset (Gauss-Hermite quadrature)."""
    onsets = np.maximum(parameters["onset"] + parameters["scatter"] * _NODES, 0.0)
    share = share_broken(strain[..., None], onsets, parameters)
    mean: Array = (share ** parameters["filaments"]) @ (_WEIGHTS / _WEIGHTS.sum())
    return np.clip(mean, 0.0, 1.0)
