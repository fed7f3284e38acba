"""Contact of fabric nodes with a rigid body: body x motion x contact law, as one contribution.

Normal law: quadratic penalty on the gap, weighted by each node's share of tributary area, so that a quarter and a whole
specimen give the same answer. The stiffness is state: the load path raises it until penetration keeps its limit.

Tangential law: elastic stick of the same stiffness, anchored on the body where a node was found touching at the end of
an increment, and Coulomb slip at mu times the current normal force; the anchor is history.

Sticking contact (mu = infinity) has its own shear stiffness `grip` per node, since skin and padding give: 3 N/mm per
mm2 meets the reference forces of the punch within 0.5 %, a rigid stick would be 17 % stiffer at 52.5 mm. It ties an
anchored node for the length of an increment, also normally, and lets go of it at the end when the body would have to
pull: a traction without limit that vanished with the gap would have no equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from etextile.contact.body import Body
from etextile.mechanics.kernels import add_node_blocks
from etextile.mechanics.protocol import Contribution, Energy, Response
from etextile.types import Array, BoolArray, IntArray


@dataclass(frozen=True)
class ContactState:
    """Penalty N/mm, anchors (n, 3) mm relative to the moving body, which nodes are anchored (n,), friction work N mm."""

    stiffness: float
    anchor: Array
    anchored: BoolArray
    friction_work: float = 0.0


@dataclass(frozen=True)
class Contact(Contribution):
    """Nodes (n, 1) that may touch `body`, moving by travel x direction; share (n,) of a full node's area.

    stiffness: first normal penalty of a full node, N/mm; grip: shear stiffness of a full node in sticking contact, N/mm.
    """

    nodes: IntArray
    share: Array
    body: Body
    direction: Array
    friction: float
    max_penetration: float
    stiffness: float
    grip: float = np.inf
    name: str = "contact"

    def initial_state(self) -> ContactState:
        """Return the state before any touch."""
        count = len(self.nodes)
        return ContactState(self.stiffness, np.zeros((count, 3)), np.zeros(count, dtype=bool))

    def respond(self, x: Array, travel: float, state: ContactState) -> ContactResponse:
        """Evaluate contact at node positions x (N, 3) with the body at `travel` mm."""
        place = x[self.nodes[:, 0]] - travel * self.direction
        found = self.body.distance(place)
        touching = found.gap < 0.0
        active = np.flatnonzero(touching | state.anchored if np.isinf(self.friction) else touching)
        stiffness = state.stiffness * self.share[active]
        normal = found.normal[active]
        pressure = -stiffness * found.gap[active]
        blocks = stiffness[:, None, None] * normal[:, :, None] * normal[:, None, :]
        bending = -pressure[:, None, None] * found.hessian[active]
        traction = np.zeros((len(active), 3))
        offset = np.zeros((len(active), 3))
        if self.friction > 0.0:
            offset = np.where(state.anchored[active, None], place[active] - state.anchor[active], 0.0)
            offset -= np.einsum("ij,ij->i", offset, normal)[:, None] * normal
            traction, tangent = self._tangential(offset, normal, self.shear_stiffness(state)[active], pressure)
            tangent[~state.anchored[active]] = 0.0
            blocks += tangent
        return ContactResponse(
            self, state, place, active, found.gap, normal, pressure, traction, offset, blocks, bending
        )

    def shear_stiffness(self, state: ContactState) -> Array:
        """Return the elastic stiffness (n,) against sliding, N/mm: as stiff as the penalty, or the grip of a stick."""
        per_node = min(self.grip, state.stiffness) if np.isinf(self.friction) else state.stiffness
        return per_node * self.share

    def tightened(self, response: ContactResponse, state: ContactState) -> ContactState:
        """Return a stiffer penalty when nodes penetrate more than allowed."""
        if response.penetration <= self.max_penetration:
            return state
        return replace(state, stiffness=state.stiffness * 2.0 * response.penetration / self.max_penetration)

    def carried_along(self, x: Array, travel: float, x_last: Array, travel_last: float) -> Array:
        """Return positions at which touching nodes keep their gap and no other node penetrates."""
        nodes = self.nodes[:, 0]
        before = self.body.distance(x_last[nodes] - travel_last * self.direction).gap
        x = x.copy()
        for _ in range(2):
            found = self.body.distance(x[nodes] - travel * self.direction)
            move = np.where(before < 0.0, before - found.gap, np.maximum(-found.gap, 0.0))
            x[nodes] += move[:, None] * found.normal
        return x

    def _tangential(self, offset: Array, normal: Array, stiffness: Array, pressure: Array) -> tuple[Array, Array]:
        """Return friction force on the energy's side (n, 3) and its tangent (n, 3, 3) for tangential offsets."""
        size = np.linalg.norm(offset, axis=1)
        limit = np.full(len(size), np.inf) if np.isinf(self.friction) else self.friction * pressure
        slips = stiffness * size > limit
        secant = np.where(slips, limit / np.where(size > 0.0, size, 1.0), stiffness)
        plane = np.eye(3) - normal[:, :, None] * normal[:, None, :]
        tangent = secant[:, None, None] * plane
        along = offset / np.where(size > 0.0, size, 1.0)[:, None]
        tangent -= np.where(slips, secant, 0.0)[:, None, None] * along[:, :, None] * along[:, None, :]
        return secant[:, None] * offset, tangent


