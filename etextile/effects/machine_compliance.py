r"""A spring in series with the punch: load cell, frame and punch give, so the body moves less than is recorded.

The true travel q becomes an unknown of its own, the first component of an extra point. The recorded displacement d ends
at a spring of compliance c per force on the whole specimen, so with the force factor m of the modelled part

    U = (d - q)^2 / (2 m c) + contact(x, q),      F = (d - q) / (m c)  on the part,  d = q + c (m F).

Recorded displacements are met exactly and energy, line search and tangent stay consistent: the contact depends on
x - q n, so its blocks B spread to the new unknown as -B n and n.B n.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from etextile.contact.contact import Contact
from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.errors import BadInput
from etextile.mechanics.kernels import add_dense_blocks
from etextile.mechanics.model import Model
from etextile.mechanics.onesided import OneSided
from etextile.mechanics.protocol import Contribution, Energy, Response
from etextile.types import Array, IntArray


NO_PAIRS = np.zeros((0, 0, 3), dtype=np.int64)


@dataclass(frozen=True)
class SprungContact(Contribution):
    """A contact whose body hangs on a spring (N/mm, of the modelled part); `machine` is the point with the travel.

    nodes (n, 2): candidates of the contact, each with the machine point.
    """

    nodes: IntArray
    contact: Contact
    machine: int
    stiffness: float
    name: str = "contact"

    @property
    def longest_step(self) -> float:
        """Largest travel of one increment, mm: the contact's, since the body moves no farther than the record."""
        return self.contact.longest_step

    def initial_state(self) -> Any:
        """Return the virgin state of the contact."""
        return self.contact.initial_state()

    def respond(self, x: Array, travel: float, state: Any) -> SprungResponse:
        """Evaluate the contact at the true travel and the spring between it and the recorded one."""
        true = float(x[self.machine, 0])
        return SprungResponse(self, self.contact.respond(x, true, state), self.stiffness * (travel - true))

    def one_sided(self, response: SprungResponse, state: Any) -> OneSided | None:
        """Return the contact's one-sided elements."""
        inner = self.contact.one_sided(response.inner, state)
        return None if inner is None else SprungNodes(response, inner)

    def alone(self, points: int) -> tuple[IntArray, Array]:
        """Return places of the diagonals, and room, for the contact's node blocks in a pattern of nothing else."""
        own = np.zeros(3 * points, dtype=np.int64)
        first = 6 * np.arange(len(self.contact.nodes))
        for row, start in enumerate((0, 3, 5)):
            own[3 * self.contact.nodes[:, 0] + row] = first + start
        return own, np.zeros(6 * len(self.contact.nodes))

    def spread(self, upper: Array, rows: IntArray, pairs: IntArray, values: Array) -> None:
        """Add the contact's node blocks `upper` to the nodes and the travel, and the spring."""
        direct = upper.reshape(-1, 6)[:, [0, 1, 2, 1, 3, 4, 2, 4, 5]].reshape(-1, 3, 3)
        towards = direct @ self.contact.direction
        coupled = np.zeros((len(self.nodes), 6, 6))
        coupled[:, :3, :3] = direct
        coupled[:, :3, 3] = coupled[:, 3, :3] = -towards
        coupled[:, 3, 3] = towards @ self.contact.direction
        add_dense_blocks(self.nodes, coupled, rows, pairs, values)
        values[rows[3 * self.machine]] += self.stiffness

    def tightened(self, response: SprungResponse, state: Any) -> Any:
        """Return the contact's stricter state."""
        return self.contact.tightened(response.inner, state)

    def touched(self, response: SprungResponse, state: Any, x_last: Array, travel_last: float) -> Any:
        """Return the contact's state with anchors of nodes that touch first; the body's own travel is an unknown."""
        return self.contact.touched(response.inner, state, x_last, float(x_last[self.machine, 0]))

    def carried_along(self, x: Array, travel: float, x_last: Array, travel_last: float) -> Array:
        """Return positions moved with the body, whose own travel is predicted already."""
        return self.contact.carried_along(x, float(x[self.machine, 0]), x_last, float(x_last[self.machine, 0]))


