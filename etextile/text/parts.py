"""Parts on a terminal: where they are and what the wires bear at their lands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.table import Table

from etextile.text.plain import framed
from wires.wording import number


Report = Mapping[str, Any]
MOST_PARTS = 24
"""Rows of the table of parts; of more those with the greatest strain."""


def part_table(parts: Sequence[Report]) -> Table:
    """Return where parts are and what the wires bear at their lands."""
    chosen = sorted(parts, key=lambda part: -(part["max_strain"] or 0.0))[:MOST_PARTS]
    shown = [part for part in parts if part in chosen]
    title = "Parts" if len(shown) == len(parts) else f"Parts ({len(shown)} of {len(parts)} with the greatest strain)"
    table = framed(title, "part\n", "warp\nmm", "weft\nmm", "land\nmm", "strain\nat it", "in\n", words=("part", "in"))
    table.add_column("wires\n", overflow="fold")
    for part in shown:
        size = " x ".join(f"{length:g}" for length in part["size_mm"])
        table.add_row(
            str(part["name"]),
            f"{part['warp_mm']:.1f}",
            f"{part['weft_mm']:.1f}",
            size if part["rigid"] else "none",
            number(part["max_strain"], "{:.3f}"),
            str(part["worst_wire"] or ""),
            " ".join(part["wires"]),
        )
    return table