@dataclass(frozen=True)
class ContactResponse(Response):
    """Contact at a trial: gap (n,) of all candidates, and for the touching ones normal, pressure N, friction N."""

    contact: Contact
    before: ContactState
    place: Array
    active: IntArray
    gap: Array
    normal: Array
    pressure: Array
    traction: Array
    offset: Array
    blocks: Array
    bending: Array

    @property
    def state(self) -> ContactState:
        """Anchors of touching nodes, moved along where they slipped; nodes that left lose theirs."""
        contact, before, active = self.contact, self.before, self.active
        if contact.friction == 0.0:
            return before
        held = self.pressure > 0.0
        anchor = np.zeros_like(before.anchor)
        stiffness = contact.shear_stiffness(before)[active]
        anchor[active] = self.place[active] - self.traction / stiffness[:, None]
        anchored = np.zeros_like(before.anchored)
        anchored[active] = held
        slipped = self.offset - self.traction / stiffness[:, None]
        work = float(np.einsum("ij,ij->", self.traction, slipped))
        return replace(before, anchor=anchor, anchored=anchored, friction_work=before.friction_work + work)

    @property
    def penetration(self) -> float:
        """Largest penetration of a node, mm."""
        return float(max(0.0, -self.gap.min(initial=0.0)))

    @property
    def driving_force(self) -> float:
        """Punch force of the modelled part along the travel, N."""
        return float((self.forces @ self.contact.direction).sum())

    @property
    def forces(self) -> Array:
        """Forces on the fabric (n touching, 3), N."""
        force: Array = self.pressure[:, None] * self.normal - self.traction
        return force

    def energy(self) -> Energy:
        """Return the penalty energy and the friction work so far, N mm."""
        normal = self.before.stiffness * self.contact.share[self.active]
        shear = self.contact.shear_stiffness(self.before)[self.active]
        springs = 0.5 * (self.pressure**2 / normal + np.einsum("ij,ij->i", self.traction, self.traction) / shear)
        return Energy(friction=self.state.friction_work, contact=float(springs.sum()))

    def add_gradient(self, gradient: Array) -> None:
        """Add minus the contact forces to gradient (N, 3)."""
        gradient[self.contact.nodes[self.active, 0]] -= self.forces

    def add_tangent(self, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float) -> None:
        """Add penalty and stick; `exact` adds the body's curvature, which is destabilising on convex bodies."""
        blocks = self.blocks + self.bending if exact else self.blocks
        add_node_blocks(self.contact.nodes[self.active, 0], blocks, rows, values)

    def add_contact_force(self, force: Array) -> None:
        """Add the forces on the fabric to `force` (P, 3)."""
        force[self.contact.nodes[self.active, 0]] += self.forces
