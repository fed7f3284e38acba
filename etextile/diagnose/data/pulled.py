"""The force of a pulled clamp over its displacement: strips and coupons at any angle to the yarns."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from etextile.diagnose.data.channel import Channel
from etextile.errors import BadInput
from etextile.importers.options import PLAIN, Options
from etextile.importers.table import read_table
from etextile.types import Array


MAX_LENGTH, MAX_FORCE = 1000.0, 1e6
"""Beyond these a value is in another unit, mm and N."""
FEWEST = 5


@dataclass(frozen=True)
class ClampForce(Channel):
    """Force of one strip as wide as that of the case over the displacement of its clamp, (n,) mm and N.

    `preload`: force (N) at which the displacement was set to zero: what is simulated counts from there, too.
    """

    displacement: Array
    force: Array
    noise: float | None = None
    preload: float = 0.0


def read_clamp_force(
    path: Path, *, noise: float | None = None, strips: int = 1, options: Options = PLAIN
) -> ClampForce:
    """Read `displacement_mm,force_N` of the loading of one specimen; `strips` of them were pulled side by side.

    The displacement must rise from row to row. Where it starts from 0 the force of the first row is the preload.
    """
    table = read_table(path, ("displacement_mm", "force_N"), options=options)
    travel, force = table.numbers["displacement_mm"], table.numbers["force_N"] / strips
    for row in np.flatnonzero(np.diff(travel) <= 0.0)[:1] + 1:
        raise _refused(
            path, table.line(int(row)), "displacement_mm", "does not rise", "leave out repeats and unloading"
        )
    for name, values, limit in (("displacement_mm", travel, MAX_LENGTH), ("force_N", force, MAX_FORCE)):
        row = int(np.abs(values).argmax())
        if abs(values[row]) > limit:
            raise _refused(
                path, table.line(row), name, f"{values[row]:.4g} is beyond {limit:g}", "another unit? convert"
            )
    if len(travel) < FEWEST:
        raise _refused(path, None, "displacement_mm", f"only {len(travel)} rows", f"at least {FEWEST} are needed")
    if travel[0] < 0.0:
        raise _refused(path, table.line(0), "displacement_mm", "starts below 0", "count from where the force begins")
    preload = max(float(force[0]), 0.0) if travel[0] == 0.0 else 0.0
    return ClampForce(
        table.file, travel, force, None if noise is None else noise / strips, preload,
        lines=tuple(table.lines.tolist()), notes=table.notes,
    )  # fmt: skip


def _refused(path: Path, line: int | None, key: str, wrong: str, remedy: str) -> BadInput:
    return BadInput.of(f"{wrong}; {remedy}", file=str(path), line=line, key=key)
