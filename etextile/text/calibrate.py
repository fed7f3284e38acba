"""What a calibration found, on a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any


def calibration_text(data: Mapping[str, Any], files: Sequence[Path]) -> str:
    """Return parameters with intervals, what the data leave open, errors seen and unseen, and the files."""
    return "\n".join(_lines(data, files))


def surface_text(data: Mapping[str, Any], folder: Path) -> str:
    """Return the gap of a case to heights and fields, specimen by specimen."""
    lines = [f"{data['case']['title']} against {data['measured']['title']} (fabric: {data['fabric']})"]
    for row in data["gap"]:
        line, ends = row["measured_over_computed"], row["mean_difference"]
        lines += [
            f"  {row['specimen']}: {_error(row)}",
            f"    measured = {line['offset']:+.3g} + {line['factor']:.3f} x computed; measured - computed on average "
            f"{ends[0]:+.2f} at the first load, {ends[1]:+.2f} at the last",
        ]
    for row in data["registration"]:
        x, y = row["centre_mm"]
        left = row["sum_of_mean_absolute_mm"]
        lines.append(f"  {row['specimen']}: with its centre at ({x:.1f}, {y:.1f}) mm {left:.3f} mm would be left")
    if data.get("wires"):
        found = data["wires"]
        lines.append(
            f"  observed wires: {found['hits']} of {len(found['places'])} places agree on whether a filament is "
            f"broken, {found['false_alarms']} false alarms, {found['missed_breaks']} missed breaks"
        )
        lines += [f"  left out: {sentence}" for sentence in found["left_out"]]
    lines += [f"note: {note}" for note in data["notes"]]
    return "\n".join([*lines, f"Files in {folder}"])


def _lines(data: Mapping[str, Any], files: Sequence[Path]) -> Iterator[str]:
    yield f"{data['case']['title']}: calibrated on {data['measured']['title']}"
    width = max(len(name) for name in data["parameters"])
    for name, row in data["parameters"].items():
        span = f"[{row['low']:.4g}, {row['high']:.4g}]" if row["identified"] else "left open by the data"
        yield f"  {name:<{width}}  {row['value']:.5g}  {span}  (from {row['start']:.4g})"
    for pair in data["open"]:
        first, second = pair["parameters"]
        yield f"  only a combination of {first} and {second} is known (correlation {pair['correlation']:.3f})"
    yield "gap, with what was fitted:"
    yield from (f"  {row['specimen']}: {_error(row)}" for row in data["gap"])
    if data["held_out"]:
        yield "gap, of what was left out:"
        yield from (f"  {row['left_out']}: {_error(row)}{_foretold(row)}" for row in data["held_out"])
    if data["between_specimens"] is not None:
        yield from _between(data["between_specimens"])
    for row in data["lattice"]:
        change = f"{row['channel']} changes by {row['change_percent']:.2g} %"
        yield f"finer lattice (coarsening {row['coarsening']:.3g}): {change}"
    yield from (f"note: {note}" for note in data["notes"])
    yield f"{data['simulations']} simulations, {data['wall_s']:g} s"
    yield f"Files: {', '.join(str(file) for file in files)}"


def _between(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield how specimens differ in stiffness and what a further one should show."""
    each = ", ".join(f"{row['specimen']} {row['factor']:.2f}" for row in data["specimens"])
    spread, further = data["std_of_log"], data["further_specimen"]
    span = f"{spread['value']:.2f} [{spread['low']:.2f}, {spread['high']:.2f}]"
    yield f"between specimens, stiffness over that of the fit: {each}; their logarithm scatters by {span}"
    factor = further["factor"]
    yield f"  a further specimen: {factor['value']:.2f} [{factor['low']:.2f}, {factor['high']:.2f}]"
    for row, error in zip(further["readings"], further["error"], strict=True):
        unit = "mm" if error["measure"] != "percent" else "%"
        yield (
            f"    {row['channel']} at {row['at']:.4g}: {row['value']:.4g} {row['unit']} [{row['low']:.4g}, "
            f"{row['high']:.4g}], missed by {error['value']:.3g} {unit} [{error['low']:.3g}, {error['high']:.3g}]"
        )


def _foretold(row: Mapping[str, Any]) -> str:
    """Return what the scatter of the others foretold of a specimen's error."""
    found = row.get("foretold")
    if found is None:
        return ""
    return f" (foretold {found['value']:.3g} [{found['low']:.3g}, {found['high']:.3g}])"


def _error(row: Mapping[str, Any]) -> str:
    sums = row.get("sum_of_mean_absolute_mm")
    more = "" if sums is None else f", mean |dx| + |dy| + |dz| {sums:.3f} mm"
    return f"{row['channel']} {row['percent']:.2f} %{more}"
