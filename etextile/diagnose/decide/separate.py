"""The next measurement: the cheapest channel in which two explanations that fit alike differ clearly.

Both explanations are simulated, every channel is predicted at ordinary places from both, and the differences are
counted in standard deviations of an ordinary instrument. Where no channel decides, the one that comes closest is first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from etextile.diagnose.data.measured import ClampLine, FreeEdge, Measurements, StrainField
from etextile.diagnose.data.observe import Record, observe
from etextile.diagnose.data.points import Points, gather
from etextile.types import Array
from etextile.vocabulary import CLAMP, EDGE, STRAIN


NOISE = {EDGE: 0.2, STRAIN: 0.003, CLAMP: 0.1}
"""Standard deviation of an ordinary instrument: mm, engineering strain, mm."""
COST = {CLAMP: 1, EDGE: 2, STRAIN: 5}
"""What a measurement takes, relative: a mark and a rule, a photograph from the side, two cameras with a pattern."""
SHARES = (0.25, 0.5, 0.75, 1.0)
"""Displacements at which is measured, as shares of the largest."""
PLACES = (0.02, 0.25, 0.5, 0.75, 0.95)
"""Places along half the specimen, as shares of it."""
WORDS = {EDGE: "the free edge", STRAIN: "the strain field", CLAMP: "a mark at the clamp line"}
QUANTITIES = {
    "warp": "its position along the warp", "weft": "its position along the weft", "height": "its height",
    "strain_warp": "the warp strain", "strain_weft": "the weft strain", "slip": "the slip",
}  # fmt: skip
CLEAR = 3.0


@dataclass(frozen=True)
class Separation:
    """How clearly a channel would tell two explanations apart, in standard deviations of one reading, and where best.

    `first`, `second`: what they predict there, in `unit`; warp0, weft0, displacement: the place, mm.
    """

    channel: str
    quantity: str
    sigma: float
    first: float
    second: float
    unit: str
    displacement: float
    warp0: float
    weft0: float

    @property
    def clear(self) -> bool:
        """Whether a single reading would do."""
        return self.sigma >= CLEAR

    @property
    def words(self) -> str:
        """What to measure, where, and what either explanation says of it."""
        places = [f"{name} = {value:.0f} mm" for name, value in (("x", self.warp0), ("y", self.weft0))
                  if np.isfinite(value)]  # fmt: skip
        where = f" at {', '.join(places)}" if places else ""
        unit = f" {self.unit}" if self.unit else ""
        form = "{:.4f}" if not self.unit else "{:.2f}"
        return (
            f"{WORDS[self.channel]}{where}, {self.displacement:.0f} mm deep: {QUANTITIES[self.quantity]} would be "
            f"{form.format(self.first)}{unit} against {form.format(self.second)}{unit} "
            f"({self.sigma:.0f} standard deviations of {NOISE[self.channel]:g}{unit})"
        )


def separations(first: Record, second: Record, *, measured: Sequence[str] = ()) -> tuple[Separation, ...]:
    """Return the channels that were not measured yet: those that decide first, the cheapest of them in front."""
    reach = min(first.reach, second.reach)
    found = []
    for channel, points in imagined(first, reach).items():
        if channel not in measured:
            one, other = observe(first, points), observe(second, points)
            off = np.nan_to_num(np.abs(one - other)) / NOISE[channel]
            best = int(np.argmax(off))
            series = points.series[int(points.owner[best])]
            side = points.weft0[best] if np.isfinite(points.weft0[best]) else np.nan
            found.append(
                Separation(
                    channel, series.quantity, float(off[best]), float(one[best]), float(other[best]), series.unit,
                    float(points.displacement[best]), float(points.warp0[best]), float(side),
                )
            )  # fmt: skip
    return tuple(sorted(found, key=lambda item: (not item.clear, COST[item.channel] if item.clear else 0, -item.sigma)))


def imagined(record: Record, reach: float) -> dict[str, Points]:
    """Return the points of an ordinary measurement of every channel on a specimen of this size."""
    travel = reach * np.array(SHARES)
    x, y = record.x[-1] * np.array(PLACES), record.y[-1] * np.array(PLACES)
    u1, x1 = _crossed(travel, x)
    u2, x2, y2 = _crossed(travel, x, y)
    u3, y3 = _crossed(travel, y)
    edge = FreeEdge("", u1, x1, x1, np.full_like(x1, record.y[-1]), np.zeros_like(x1), NOISE[EDGE])
    field = StrainField("", u2, x2, y2, np.zeros_like(x2), np.zeros_like(x2), NOISE[STRAIN])
    clamp = ClampLine("", u3, y3, np.zeros_like(y3), NOISE[CLAMP])
    return {
        EDGE: gather(Measurements("", "", free_edge=edge)),
        STRAIN: gather(Measurements("", "", strain_field=field)),
        CLAMP: gather(Measurements("", "", clamp_line=clamp)),
    }


def _crossed(*axes: Array) -> tuple[Array, ...]:
    """Return all combinations, the first axis slowest."""
    return tuple(grid.ravel() for grid in np.meshgrid(*axes, indexing="ij"))
