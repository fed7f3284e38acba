"""Gap and diagnosis on a terminal, drawn from their dictionaries alone; readable at 80 columns and without colours."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.box import ROUNDED, SIMPLE_HEAD
from rich.console import Console, Group, RenderableType
from rich.panel import Panel
from rich.table import Table
from rich.text import Text

from etextile.diagnose.where import NAMES


Data = Mapping[str, Any]
MOST_CANDIDATES = 8
STYLES = {"no_gap": "green", "named": "green", "ambiguous": "yellow", "unexplained": "red"}
TITLES = {
    "no_gap": "Verdict: no gap",
    "named": "Verdict: named",
    "ambiguous": "Verdict: ambiguous",
    "unexplained": "Verdict: unexplained",
}


def compare_text(data: Data, *, folder: Path | None = None) -> str:
    """Return what compare found as text of 80 columns."""
    parts: list[RenderableType] = [_head(data)]
    if data["gap"]:
        agree = data["agree"]
        words = "Simulation and measurement agree within noise." if agree else data["sentence"] + "."
        style = "green" if agree else "yellow"
        parts.append(Panel(Text(words), title="Gap", title_align="left", border_style=style, box=ROUNDED))
        table = _table("Gap per channel", "channel", "gap, %", "chi", "points", "up to, mm", words=("channel",))
        for row in data["gap"]:
            table.add_row(
                NAMES.get(row["channel"], row["channel"]), f"{row['percent']:.1f}", f"{row['chi']:.1f}",
                str(row["points"]), f"{row['up_to_mm']:.1f}",
            )  # fmt: skip
        parts += [table, Text(" chi: root mean square difference in standard deviations of the noise", style="dim")]
        parts += [Text(f" {item['sentence']}") for item in data["where"]] if not agree else []
    parts += _notes(data, folder)
    return as_text(Group(*parts))


def _head(data: Data) -> RenderableType:
    """The case, the measurement, and where the fabric's parameters come from."""
    return Group(
        Text(data["case"]["title"], style="bold"),
        Text(f"measured: {data['measured']['title']}\nfabric: {data['fabric']}\n", style="dim"),
    )


def _notes(data: Data, folder: Path | None) -> list[RenderableType]:
    parts: list[RenderableType] = [Text(f"note: {note}", style="yellow") for note in data.get("notes", ())]
    if folder is not None:
        parts.append(Text(f"\nFiles in {folder}", overflow="fold"))
    return parts


def _table(title: str, *columns: str, words: Sequence[str] = ()) -> Table:
    """Return an empty table with a title; `words` are columns of text, on the left."""
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), show_edge=False, title=f"\n {title}", title_justify="left")
    table.title_style = "bold"
    for name in columns:
        left = name in words
        table.add_column(name, justify="left" if left else "right", no_wrap=not left, overflow="fold")
    return table


def as_text(content: RenderableType, *, width: int = 80) -> str:
    """Return content as plain text of the given width."""
    console = Console(file=io.StringIO(), width=width, color_system=None, force_terminal=False, legacy_windows=False)
    console.print(content)
    text: str = console.file.getvalue()  # type: ignore[attr-defined]
    return "\n".join(line.rstrip() for line in text.splitlines()) + "\n"
