"""A parallel projection whose pixel positions are known, so that markers and tests find their place in a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.errors import BadInput, nearest
from etextile.types import Array


VIEWS: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]] = {
    "iso": ((0.50, -0.72, 0.48), (0.0, 0.0, 1.0)),
    "inner": ((0.50, -0.72, -0.48), (0.0, 0.0, 1.0)),
    "top": ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
    "side": ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
    "end": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
}
"""Direction from the fabric towards the eye, and what points up in the picture."""


@dataclass(frozen=True)
class Camera:
    """Axes of the picture (unit vectors), the point in its middle, mm per pixel and its width and height in pixels."""

    right: Array
    up: Array
    towards: Array
    middle: Array
    mm_per_pixel: float
    size: tuple[int, int]

    def project(self, points: Array) -> Array:
        """Return pixel coordinates (n, 2) of points (n, 3): x to the right, y downwards, from the top left corner."""
        away = points - self.middle
        x = 0.5 * self.size[0] + away @ self.right / self.mm_per_pixel
        y = 0.5 * self.size[1] - away @ self.up / self.mm_per_pixel
        return np.stack([x, y], axis=1)

    def nearness(self, points: Array) -> Array:
        """Return how far (n,) points lie towards the eye, mm from the middle."""
        return np.asarray((points - self.middle) @ self.towards)


def aim(view: str, points: Array, *, size: tuple[int, int], margin: float = 0.04) -> Camera:
    """Return the camera of a view that just holds all points (n, 3); an unknown view raises BadInput."""
    if view not in VIEWS:
        raise BadInput.of(f"no camera {view!r}{nearest(view, VIEWS)}; there are {', '.join(VIEWS)}", key="camera")
    towards, up = (np.asarray(vector) / np.linalg.norm(vector) for vector in VIEWS[view])
    right = np.cross(up, towards)
    right /= np.linalg.norm(right)
    up = np.cross(towards, right)
    axes = np.stack([right, up, towards])
    low, high = (points @ axes.T).min(axis=0), (points @ axes.T).max(axis=0)
    room = np.array(size) * (1.0 - 2.0 * margin)
    scale = float(max((high[0] - low[0]) / room[0], (high[1] - low[1]) / room[1], 1e-9))
    return Camera(right, up, towards, 0.5 * (low + high) @ axes, scale, size)
