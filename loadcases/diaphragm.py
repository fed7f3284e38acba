"""The curve of a diaphragm in a case: read from the file that names it, as points that any copy of the case carries."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from etextile.errors import BadInput, Problem
from etextile.units import shorten
from loadcases.messages import problem_at
from loadcases.schema_parts import Motion
from loadcases.yaml_text import Document


MOST_ROWS = 5000


def with_diaphragm(motion: Motion, document: Document) -> tuple[Motion, list[Problem]]:
    """Return the motion with the curve of its diaphragm's file as points, and what is wrong with them."""
    if motion.diaphragm is None and motion.diaphragm_curve is None:
        return motion, []
    from etextile.motion.diaphragm import faults

    key = "diaphragm" if motion.diaphragm is not None else "diaphragm_curve"
    try:
        height, pressure, lines = _points(motion)
    except BadInput as error:
        own = (item if item.file else problem_at(("motion", key), item.message, document) for item in error.problems)
        return motion, list(own)
    found = faults(height, pressure)
    if motion.diaphragm is not None:
        problems = [Problem(text, file=motion.diaphragm, line=lines[row]) for row, text in found]
    else:
        problems = [problem_at(("motion", key, row), text, document) for row, text in found]
    if problems:
        return motion, problems
    curve = tuple(zip(height.tolist(), pressure.tolist(), strict=True))
    return motion.model_copy(update={"diaphragm": None, "diaphragm_curve": curve}), []


def _points(motion: Motion) -> tuple[np.ndarray, np.ndarray, list[int]]:
    """Return heights (n,) mm and pressures (n,) bar, with the line of each in the file; raises BadInput."""
    if motion.diaphragm is None:
        height, pressure = np.array(motion.diaphragm_curve, dtype=float).T
        return height, pressure, []
    from etextile.importers.table import read_table

    path = Path(motion.diaphragm)
    if not path.is_file():
        raise BadInput.of(f"no such file (got {shorten(path.name)}), give a CSV of pressure_bar,height_mm")
    table = read_table(path, ("pressure_bar", "height_mm"))
    if len(table) > MOST_ROWS:
        raise BadInput.of(f"{len(table)} rows, at most {MOST_ROWS} are read", file=str(path))
    return table.numbers["height_mm"], table.numbers["pressure_bar"], [int(line) for line in table.lines]
