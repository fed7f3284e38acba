"""The diaphragm of a hydraulic burst tester: a rubber sheet below the fabric that takes a part of the pressure.

Standards measure it alone and take its pressure at the same height off what the gauge shows (ISO 13938-1, -2: bursting
strength is the mean bursting pressure less the diaphragm's at the mean bursting distension). So the gauge shows the
fabric's pressure and the diaphragm's beside it, and what the two do to each other beyond that is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from etextile.types import Array


@dataclass(frozen=True)
class Diaphragm:
    """Pressure (n,) bar of the diaphragm alone over its height (n,) mm, both rising; nothing at height 0."""

    height: Array
    pressure: Array

    def at(self, height: Array) -> Array:
        """Return its pressure at heights (m,): a monotone cubic, then on with the last slope."""
        from scipy.interpolate import PchipInterpolator

        first = [] if self.height[0] == 0.0 else [0.0]
        x, y = np.array([*first, *self.height]), np.array([*first, *self.pressure])
        inside = PchipInterpolator(x, y)(np.clip(height, 0.0, x[-1]))
        slope = (y[-1] - y[-2]) / (x[-1] - x[-2])
        return np.asarray(inside + slope * np.maximum(height - x[-1], 0.0))


def faults(height: Array, pressure: Array) -> list[tuple[int, str]]:
    """Return what is wrong with a measured curve: number of the point, and what to do."""
    found = []
    if len(height) < 2:
        found.append((0, "only one point; give the pressure at two heights or more"))
    found += [
        (int(row), f"the height does not rise (got {height[row]:g} mm); order the rows by height")
        for row in np.flatnonzero(np.diff(height) <= 0.0)[:1] + 1
    ]
    found += [
        (int(row), f"the pressure falls to {pressure[row]:g} bar; a diaphragm gets no softer")
        for row in np.flatnonzero(np.diff(pressure) < 0.0)[:1] + 1
    ]
    if height[0] < 0.0 or pressure[0] < 0.0 or (height[0] == 0.0 and pressure[0] != 0.0):
        found.append((0, "a diaphragm begins flat and without pressure; set its zero"))
    return found
