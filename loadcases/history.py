"""A measured motion as the path of a case: its turning points, without the noise between them.

Of a record (`time_s` and `angle_deg`, `displacement_mm` or `pressure_bar`) only the turning points count that are at
least a given share of its range apart (the hysteresis filter that comes before rainflow counting). As the record stands
for a motion that repeats itself, it is read from its greatest value on and the part before is put behind (ASTM E1049,
section 5.4.5): so the first loading goes to the end once, and what follows are cycles within it.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from etextile.errors import BadInput, Problem
from etextile.types import Array
from etextile.units import shorten
from loadcases.arcs import ARCS
from loadcases.messages import problem_at
from loadcases.schema_parts import Motion
from loadcases.yaml_text import Document


COLUMNS = {"joint": "angle_deg", "pressure": "pressure_bar"}
"""Column of a record by the target of the motion; `displacement_mm` for all others."""
MOST_ROWS = 2_000_000
MOST_FLEXION_DEG = 160.0


def with_history(motion: Motion, document: Document) -> tuple[Motion, list[Problem]]:
    """Return the motion with the turning points of its history as its path, and what is wrong with them."""
    if motion.history is None:
        return motion, []
    try:
        values = _values(motion)
        path = turning_points(values, swing=motion.swing)
    except BadInput as error:
        problems = [
            item if item.file else problem_at(("motion", "history"), item.message, document) for item in error.problems
        ]
        return motion, problems
    problems = [problem_at(("motion", "history"), text, document) for text in _unusable(path, motion)]
    if problems:
        return motion, problems
    key = "flexion" if motion.target == "joint" else "total"
    origin = _origin(motion, path, below=int(np.count_nonzero(values < 0.0)))
    found = {"path": tuple(path.tolist()), key: float(path.max()), "history": None, "path_from": origin}
    return motion.model_copy(update=found), []


def _origin(motion: Motion, path: Array, *, below: int) -> str:
    """Say where a path comes from, and how many readings lay below zero."""
    name = str(motion.history)
    if name in ARCS:
        return f"{name}: {ARCS[name].source}"
    cut = f"; {below} readings below 0 taken as 0" if below else ""
    return f"{Path(name).name}, {len(path)} turning points at least {100 * motion.swing:g} % of its range apart{cut}"


def _values(motion: Motion) -> Array:
    """Return the record (n,) of a file, or the turning points of a shipped arc; raises BadInput."""
    from etextile.importers.table import header_of, read_table  # much to import, and few cases have a history

    name = str(motion.history)
    if name in ARCS:
        if motion.target != "joint":
            raise BadInput.of(f"{name} is an arc of a joint (got target {motion.target}), set motion.target to joint")
        return np.array(ARCS[name].angle_deg)
    path = Path(name)
    if not path.is_file():
        known = ", ".join(ARCS)
        raise BadInput.of(f"no such file (got {shorten(path.name)}), give a CSV or a shipped arc: {known}")
    column = COLUMNS.get(motion.target, "displacement_mm")
    table = read_table(path, ("time_s", column) if "time_s" in header_of(path) else (column,))
    values = table.numbers[column]
    if len(values) > MOST_ROWS:
        raise BadInput.of(f"{len(values)} rows, at most {MOST_ROWS} are read", file=str(path))
    if "time_s" in table.numbers:
        back = np.flatnonzero(np.diff(table.numbers["time_s"]) <= 0.0)
        if back.size:
            message = f"time does not go on (got {table.numbers['time_s'][back[0] + 1]:g}), sort the rows by time"
            raise BadInput.of(message, file=str(path), line=table.line(int(back[0]) + 1), key="time_s")
    return values


def _unusable(path: Array, motion: Motion) -> Iterator[str]:
    """Yield what is wrong with the turning points."""
    if not len(path) or path.max() <= 0.0:
        yield "the history does not move, give one with at least one swing"
    elif motion.target == "joint" and path.max() > MOST_FLEXION_DEG:
        yield f"the joint would bend by {path.max():g} deg, at most {MOST_FLEXION_DEG:g} deg are possible"


def turning_points(values: Array, *, swing: float) -> Array:
    """Return the turning points (m,) of a record (n,) from its greatest value on, at least `swing` of its range apart.

    Values below zero (a joint stretched beyond straight) are taken as zero; rounded to a thousandth of the range.
    """
    values = np.maximum(np.asarray(values, dtype=np.float64), 0.0)
    size = float(np.ptp(values)) if len(values) else 0.0
    if len(values) == 1 or size == 0.0:
        return values[:1]
    top = int(np.argmax(values))
    turned = np.concatenate([values[top:], values[:top], values[top : top + 1]])
    found = [float(turned[0])]
    direction = -1.0
    for value in turned[1:]:
        if direction * (value - found[-1]) >= 0.0:
            if len(found) > 1:
                found[-1] = float(value)
            elif direction * (value - found[-1]) >= swing * size:
                found.append(float(value))
        elif len(found) > 1 and direction * (found[-1] - value) >= swing * size:
            found.append(float(value))
            direction = -direction
    digits = max(0, 3 - int(np.floor(np.log10(size))))
    return np.round(np.array(found), digits)
