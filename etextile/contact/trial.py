"""A contact at a trial: which nodes are near the body, how they press on it, what friction does where they stuck."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from etextile.contact.body import Body, Distance
from etextile.mechanics.kernels import add_node_blocks
from etextile.mechanics.protocol import Energy, Response
from etextile.motion.protocol import BodyMotion, Touch
from etextile.types import Array, BoolArray, IntArray


_NONE = np.zeros((0, 3))
"""Vectors at no node."""


@dataclass(frozen=True)
class ContactState:
    """Penalty N/mm, anchors (n, 3) mm in the frame of the motion, anchored nodes (n,), friction work N mm.

    travel: at which the anchors were where they are.
    """

    stiffness: float
    anchor: Array
    anchored: BoolArray
    friction_work: float = 0.0
    travel: float = 0.0


@dataclass(frozen=True)
class ContactLaw:
    """What a contact is made of: nodes (n, 1) that may touch `body`, whose surface moves by `motion`, and its numbers.

    share (n,): of a full node's area; stiffness: first normal penalty of a full node, N/mm; grip: its shear stiffness
    in sticking contact, N/mm.
    """

    nodes: IntArray
    share: Array
    body: Body
    motion: BodyMotion
    friction: float
    max_penetration: float
    stiffness: float
    grip: float = np.inf
    give: float = np.inf
    name: str = "contact"

    @cached_property
    def surroundings(self) -> tuple[Array, float]:
        """Box (2, 3) around the body, grown by a tenth of its size, and half that growth, mm."""
        bounds = self.motion.surroundings(self.body)
        size = float(np.ptp(bounds, axis=0).max())
        return bounds + 0.1 * size * np.array([[-1.0], [1.0]]), 0.05 * size

    @cached_property
    def weight(self) -> Array:
        """Shares (n,), none quite zero."""
        return np.maximum(self.share, 1e-9)

    @property
    def apart(self) -> float:
        """Distance (mm) at which nodes outside of the surroundings are taken to be."""
        return self.surroundings[1]

    @cached_property
    def shear_stiffness(self) -> Array:
        """Elastic stiffness (n,) against sliding, N/mm: at most that of the first penalty, softer where skin gives."""
        return min(self.grip if np.isinf(self.friction) else self.give, self.stiffness) * self.share

    def limit(self, held: FrictionAnchors, pressure: Array) -> Array:
        """Return the largest friction (m,) N of anchored nodes at normal forces (m,)."""
        if np.isinf(self.friction):
            return np.full(len(held.which), np.inf)
        return np.asarray(self.friction * held.steep * np.maximum(pressure, 0.0))

    def friction_at(self, held: FrictionAnchors, pressure: Array) -> tuple[Array, Array]:
        """Return friction (n, 3) N on the energy's side and its tangent (n, 3, 3) at normal forces (n,)."""
        size = np.linalg.norm(held.offset, axis=1)
        limit = self.limit(held, pressure)
        slips = held.stiffness * size >= limit
        secant = np.where(slips, limit / np.where(size > 0.0, size, 1.0), held.stiffness)
        tangent = secant[:, None, None] * held.plane
        along = held.offset / np.where(size > 0.0, size, 1.0)[:, None]
        tangent -= np.where(slips, secant, 0.0)[:, None, None] * along[:, :, None] * along[:, None, :]
        return secant[:, None] * held.offset, tangent


@dataclass(frozen=True)
class FrictionAnchors:
    """Anchored nodes: their place among the near ones (m,), tangential offset (m, 3) mm, normal, stiffness N/mm.

    steep (m,): length of the distance's gradient, below 1 where bodies are blended; P `steep` presses on the node.
    """

    which: IntArray
    offset: Array
    normal: Array
    steep: Array
    stiffness: Array

    @cached_property
    def plane(self) -> Array:
        """Projectors (m, 3, 3) on the tangent planes."""
        return np.asarray(np.eye(3) - self.normal[:, :, None] * self.normal[:, None, :])


