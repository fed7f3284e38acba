"""Gaps in numbers: per channel and part, before and after, in per cent and in standard deviations of the noise.

Per cent: root mean square difference over the part divided by the root mean square of the measured values (for the
free edge, of its measured motion since rest). chi: root mean square of the difference in standard deviations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from etextile.diagnose.data.points import Points
from etextile.types import Array, BoolArray


FITTED, HELD_OUT = "fitted", "held_out"


@dataclass(frozen=True)
class Gap:
    """Gap of one channel over one part."""

    channel: str
    part: str
    before_percent: float
    after_percent: float
    before_chi: float
    after_chi: float

    @property
    def closed(self) -> float:
        """Share of the gap in per cent that is gone."""
        return 1.0 - self.after_percent / self.before_percent if self.before_percent > 0.0 else 0.0


def gap_percent(difference: Array, size: Array) -> float:
    """Return 100 x rms(difference) / rms(size)."""
    reference = float(np.sqrt(np.mean(size**2)))
    return 100.0 * float(np.sqrt(np.mean(difference**2))) / reference if reference > 0.0 else 0.0


def gaps(
    points: Points, before: Array, after: Array, *, deviation: Array, rest: Array, held_out: BoolArray
) -> tuple[Gap, ...]:
    """Return the gaps of all channels over both parts.

    `before`, `after` (n,): predictions; `deviation` (n,): of the noise; `rest` (n,): values at rest, which are taken
    off before sizes are compared; `held_out` (n,): points of the held-out part.
    """
    found = []
    for channel in points.channels:
        for part, chosen in ((FITTED, ~held_out), (HELD_OUT, held_out)):
            own = points.of(channel) & chosen & np.isfinite(before) & np.isfinite(after)
            if not own.any():
                continue
            size = points.value[own] - rest[own]
            first, last = points.value[own] - before[own], points.value[own] - after[own]
            sigma = deviation[own]
            found.append(Gap(
                channel, part, gap_percent(first, size), gap_percent(last, size),
                float(np.sqrt(np.mean((first / sigma) ** 2))), float(np.sqrt(np.mean((last / sigma) ** 2))),
            ))  # fmt: skip
    return tuple(found)


def rows_of(gaps_by_row: Mapping[str, tuple[Gap, ...]]) -> list[dict[str, float | str]]:
    """Return one row per channel and part for a table whose columns are named predictions."""
    rows: dict[tuple[str, str], dict[str, float | str]] = {}
    for name, found in gaps_by_row.items():
        for gap in found:
            row = rows.setdefault((gap.channel, gap.part), {"channel": gap.channel, "part": gap.part})
            row[name] = gap.after_percent
    return list(rows.values())
