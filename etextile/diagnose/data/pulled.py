"""The force of a pulled clamp over its displacement: strips and coupons at any angle to the yarns."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from etextile.diagnose.data.channel import Channel
from etextile.diagnose.data.checks import (
    MAX_FORCE,
    MAX_LENGTH,
    check_count,
    check_rising,
    check_size,
    lines_of,
    refused,
)  # fmt: skip
from etextile.importers.options import PLAIN, Options
from etextile.importers.table import read_table
from etextile.types import Array


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
    check_rising(table, "displacement_mm")
    check_size(table, "displacement_mm", travel, limit=MAX_LENGTH, remedy="um? convert to mm")
    check_size(table, "force_N", force, limit=MAX_FORCE, remedy="mN? convert to N")
    check_count(table)
    if travel[0] < 0.0:
        raise refused(table, 0, "displacement_mm", "starts below 0", "count from where the force begins")
    preload = max(float(force[0]), 0.0) if travel[0] == 0.0 else 0.0
    return ClampForce(
        table.file, travel, force, None if noise is None else noise / strips, preload,
        lines=lines_of(table), notes=table.notes,
    )  # fmt: skip
