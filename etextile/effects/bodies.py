"""Bodies changed by effects: moved aside, or grown to a parallel surface."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from etextile.contact.body import Body, Distance
from etextile.contact.contact import Contact
from etextile.contact.pose import PlacedBody
from etextile.types import Array, IntArray


@dataclass(frozen=True)
class ParallelBody:
    """The surface at distance `growth` mm outside of a body (a sphere becomes a larger sphere); negative is inside."""

    body: Body
    growth: float

    def distance(self, points: Array) -> Distance:
        """Return the signed distance of `points` (n, 3): the body's own less the growth."""
        found = self.body.distance(points)
        return Distance(found.gap - self.growth, found.normal, found.hessian)

    def surface(self) -> tuple[Array, IntArray]:
        """Return the body's triangles with each vertex moved along its normal."""
        vertices, faces = self.body.surface()
        return vertices + self.growth * self.body.distance(vertices).normal, faces

    def bounds(self) -> Array:
        """Return the body's box (2, 3), grown on all sides."""
        return self.body.bounds() + self.growth * np.array([[-1.0] * 3, [1.0] * 3])

    def support(self, direction: Array) -> float:
        """Return the maximum of x . direction over the grown body."""
        return self.body.support(direction) + self.growth * float(np.linalg.norm(direction))


def shifted(contact: Contact, shift: Array) -> Contact:
    """Return a contact whose body stands `shift` (3,) mm from where it was."""
    body = contact.body
    moved = body.moved(shift) if isinstance(body, PlacedBody) else PlacedBody(body, np.eye(3), shift)
    return replace(contact, body=moved)


def grown(contact: Contact, growth: float) -> Contact:
    """Return a contact whose body is thicker by `growth` mm all round and still starts at the same height."""
    body = ParallelBody(contact.body, growth)
    return shifted(replace(contact, body=body), -growth * contact.direction)
