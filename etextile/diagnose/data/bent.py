"""The bending moment of a fabric over its curvature, as bending testers and cantilevers give it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from etextile.diagnose.data.channel import Channel
from etextile.diagnose.data.checks import check_count, check_rising, check_size, lines_of, refused
from etextile.importers.options import PLAIN, Options
from etextile.importers.table import read_table
from etextile.types import Array


MAX_CURVATURE, LEAST_CURVATURE = 2000.0, 0.2
"""1/m: radii of 0.5 mm, and of 5 m at the end of a record; beyond both a value is in another unit."""
MAX_MOMENT = 100.0
"""N m/m: a plate; beyond it a value is in another unit."""


@dataclass(frozen=True)
class MomentCurvature(Channel):
    """Moment per width over the curvature of one specimen, (n,) N m/m and 1/m."""

    curvature: Array
    moment: Array
    noise: float | None = None


def read_moment_curvature(path: Path, *, noise: float | None = None, options: Options = PLAIN) -> MomentCurvature:
    """Read `curvature_1_per_m,moment_Nm_per_m` of one specimen: the first bending, the curvature rises row by row."""
    table = read_table(path, ("curvature_1_per_m", "moment_Nm_per_m"), options=options)
    curvature, moment = table.numbers["curvature_1_per_m"], table.numbers["moment_Nm_per_m"]
    check_rising(table, "curvature_1_per_m", remedy="leave out repeats and the way back")
    if curvature[0] < 0.0:
        raise refused(table, 0, "curvature_1_per_m", "is below 0", "give the bending to one side")
    check_size(table, "curvature_1_per_m", curvature, limit=MAX_CURVATURE, remedy="another unit? convert to 1/m")
    check_size(table, "moment_Nm_per_m", moment, limit=MAX_MOMENT, remedy="convert to N m per m of width")
    if curvature[-1] < LEAST_CURVATURE:
        wrong = f"ends at {curvature[-1]:.4g}"
        raise refused(table, len(curvature) - 1, "curvature_1_per_m", wrong, "1/mm? convert to 1/m")
    check_count(table)
    return MomentCurvature(table.file, curvature, moment, noise, lines=lines_of(table), notes=table.notes)
