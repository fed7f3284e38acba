"""The bending moment of a fabric over its curvature, as bending testers and cantilevers give it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from etextile.diagnose.data.channel import Channel
from etextile.errors import BadInput
from etextile.importers.options import PLAIN, Options
from etextile.importers.table import FileTable, read_table
from etextile.types import Array


MAX_CURVATURE, LEAST_CURVATURE = 2000.0, 0.2
"""1/m: radii of 0.5 mm, and of 5 m at the end of a record; beyond both a value is in another unit."""
MAX_MOMENT = 100.0
"""N m/m: a plate; beyond it a value is in another unit."""
FEWEST = 5


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
    for row in np.flatnonzero(np.diff(curvature) <= 0.0)[:1] + 1:
        raise _refused(table, int(row), "curvature_1_per_m", "does not rise", "leave out repeats and the way back")
    if curvature[0] < 0.0:
        raise _refused(table, 0, "curvature_1_per_m", "is below 0", "give the bending to one side")
    sizes = (
        ("curvature_1_per_m", curvature, MAX_CURVATURE, "another unit? convert to 1/m"),
        ("moment_Nm_per_m", moment, MAX_MOMENT, "another unit? convert to N m per m of width"),
    )
    for name, values, limit, remedy in sizes:
        row = int(np.abs(values).argmax())
        if abs(values[row]) > limit:
            raise _refused(table, row, name, f"{values[row]:.4g} is beyond {limit:g}", remedy)
    if curvature[-1] < LEAST_CURVATURE:
        row, wrong = len(curvature) - 1, f"ends at {curvature[-1]:.4g}"
        raise _refused(table, row, "curvature_1_per_m", wrong, "1/mm? convert to 1/m")
    if len(curvature) < FEWEST:
        raise _refused(table, 0, "", f"only {len(curvature)} rows", f"at least {FEWEST} are needed")
    return MomentCurvature(table.file, curvature, moment, noise, lines=tuple(table.lines.tolist()), notes=table.notes)


def _refused(table: FileTable, row: int, key: str, wrong: str, remedy: str) -> BadInput:
    return BadInput.of(f"{wrong}; {remedy}", file=table.file, line=table.line(row), key=key)
