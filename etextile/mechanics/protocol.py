"""What every part of a model offers the solver: an incremental energy with its gradient and tangent.

A contribution is data; `respond` evaluates it at trial positions without side effects and returns a `Response`, which
hands out energy, gradient, tangent and the state to keep if the trial becomes a converged increment. So cutting an
increment back is dropping a response, and a contribution never knows about Newton, increments or files.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

from etextile.mechanics.onesided import OneSided
from etextile.types import Array, IntArray


@dataclass(frozen=True)
class Energy:
    """Energies of the modelled part in N mm: recoverable, plastic (with damage), friction; contact is the penalty's."""

    stored: float = 0.0
    plastic: float = 0.0
    friction: float = 0.0
    contact: float = 0.0

    def __add__(self, other: Energy) -> Energy:
        """Return the sum, part by part."""
        return Energy(
            self.stored + other.stored,
            self.plastic + other.plastic,
            self.friction + other.friction,
            self.contact + other.contact,
        )


@dataclass(frozen=True)
class Fields:
    """What a result file holds of M elements: engineering strain, stress MPa, plastic Hencky strain, force N; (M,)."""

    strain: Array
    stress: Array
    plastic: Array
    force: Array


class Response(ABC):
    """A contribution evaluated at one trial."""

    @property
    @abstractmethod
    def state(self) -> Any:
        """State to carry over when the trial converges."""

    @abstractmethod
    def energy(self) -> Energy:
        """Return the energies at the trial, N mm."""

    @abstractmethod
    def add_gradient(self, gradient: Array) -> None:
        """Add the derivative of the incremental energy to `gradient` (P, 3), N."""

    @abstractmethod
    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add the tangent, N/mm, to the upper-triangular pattern values.

        `exact` False asks for its positive semidefinite part; trusses add `damping` times their unit Laplacian.
        """

    @property
    def driving_force(self) -> float:
        """Force that works on the punch travel, N (0 unless something rides on the punch)."""
        return 0.0

    @property
    def force_onward(self) -> float:
        """The driving force of the motion that begins where another ends."""
        return self.driving_force

    @property
    def load(self) -> float | None:
        """Resultant along the direction of the motion where the travel is a load and no displacement, N."""
        return None

    @property
    def fields(self) -> Fields | None:
        """Strains and forces of elements that stand in the result file."""
        return None

    @property
    def softening(self) -> int:
        """Number of taut elements whose force falls with length."""
        return 0

    @property
    def giving_way(self) -> str:
        """What of this part bears less the further it is pulled, in words; '' for nothing."""
        return ""

    @property
    def penetration(self) -> float:
        """Largest penetration of a node into a body, mm."""
        return 0.0

    def reached_from(self, previous: Response) -> Response:
        """Return this response as the one that a step from `previous` led to; only its tangent may depend on that."""
        return self

    def add_contact_force(self, force: Array) -> None:  # noqa: B027 (most parts touch nothing)
        """Add contact forces on the fabric to `force` (P, 3), N."""

    def add_support_force(self, force: Array) -> None:  # noqa: B027 (most parts hold nothing)
        """Add forces on the fabric from supports that stand still but give way to `force` (P, 3), N."""


class Contribution(ABC):
    """A part of the model: trusses, wires, contact, springs.

    `nodes` (n, k) are the node numbers of its elements; the nodes of an element are all coupled in the tangent.
    """

    name: str
    nodes: IntArray
    onset_power: float = 2.0
    """Power of the travel with which the driving force of flat fabric rises (a punch: 2)."""

    @abstractmethod
    def initial_state(self) -> Any:
        """Return the virgin state."""

    @abstractmethod
    def respond(self, x: Array, travel: float, state: Any) -> Response:
        """Evaluate at node positions x (P, 3) mm and punch travel (mm), starting from the last converged state."""

    @property
    def longest_step(self) -> float:
        """Largest travel (mm) one increment may take without this part losing sight of what happens in between."""
        return math.inf

    def touched(self, response: Any, state: Any, x_last: Array, travel_last: float) -> Any:
        """Return the state to start the increment from again, knowing what it brought to touch; the same if nothing."""
        return state

    def haste(self, response: Any, state: Any) -> float:
        """Return what the increment changes for good, as a share of the most it may before the order in it matters."""
        return 0.0

    def tightened(self, response: Any, state: Any) -> Any:
        """Return a stricter start state when a converged trial passes a limit of this part, else `state` itself."""
        return state

    def among(self, elements: IntArray, number: IntArray) -> Contribution | None:
        """Return `elements` alone, nodes renumbered by `number` (P,); None when the parts of this one hang together."""
        return None

    def state_among(self, state: Any, elements: IntArray) -> Any:
        """Return the part of the state that belongs to `elements`; asked only where `among` gives something."""
        return state

    def one_sided(self, response: Any, state: Any) -> OneSided | None:
        """Return the elements of a trial that bear in one sense only; None when the contribution has none."""
        return None

    def carried_along(self, x: Array, travel: float, x_last: Array, travel_last: float) -> Array:
        """Return predicted positions x (P, 3) corrected for what moves with the punch."""
        return x
