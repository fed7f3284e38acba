"""The report as files: `report.json`, and the tables `wires.csv` and `force_displacement.csv` or `moment_angle.csv`."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from etextile.errors import BadInput
from etextile.files import write_table, write_whole
from wires.axis import JOINT, PUNCH, axis_of
from wires.seal import sealed


LOOP_COLUMNS = (
    "wire",
    "name",
    "weft_mm",
    "wire_state",
    "loop",
    "warp_mm",
    "slack",
    "state",
    "first_failure_mm",
    "max_strain",
    "filaments_broken",
    "failure_probability",
    "open_probability",
    "strain_range",
    "strain_mean",
    "first_plastic_strain",
    "cycles_to_failure",
    "copies",
)
"""Columns of wires.csv; strains, slack and filaments_broken are shares, probabilities lie between 0 and 1."""

CURVE_COLUMNS = (
    "displacement_mm",
    "force_N",
    "warp_strain_max",
    "weft_strain_max",
    "diagonal_strain_max",
    "draw_in_mm",
)


ANGLE_COLUMNS = (
    "angle_deg",
    "moment_Nmm",
    "warp_strain_max",
    "weft_strain_max",
    "diagonal_strain_max",
    "slip_mm",
    "folded_share",
    "pressure_kPa_max",
    "pressure_kPa_mean",
)
"""Columns of the table of a joint."""


def plain(value: Any) -> Any:
    """Return `value` in JSON types: arrays as lists, numpy numbers as Python's, NaN and infinity as None."""
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, dict | Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return plain(value.tolist()) if isinstance(value, np.ndarray | np.generic) else value


def write_report_json(report: Mapping[str, Any], path: Path, *, overwrite: bool = False) -> None:
    """Write `report.json` with its seal; raises BadInput when the file is there and may not be overwritten."""
    text = json.dumps(sealed(plain(report)), indent=1, allow_nan=False, ensure_ascii=False) + "\n"
    _write(text, path, overwrite=overwrite)


def loop_columns(report: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the columns of wires.csv; of a worn case failures stand at angles, and folds are told."""
    if axis_of(report) is PUNCH:
        return LOOP_COLUMNS
    return (*(JOINT.failure_key if name == PUNCH.failure_key else name for name in LOOP_COLUMNS), "folded")


def write_wires_csv(report: Mapping[str, Any], path: Path, *, overwrite: bool = False) -> None:
    """Write one row per wire and loop (`loop_columns`); a wire without loops gets one row with the loop left empty."""
    columns = loop_columns(report)
    rows = [[row.get(name) for name in columns] for row in loop_rows(report)]
    _write_csv(rows, columns, path, overwrite=overwrite)


def loop_rows(report: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the rows of wires.csv: one per wire and loop, and one without a loop for a wire that has none."""
    rows = []
    for wire in report["wires"]:
        head = {"wire": wire["wire"], "name": wire.get("name"), "weft_mm": wire["weft_mm"], "wire_state": wire["state"]}
        rows += [
            {**loop, **head, "weft_mm": loop.get("weft_mm", wire["weft_mm"]), "copies": loop["copies"] * wire["copies"]}
            for loop in wire["loops"]
        ] or [head]
    return rows


def write_force_displacement_csv(report: Mapping[str, Any], path: Path, *, overwrite: bool = False) -> None:
    """Write the curves over the displacement, or of a joint over the angle (`curve_columns`)."""
    _write_csv(curve_rows(report), curve_columns(report), path, overwrite=overwrite)


def curve_columns(report: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the columns of the curves."""
    return CURVE_COLUMNS if axis_of(report) is PUNCH else ANGLE_COLUMNS


def curve_rows(report: Mapping[str, Any]) -> list[tuple[float, ...]]:
    """Return the rows of the table of curves, one per output step."""
    axis, strain = axis_of(report), report["strain"]
    columns = [axis.values(report), axis.responses(report)]
    columns += [strain[f"{family}_max"] for family in ("warp", "weft", "diagonal")]
    if axis is PUNCH:
        columns.append(report["edge"]["draw_in_mm"])
    else:
        joint, contact = report["joint"], report["contact"]
        columns += [joint["slip_mm"], joint["folded_share"]]
        columns += [contact["over_angle"][name] for name in ("pressure_kPa_max", "pressure_kPa_mean")]
    return list(zip(*columns, strict=True))


def _write_csv(rows: Iterable[Sequence[Any]], header: Sequence[str], path: Path, *, overwrite: bool) -> None:
    """Write a table; floats with seven digits, None as an empty field."""
    lines = [header, *([f"{cell:.7g}" if isinstance(cell, float) else cell for cell in row] for row in rows)]
    _refuse_existing(path, overwrite=overwrite)
    write_table(path, lines)


def _write(text: str, path: Path, *, overwrite: bool) -> None:
    _refuse_existing(path, overwrite=overwrite)
    write_whole(path, text)


def _refuse_existing(path: Path, *, overwrite: bool) -> None:
    """Raise BadInput when `path` is there and may not be overwritten."""
    if path.exists() and not overwrite:
        raise BadInput.of("is there already; choose another output folder or give --force", file=str(path))
