"""Slack and crimp that size-loops found, as text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from etextile.text.columns import Columns
from wires.sizing_words import sentences
from wires.trust import as_provisional
from wires.wording import number, probability


MOST_ROWS = 20


def sizing(data: Mapping[str, Any], folder: Path, *, every: bool = False) -> Iterator[str | Columns]:
    """Yield the sizes, those of the worst loops first (`every`: of all), what they mean, and notes."""
    rows = sorted(data["loops"], key=lambda row: -row["span_strain"])
    shown = rows if every else rows[:MOST_ROWS]
    per = "wire" if data.get("whole_wires") else data["per"]
    title = (
        f"Slack for a probability of at most {data['target']:g} per {per} that a filament breaks, by "
        f"{data['criterion']} ({len(shown)} of {len(rows)} loops, worst first)"
    )
    yield Columns(
        as_provisional(title, passed=data["verdict"]["withheld"]),
        ("wire", "loop", "weft, mm", "warp, mm", "fabric strain", "slack now", "P now", "slack", "P then"),
        [_row(row) for row in shown],
    )
    yield from sentences(data)
    yield from (f"note: {note}" for note in data["notes"])
    yield f"Files in {folder}"


def _row(row: Mapping[str, Any]) -> tuple[str, ...]:
    return (
        str(row["name"]),
        str(row["loop"]),
        f"{row['weft_mm']:.1f}",
        f"{row['warp_mm']:.1f}",
        f"{row['span_strain']:.3f}",
        f"{row['slack_now']:.3f}",
        probability(row["probability_now"]),
        number(row["slack"], "{:.3f}"),
        probability(row["probability"]),
    )
