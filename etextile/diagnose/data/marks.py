"""Slip of marks on a worn piece along the skin, over the angle of the joint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from etextile.diagnose.data.channel import Channel
from etextile.types import Array, IntArray


@dataclass(frozen=True)
class MarkSlip(Channel):
    """How far marks on a worn piece have slipped along the skin, (n,) each, ordered by angle, deg.

    slip: mm on a scale that was drawn on the skin of the straight limb, positive towards hand or foot.
    """

    angle: Array
    warp0: Array
    weft0: Array
    slip: Array
    noise: float | None = None

    @property
    def displacement(self) -> Array:
        """The load it was measured over, deg."""
        return self.angle

    @property
    def marks(self) -> Mapping[str, IntArray]:
        """The rows of every mark by its name, the file's and its place."""
        places, number = np.unique(np.stack([self.warp0, self.weft0], axis=1), axis=0, return_inverse=True)
        name = Path(self.file).with_suffix("")
        return {
            f"{name} at {warp:.0f}, {weft:.0f} mm": np.flatnonzero(number.reshape(-1) == i)
            for i, (warp, weft) in enumerate(places)
        }
