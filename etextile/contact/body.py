"""What a rigid body is to the contact: a signed distance with two derivatives, an outline to draw and a support.

Contact, motion and drawing know bodies through this file only, so a new body is one new class with these methods.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from etextile.errors import BadInput, Problem
from etextile.types import Array, IntArray


@dataclass(frozen=True)
class Distance:
    """Signed distance of n points and its derivatives.

    gap: (n,) mm, positive outside and negative inside.
    normal: (n, 3) gradient of the gap, pointing outward; of length one (interpolated bodies: nearly, close by).
    hessian: (n, 3, 3) second derivative of the gap, 1/mm; finite also where the exact one is singular.
    """

    gap: Array
    normal: Array
    hessian: Array


class Body(Protocol):
    """A rigid body in its own coordinates (mm)."""

    def distance(self, points: Array) -> Distance:
        """Return the signed distance of `points` (n, 3).

        Far from the body the gap may be a positive lower bound of the distance, with a zero Hessian.
        """

    def surface(self) -> tuple[Array, IntArray]:
        """Return vertices (v, 3) and triangles (f, 3), wound outward, for drawing."""

    def bounds(self) -> Array:
        """Return the lower and upper corner (2, 3) of the axis-parallel box around the body."""

    def support(self, direction: Array) -> float:
        """Return the maximum of x . direction over the body (mm times the length of `direction`)."""


def require_positive(**sizes: float) -> None:
    """Raise BadInput naming every size (keyword = key of the case file's body) that is not a positive number."""
    require(
        (f"must be a positive length (got {size:g})", key)
        for key, size in sizes.items()
        if not (np.isfinite(size) and size > 0)
    )


def require(problems: Iterable[tuple[str, str]]) -> None:
    """Raise BadInput with all (message, key) pairs given, if there are any; keys are those below `body`."""
    found = [Problem(message, key=f"body.{key}") for message, key in problems]
    if found:
        raise BadInput(found)


def evaluation_points(points: Array) -> Array:
    """Return `points` as a contiguous (n, 3) array of floats; raises ValueError for any other shape."""
    points = np.ascontiguousarray(points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"points must have shape (n, 3), got {points.shape}")
    return points
