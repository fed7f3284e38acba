"""What a comparison of two designs says, on a terminal of 80 columns, from `compare.json` alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.box import ROUNDED
from rich.console import Group, RenderableType
from rich.panel import Panel
from rich.text import Text

from etextile.studies.ensemble.differs import words as in_words
from etextile.text.plain import as_text, framed
from wires.trust import as_provisional
from wires.wording import chance, number, probability


MOST_DIFFERENCES = 8
EVENTS = {
    "any_failure": "some wire lost a filament",
    "any_open": "some wire interrupted",
    "share_failed": "wires that lost a filament",
    "share_open": "wires interrupted",
}


def compare_text(data: Mapping[str, Any], *, folder: Path | None = None) -> str:
    """Return the comparison as plain text."""
    designs = data["designs"]
    parts: list[RenderableType] = [
        Text(f"{name}: {item['title']}" + (f" ({item['case']})" if item["case"] else ""), style="bold")
        for name, item in designs.items()
    ]
    differs = data.get("differs", [])
    parts += [Text(f"differs: {in_words(item)}", style="dim", overflow="fold") for item in differs[:MOST_DIFFERENCES]]
    if len(differs) > MOST_DIFFERENCES:
        parts.append(Text(f"and {len(differs) - MOST_DIFFERENCES} more keys in compare.json", style="dim"))
    parts.append(Text(f"{data['samples']} pairs of samples, seed {data['seed']}\n", style="dim"))
    parts.append(Panel(Text(data["verdict"]["sentence"]), title="Which design", title_align="left", box=ROUNDED))
    parts += [_events(data), _wires(data), Text("")]
    parts += [Text(f"note: {note}", style="yellow") for note in data["notes"]]
    if folder is not None:
        parts.append(
            Text(f"\nFiles in {folder}: compare.html, compare.json, plots, and the ensembles A and B", overflow="fold")
        )
    return as_text(Group(*parts))


def _events(data: Mapping[str, Any]) -> RenderableType:
    held = data["verdict"]["withheld"]
    table = framed(
        as_provisional("At the end of the motion", passed=held), "", "A", "B", "B - A, points", "95 %", words=("",)
    )
    first, second = (item["specimen"] for item in data["designs"].values())
    for name, words in EVENTS.items():
        change = data["difference"][name]
        interval = f"{100 * change['low']:+.1f} .. {100 * change['high']:+.1f}"
        own = (chance(first[name]["value"]), chance(second[name]["value"]))
        table.add_row(words, *own, f"{100 * change['value']:+.1f}", interval)
    gain = data["first_failure_mm"]
    interval = f"{number(gain['low'], '{:+.2f}')} .. {number(gain['high'], '{:+.2f}')}"
    halves = (number(item["half_failed_mm"]["value"], "{:.1f}") for item in (first, second))
    table.add_row(
        f"first break, {data.get('unit', 'mm').replace('**', '')}", *halves, number(gain["value"], "{:+.2f}"), interval
    )
    return table


def _wires(data: Mapping[str, Any]) -> RenderableType:
    rows = [row for row in data["wires"] if row["low"] > 0.0 or row["high"] < 0.0]
    title = "Wires that differ" if rows else "No single wire differs beyond its interval"
    table = framed(title, "A", "B", "weft, mm", "P in A", "P in B", "B - A", "95 %")
    for row in rows:
        places = [f"{place:.1f}" for place in row["weft_mm"]]
        table.add_row(
            *(row["names"] if "names" in row else (str(row["A"]), str(row["B"]))),
            places[0] if places[0] == places[1] else " / ".join(places),
            *(probability(value) for value in row["failure_probability"]),
            f"{row['difference']:+.3f}",
            f"{row['low']:+.3f} .. {row['high']:+.3f}",
        )
    return table if rows else Text(f"\n {title}")
