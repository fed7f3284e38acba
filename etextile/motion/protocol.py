"""How bodies and supports move with the path parameter, so that contact and solver need not know which motion runs.

The path parameter is called travel throughout: mm of a punch, degrees of a joint. A body motion says three things of a
body's surface: where a point of the specimen is in the frame in which anchors of friction are kept, what the body looks
like there, and how the surface moves on.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from etextile.contact.body import Body, Distance
from etextile.types import Array


@dataclass(frozen=True)
class Touch:
    """Nodes on a body at a trial: places (m, 3) mm, distance, normal forces (m,) N, friction on the energy's side.

    anchor (m, 3) mm: the places on the surface that friction pulls back to; traction (m, 3) N, zero without friction.
    """

    place: Array
    found: Distance
    pressure: Array
    anchor: Array
    traction: Array


class BodyMotion(ABC):
    """The motion of a body's surface."""

    direction: Array
    """Direction (3,) of a straight travel, the sense in which its force counts; zero for any other motion."""

    @abstractmethod
    def place(self, x: Array, travel: float) -> Array:
        """Return positions x (n, 3) mm in the frame in which anchors are kept."""

    @abstractmethod
    def posed(self, body: Body, travel: float) -> Body:
        """Return the body as it is at `travel`, in that frame."""

    @abstractmethod
    def carried(self, anchor: Array, before: float, travel: float) -> Array:
        """Return where places (n, 3) of the surface at travel `before` are at `travel`, in that frame."""

    @abstractmethod
    def driving_force(self, body: Body, travel: float, touch: Touch, *, onward: bool = False) -> float:
        """Return the derivative by the travel of what the contact stores at unmoved nodes: force (N) or moment.

        Where one kind of motion ends and another begins it is that of the first, and `onward` that of the second.
        """

    @abstractmethod
    def longest_step(self, body: Body) -> float:
        """Return the largest travel of an increment in which no node can be put to the far side of the body."""

    @abstractmethod
    def surroundings(self, body: Body) -> Array:
        """Return the box (2, 3) around all that the body covers in the frame of `place` during the motion, mm."""


STILL = np.zeros(3)
"""The direction of what does not travel straight."""