@dataclass(frozen=True)
class ContactResponse(Response):
    """Contact at a trial: travel, places (n, 3) in its frame, nodes `near` (m,) the body and their distance."""

    contact: ContactLaw
    before: ContactState
    travel: float
    place: Array
    near: IntArray
    found: Distance

    @cached_property
    def tied(self) -> BoolArray:
        """Near nodes (m,) that stick, also normally, for the length of the increment."""
        return np.asarray(self.before.anchored[self.near] & np.isinf(self.contact.friction))

    @cached_property
    def penalty(self) -> Array:
        """Normal stiffness (m,) of near nodes, N/mm."""
        return self.before.stiffness * self.contact.share[self.near]

    @cached_property
    def pressure(self) -> Array:
        """Normal force (m,) on near nodes, N; negative only on tied ones."""
        gap = self.found.gap
        return np.asarray(np.where((gap < 0.0) | self.tied, -self.penalty * gap, 0.0))

    @cached_property
    def anchors(self) -> Array:
        """Anchors (m, 3) of near nodes as the surface has carried them along; those of nodes without any are zero."""
        kept = self.before.anchor[self.near]
        return self.contact.motion.carried(kept, self.before.travel, self.travel)

    @cached_property
    def friction(self) -> FrictionAnchors:
        """The anchored nodes; Coulomb friction on those that do not touch is nothing."""
        held = self.before.anchored[self.near] & (self.contact.friction > 0.0)
        which = np.flatnonzero(held)
        if not len(which):
            return FrictionAnchors(which, _NONE, _NONE, _NONE[:, 0], _NONE[:, 0])
        normal = self.found.normal[which]
        steep = np.maximum(np.linalg.norm(normal, axis=1), 1e-9)
        normal = normal / steep[:, None]
        offset = self.place[self.near[which]] - self.anchors[which]
        offset -= np.einsum("ij,ij->i", offset, normal)[:, None] * normal
        return FrictionAnchors(which, offset, normal, steep, self.contact.shear_stiffness[self.near[which]])

    @cached_property
    def traction(self) -> Array:
        """Friction (m, 3) on near nodes, on the energy's side, N."""
        traction = np.zeros((len(self.near), 3))
        held = self.friction
        if len(held.which):
            traction[held.which] = self.contact.friction_at(held, self.pressure[held.which])[0]
        return traction

    @property
    def state(self) -> ContactState:
        """Anchors of touching nodes, moved along where they slipped; nodes that left lose theirs."""
        contact, before = self.contact, self.before
        if contact.friction == 0.0:
            return before
        anchor, anchored = np.zeros_like(before.anchor), np.zeros_like(before.anchored)
        give = self.traction / contact.shear_stiffness[self.near, None]
        anchor[self.near] = np.where((self.pressure > 0.0)[:, None], self.place[self.near] - give, 0.0)
        anchored[self.near] = self.pressure > 0.0
        return replace(
            before, anchor=anchor, anchored=anchored, friction_work=self._friction_work(), travel=self.travel
        )

    def _friction_work(self) -> float:
        """Return the work lost in slip so far, N mm."""
        held = self.friction
        traction = self.traction[held.which]
        slipped = held.offset - traction / held.stiffness[:, None]
        return self.before.friction_work + float(np.einsum("ij,ij->", traction, slipped))

    @property
    def penetration(self) -> float:
        """Largest penetration of a node, mm."""
        return float(max(0.0, -self.found.gap.min(initial=0.0)))

    @property
    def driving_force(self) -> float:
        """What the motion works against: force of the modelled part along the travel, N, or moment."""
        return self._force(onward=False)

    @property
    def force_onward(self) -> float:
        """The same for the motion that begins where another ends."""
        return self._force(onward=True)

    def _force(self, *, onward: bool) -> float:
        contact = self.contact
        touch = Touch(self.place[self.near], self.found, self.pressure, self.anchors, self.traction)
        return contact.motion.driving_force(contact.body, self.travel, touch, onward=onward)

    @property
    def forces(self) -> Array:
        """Forces on the near nodes (m, 3), N."""
        force: Array = self.pressure[:, None] * self.found.normal
        return force - self.traction if len(self.friction.which) else force

    def energy(self) -> Energy:
        """Return the penalty energy and the friction work so far, N mm."""
        held = self.friction
        normal = np.divide(self.pressure**2, self.penalty, out=np.zeros_like(self.pressure), where=self.penalty > 0.0)
        shear = np.einsum("ij,ij->i", self.traction[held.which], self.traction[held.which]) / held.stiffness
        return Energy(friction=self._friction_work(), contact=0.5 * float(normal.sum() + shear.sum()))

    def add_gradient(self, gradient: Array) -> None:
        """Add minus the contact forces to gradient (N, 3)."""
        gradient[self.contact.nodes[self.near, 0]] -= self.forces

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add penalty and stick; `exact` adds the body's curvature, which is destabilising on convex bodies."""
        bears = np.where((self.found.gap < 0.0) | self.tied, self.penalty, 0.0)
        self.add_blocks(self.pressure, bears, rows, values, exact=exact)

    def add_blocks(
        self, pressure: Array, along: Array, rows: IntArray, values: Array, *, exact: bool, stick: Array | None = None
    ) -> None:
        """Add the blocks of near nodes under normal forces (m,) N that fall by `along` (m,) N/mm with the gap."""
        normal = self.found.normal
        blocks = along[:, None, None] * normal[:, :, None] * normal[:, None, :]
        if exact:
            blocks -= pressure[:, None, None] * self.found.hessian
        held = self.friction
        if len(held.which):
            found = self.contact.friction_at(held, pressure[held.which])[1] if stick is None else stick
            blocks[held.which] += found
        add_node_blocks(self.contact.nodes[self.near, 0], blocks, rows, values)

    def add_contact_force(self, force: Array) -> None:
        """Add the forces on the fabric to `force` (P, 3)."""
        force[self.contact.nodes[self.near, 0]] += self.forces
