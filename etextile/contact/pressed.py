"""The nodes of a contact as one-sided elements: the body pushes, never pulls; Coulomb friction rides on the push."""

from __future__ import annotations

import numpy as np

from etextile.contact.friction import Cone, LinearCone
from etextile.contact.trial import ContactResponse
from etextile.mechanics.onesided import OneSided
from etextile.types import Array, IntArray


FIRST_SLIP = 0.2
"""Slip of a barely interior friction when a solve begins, as a share of the allowed penetration."""


class PressedNodes(OneSided):
    """All candidates of a contact at a trial; those that are tied bear in both senses and are taken as they are."""

    def __init__(self, response: ContactResponse) -> None:
        """Take the trial; nodes away from the body stand as far off as its surroundings reach."""
        contact = response.contact
        self.response = response
        self.stretch = np.full(len(contact.nodes), -contact.apart)
        self.stretch[response.near] = -response.found.gap
        self.stiffness = response.before.stiffness * contact.weight
        self.cone = self._first_cone()
        self._linear: LinearCone | None = None
        self._limit = np.zeros(0)

    def _first_cone(self) -> Cone | None:
        """Return Coulomb friction as it stands at the trial; None without any, or with sticking contact."""
        contact, held = self.response.contact, self.response.friction
        if not len(held.which) or np.isinf(contact.friction):
            return None
        limit = contact.limit(held, self.response.pressure[held.which])
        return Cone.start(held.offset, limit / held.stiffness, FIRST_SLIP * contact.max_penetration)

    def bear(self, stretch: Array) -> tuple[Array, Array]:
        """Return penalty force and stiffness at penetrations (n,)."""
        return self.stiffness * stretch, self.stiffness

    def add_gradient(self, force: Array, gradient: Array) -> None:
        """Add contact and friction forces of nodes pressed by `force` (n,)."""
        response = self.response
        force = np.where(response.tied, response.pressure, force[response.near])
        pushes = force[:, None] * response.found.normal
        held = response.friction
        if self.cone is not None and self._linear is not None:
            limit = response.contact.limit(held, force[held.which])
            pushes[held.which] -= limit[:, None] * self.cone.theta
            pushes[held.which] -= self._limit[:, None] * self._linear.inverse(self._linear.off)
        elif len(held.which):
            pushes[held.which] -= held.stiffness[:, None] * held.offset
        gradient[response.contact.nodes[response.near, 0]] -= pushes

    def add_tangent(
        self, force: Array, along: Array, rows: IntArray, pairs: IntArray, values: Array, *, exact: bool, damping: float
    ) -> None:
        """Add blocks of nodes pressed by `force` (n,) that grows by `along` (n,)."""
        response = self.response
        force = np.where(response.tied, response.pressure, force[response.near])
        along = np.where(response.tied, response.penalty, along[response.near])
        held = response.friction
        blocks = None
        if self.cone is not None:
            self._limit = response.contact.limit(held, force[held.which])
            self._linear = self.cone.linearised(held.offset, self._limit / held.stiffness)
            blocks = self._limit[:, None, None] * self._linear.blocks(held.plane)
        response.add_blocks(force, along, rows, values, exact=exact, stick=blocks)

    def add_skew(self, along: Array, step: Array, load: Array) -> bool:
        """Add how friction changes with the normal force and turns with the surface."""
        if self.cone is None:
            return False
        response, held = self.response, self.response.friction
        nodes = response.contact.nodes[response.near[held.which], 0]
        own = step[nodes]
        closing = held.steep * np.einsum("ij,ij->i", own, held.normal)
        stiffer = response.contact.friction * held.steep * along[response.near[held.which]]
        turn = np.einsum("ij,ijk,ik->i", own, response.found.hessian[held.which], self.cone.theta) / held.steep
        load[nodes] -= (stiffer * closing)[:, None] * self.cone.theta + (self._limit * turn)[:, None] * held.normal
        return True

    def follow(self, before: PressedNodes, step: Array) -> None:
        """Move the cone of friction along."""
        linear = before._linear
        if linear is None:
            return
        held = before.response.friction
        own = step[before.response.contact.nodes[before.response.near[held.which], 0]]
        shift = own - np.einsum("ij,ij->i", own, held.normal)[:, None] * held.normal
        self.cone = linear.moved(shift).turned(self.response.friction.normal)

    def rate(self, step: Array) -> Array:
        """Return the change of the penetration (n,) along `step`."""
        response = self.response
        rate = np.zeros(len(self.stretch))
        own = step[response.contact.nodes[response.near, 0]]
        rate[response.near] = -np.einsum("ij,ij->i", own, response.found.normal)
        return rate

    def bulge(self, step: Array, rate: Array) -> Array:
        """Return zeros: nodes do not turn."""
        return np.zeros(len(self.stretch))