@dataclass(frozen=True)
class SprungResponse(Response):
    """A contact at its true travel, and the force (N, on the modelled part) in the machine's spring."""

    block: SprungContact
    inner: Any
    force: float

    @property
    def state(self) -> Any:
        """State of the contact to carry over."""
        return self.inner.state

    @property
    def driving_force(self) -> float:
        """Force that works on the recorded displacement, N."""
        return self.force

    @property
    def penetration(self) -> float:
        """Largest penetration, mm."""
        return float(self.inner.penetration)

    def energy(self) -> Energy:
        """Return the contact's energies and the spring's."""
        found: Energy = self.inner.energy()
        return found + Energy(stored=0.5 * self.force**2 / self.block.stiffness)

    def add_gradient(self, gradient: Array) -> None:
        """Add contact forces, and what is left between spring and body, to gradient (P, 3)."""
        self.inner.add_gradient(gradient)
        gradient[self.block.machine, 0] += self.inner.driving_force - self.force

    def add_contact_force(self, force: Array) -> None:
        """Add the contact forces on the fabric."""
        self.inner.add_contact_force(force)

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add contact blocks, their coupling with the travel and the spring."""
        block = self.block
        own, upper = block.alone(len(rows) // 3)
        self.inner.add_tangent(own, NO_PAIRS, upper, exact=exact, damping=damping)
        block.spread(upper, rows, pairs, values)


class SprungNodes(OneSided):
    """The one-sided elements of a contact whose body moves by an unknown travel."""

    def __init__(self, response: SprungResponse, inner: OneSided) -> None:
        """Take the trial and the elements of the contact in it."""
        self.response = response
        self.inner = inner
        self.stretch, self.stiffness = inner.stretch, inner.stiffness

    def bear(self, stretch: Array) -> tuple[Array, Array]:
        """Return what the contact's elements bear."""
        return self.inner.bear(stretch)

    def add_gradient(self, force: Array, gradient: Array) -> None:
        """Add the contact's gradient, what it is by the travel, and the spring's force."""
        block, own = self.response.block, np.zeros_like(gradient)
        self.inner.add_gradient(force, own)
        gradient += own
        gradient[block.machine, 0] -= float((own @ block.contact.direction).sum()) + self.response.force

    def add_tangent(
        self, force: Array, along: Array, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float
    ) -> None:
        """Add the contact's blocks, their coupling with the travel and the spring."""
        block = self.response.block
        own, upper = block.alone(len(rows) // 3)
        self.inner.add_tangent(force, along, own, NO_PAIRS, upper, exact=exact, damping=damping)
        block.spread(upper, rows, pairs, values)

    def rate(self, step: Array) -> Array:
        """Return the change of the penetrations along `step`."""
        return self.inner.rate(self._relative(step))

    def bulge(self, step: Array, rate: Array) -> Array:
        """Return what the penetrations change beyond `rate`."""
        return self.inner.bulge(self._relative(step), rate)

    def add_skew(self, along: Array, step: Array, load: Array) -> bool:
        """Add what friction leaves out of the tangent, on the nodes and on the travel."""
        block, own = self.response.block, np.zeros_like(load)
        found = self.inner.add_skew(along, self._relative(step), own)
        load += own
        load[block.machine, 0] -= float((own @ block.contact.direction).sum())
        return found

    def follow(self, before: SprungNodes, step: Array) -> None:
        """Let the contact's elements take over what they remember."""
        self.inner.follow(before.inner, self._relative(step))

    def _relative(self, step: Array) -> Array:
        """Return the step (P, 3) as seen from the body."""
        block = self.response.block
        return np.asarray(step - step[block.machine, 0] * block.contact.direction)


@dataclass(frozen=True)
class MachineCompliance(Effect):
    """Give of machine and punch per punch force, mm/N."""

    compliance: float = 0.0

    stage: ClassVar[Stage] = Stage.MACHINE
    card: ClassVar[Card] = Card(
        id="machine_compliance",
        mechanism="A spring in series with the punch: frame, load cell, punch.",
        parameters=(
            Parameter("compliance", "mm/N", 0.0, 0.01, "the give per newton of punch force", limits=(0.0, 0.1)),
        ),
        example=Example({"compliance": 1e-3}, (-0.4, -3.1, -5.2, -7.4, -10.6), (0.0, -0.06, -0.12, -0.2, -0.35)),
        signature=(
            Signature("punch_force", -1, 15.0, "less in proportion to the force: the punch lags behind its record"),
            Signature("free_edge", -1, 20.0, "right shapes at the true displacement, late at the recorded one"),
            Signature("strain_field", -1, 20.0, "late alike"),
        ),
        confused_with=("rotational_shear", "clamp_compliance"),
        separate="Measure the punch tip itself, or press the punch against a block of steel.",
        literature="Load cell of 16 400 N/mm: Beex et al., section 5, which is 6.1e-5 mm/N and 0.6 % of force at most; "
        "Oliver and Pharr, J. Mater. Res. 7 (1992) 1564 on frame compliance.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with the spring; BadInput without a body that is pushed."""
        contact = next((part for part in model.contributions if isinstance(part, Contact)), None)
        if contact is None or not contact.direction.any():
            raise BadInput.of("machine_compliance needs a body that is pushed into the fabric", key="id")
        machine = len(model.points)
        partner = np.full_like(contact.nodes, machine)
        stiffness = 1.0 / (self.compliance * model.force_factor)
        sprung = SprungContact(np.hstack([contact.nodes, partner]), contact, machine, stiffness)
        still = np.zeros((1, 3))
        return replace(
            model,
            points=np.concatenate([model.points, still]),
            fixed=np.concatenate([model.fixed, [[False, True, True]]]),
            carried=np.concatenate([model.carried, still]),
            contributions=tuple(sprung if part is contact else part for part in model.contributions),
        )
