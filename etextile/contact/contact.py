"""Contact of fabric nodes with a rigid body: body x motion x contact law, as one contribution.

Normal law: quadratic penalty on the gap, weighted by each node's share of tributary area, so that a quarter and a whole
specimen give the same answer. The stiffness is state: the load path raises it until penetration keeps its limit.

Tangential law: elastic stick of the same stiffness, anchored on the body where a node was found touching at the end of
an increment, and Coulomb slip at mu times the current normal force; the anchor is history. Where much of the force is
on nodes that touch first in an increment, it is solved once more with anchors where they touched (`touched`): without
friction until its end a strip that wraps by 2.4 mm at a time lost a quarter of mu theta.

Sticking contact (mu = infinity) has its own shear stiffness `grip` per node, since skin and padding give: 3 N/mm per
mm2 meets the reference forces of the punch within 0.5 %, a rigid stick would be 17 % stiffer at 52.5 mm. It ties an
anchored node for the length of an increment, also normally, and lets go of it at the end when the body would have to
pull: a traction without limit that vanished with the gap would have no equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from etextile.contact.pressed import PressedNodes
from etextile.contact.trial import ContactLaw, ContactResponse, ContactState
from etextile.mechanics.onesided import OneSided
from etextile.mechanics.protocol import Contribution
from etextile.types import Array, IntArray


FIRST_TOUCH, LATEST = 0.01, 0.9
"""Share of the normal force on nodes that touch first in an increment from which on friction acts on them in it; share
of the increment after which the last of them is taken to touch."""


@dataclass(frozen=True)
class Contact(ContactLaw, Contribution):
    """Nodes that may touch a body, as a contribution to the model."""

    def initial_state(self) -> ContactState:
        """Return the state before any touch."""
        count = len(self.nodes)
        return ContactState(self.stiffness, np.zeros((count, 3)), np.zeros(count, dtype=bool))

    @property
    def direction(self) -> Array:
        """Direction (3,) of a straight travel; zero where the body does not travel straight."""
        return self.motion.direction

    @cached_property
    def longest_step(self) -> float:
        """Largest travel of an increment in which no node can be put to the far side of the body."""
        return self.motion.longest_step(self.body)

    def respond(self, x: Array, travel: float, state: ContactState) -> ContactResponse:
        """Evaluate contact at node positions x (N, 3) with the body at `travel` mm."""
        place = self.motion.place(x[self.nodes[:, 0]], travel)
        low, high = self.surroundings[0]
        near = np.flatnonzero(np.all((place > low) & (place < high), axis=1) | state.anchored)
        posed = self.motion.posed(self.body, travel)
        return ContactResponse(self, state, travel, place, near, posed.distance(place[near]))

    def among(self, elements: IntArray, number: IntArray) -> Contact | None:
        """Return contact of some nodes; with Coulomb friction, which remembers its way to equilibrium, None."""
        if 0.0 < self.friction < np.inf:
            return None
        return replace(self, nodes=number[self.nodes[elements]], share=self.share[elements])

    def state_among(self, state: ContactState, elements: IntArray) -> ContactState:
        """Return the anchors of `elements`."""
        return replace(state, anchor=state.anchor[elements], anchored=state.anchored[elements])

    def one_sided(self, response: ContactResponse, state: ContactState) -> OneSided:
        """Return the nodes as elements on which the body can only push."""
        return PressedNodes(response)

    def tightened(self, response: ContactResponse, state: ContactState) -> ContactState:
        """Return a stiffer penalty when nodes penetrate more than allowed."""
        if response.penetration <= self.max_penetration:
            return state
        return replace(state, stiffness=state.stiffness * 2.0 * response.penetration / self.max_penetration)

    def touched(
        self, response: ContactResponse, state: ContactState, x_last: Array, travel_last: float
    ) -> ContactState:
        """Return the state with anchors, where they first touched, of nodes that came to the body in this increment.

        A node at the gap g before has touched after the share sqrt(g / the largest g) of it: fabric that wraps onto a
        curved body comes down on it as an involute does. The same state where they bear less than FIRST_TOUCH.
        """
        if not 0.0 < self.friction < np.inf:
            return state
        new = (response.pressure > 0.0) & ~state.anchored[response.near]
        if response.pressure[new].sum() <= FIRST_TOUCH * response.pressure.sum():
            return state
        nodes = response.near[new]
        last = self.motion.place(x_last[self.nodes[nodes, 0]], travel_last)
        found = self.motion.posed(self.body, travel_last).distance(last)
        gap = np.maximum(found.gap, 0.0)
        since = 1.0 - LATEST * np.sqrt(gap / max(float(gap.max()), 1e-30))
        skin = last - gap[:, None] * found.normal
        moved = response.place[nodes] - self.motion.carried(skin, travel_last, response.travel)
        touch = response.place[nodes] - since[:, None] * moved
        anchor, anchored = state.anchor.copy(), state.anchored.copy()
        anchor[nodes] = self.motion.carried(touch, response.travel, state.travel)
        anchored[nodes] = True
        return replace(state, anchor=anchor, anchored=anchored)

    def carried_along(self, x: Array, travel: float, x_last: Array, travel_last: float) -> Array:
        """Return positions at which touching nodes keep their gap and no other node penetrates."""
        nodes, motion = self.nodes[:, 0], self.motion
        before = motion.posed(self.body, travel_last).distance(motion.place(x_last[nodes], travel_last)).gap
        posed = motion.posed(self.body, travel)
        x = x.copy()
        for _ in range(2):
            found = posed.distance(motion.place(x[nodes], travel))
            move = np.where(before < 0.0, before - found.gap, np.maximum(-found.gap, 0.0))
            x[nodes] += move[:, None] * found.normal
        return x
