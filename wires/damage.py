"""Damage of a loop, whatever criterion finds it: the four states, the breaking of its filaments, the result.

A wire is a bundle of N filaments. The strain measure e that a criterion looks at counts at its greatest value so far,
since broken filaments do not heal. The filaments break over a range of strains described by a Weibull law that starts
at an onset, the strain at which the first filament breaks:

    share broken = 1 - exp(-((e - onset) / scale)^shape)   for e > onset.

The loop is open when less than half a filament is left of the bundle, share > 1 - 0.5 / N. Between specimens the onset
scatters normally about its value (cut off at zero strain); this gives the failure probabilities.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from etextile.types import Array, IntArray
from wires.history import WireHistory, first_crossing, running_maximum
from wires.layout import WireLayout


STATES = ("intact", "plastic", "partial", "open")
INTACT, PLASTIC, PARTIAL, OPEN = range(4)

Origin = Literal["stated", "derived", "estimated"]

_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(33)
"""Gauss-Hermite quadrature over the scatter of the onset."""

T = TypeVar("T", bound=np.generic)


@dataclass(frozen=True)
class Parameter:
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
class FailureResult:
    """What became of L loops over S steps, and of the wires they belong to (each as bad as its worst loop)."""

    criterion: str
    parameters: Mapping[str, float]
    displacement_mm: Array
    """(S,)"""
    state: IntArray
    """(S, L) index into STATES; never decreases."""
    filaments_broken: Array
    """(S, L) expected share of the filaments that is broken; never decreases."""
    first_failure_mm: Array
    """(L,) displacement at which the first filament breaks, interpolated between the steps; NaN when none does."""
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

    @property
    def loop_state(self) -> IntArray:
        """(L,) state at the end."""
        return np.asarray(self.state[-1])

    @property
    def loop_broken(self) -> Array:
        """(L,) share of the filaments broken at the end."""
        return np.asarray(self.filaments_broken[-1])

    @property
    def wire_state(self) -> IntArray:
        """(W,) state of the worst loop at the end; intact for a wire without loops."""
        return self._over_loops(np.maximum, self.loop_state, INTACT)

    @property
    def wire_max_strain(self) -> Array:
        """(W,) greatest strain over the loops; 0 for a wire without loops."""
        return self._over_loops(np.maximum, self.max_strain, 0.0)

    @property
    def wire_broken(self) -> Array:
        """(W,) greatest share of broken filaments over the loops."""
        return self._over_loops(np.maximum, self.loop_broken, 0.0)

    @property
    def wire_first_failure_mm(self) -> Array:
        """(W,) displacement at which the first loop fails; NaN when none does."""
        return self._over_loops(np.fmin, self.first_failure_mm, np.nan)

    @property
    def wire_failure_probability(self) -> Array:
        """(W,) probability that some filament of the wire is broken, loops independent: 1 - prod (1 - p).

        Loops that a symmetry plane mirrors count twice: the wire has them on both sides.
        """
        return self._any_loop(self.failure_probability)

    @property
    def wire_open_probability(self) -> Array:
        """(W,) probability that the wire is interrupted somewhere, loops independent."""
        return self._any_loop(self.open_probability)

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
    def parameters(self) -> tuple[Parameter, ...]:
        """The numbers that a case may set."""

    def evaluate(self, history: WireHistory, parameters: Mapping[str, float]) -> FailureResult:
        """Return the damage; `parameters` holds a value for every entry of `self.parameters`."""


BUNDLE = (
    Parameter(
        "onset",
        0.07,
        "",
        "stated",
        "first filaments break at about 7 % (Beex et al., section 2.3); soft copper wire of 30 um breaks at 7.0 % by a "
        "power law through 9, 10, 13, 17 % at 41, 51, 71, 102 um",
        open_minimum=True,
    ),
    Parameter(
        "scale",
        0.026,
        "",
        "estimated",
        "some filaments of seven broken at 8 %, all near 13 %; mean elongation at break then 9.4 %",
        open_minimum=True,
    ),
    Parameter(
        "shape", 1.2, "", "estimated", "damage sets in abruptly at the onset: between 1 and 1.5", open_minimum=True
    ),
    Parameter(
        "scatter", 0.005, "", "estimated", "standard deviation of the onset between loops, half a per cent of strain"
    ),
    Parameter("filaments", 7, "", "estimated", "six filaments twisted about one", minimum=1),
)
"""Parameters of the filament bundle, shared by the strain criteria."""


def bundle_damage(
    history: WireHistory, strain: Array, *, yield_strain: Array, criterion: str, parameters: Mapping[str, float]
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
