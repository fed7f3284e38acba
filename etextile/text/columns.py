"""A table of text: on a terminal with a frame and wrapping, elsewhere plain aligned columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING


if TYPE_CHECKING:
    from rich.table import Table


@dataclass(frozen=True)
class Columns:
    """A table: title, names of the columns, rows of text."""

    title: str
    names: Sequence[str]
    rows: Sequence[Sequence[str]]

    def __str__(self) -> str:
        """Return the table as lines with aligned columns, an empty one at the end."""
        widths = [max(len(row[index]) for row in (self.names, *self.rows)) for index in range(len(self.names))]
        lines = [
            "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
            for row in (self.names, *self.rows)
        ]
        return "\n".join([f"{self.title}:", *(f"  {line}" for line in lines), ""])

    def __rich__(self) -> Table:
        """Return the table for a terminal."""
        from rich.box import SIMPLE_HEAD
        from rich.table import Table
        from rich.text import Text

        table = Table(box=SIMPLE_HEAD, title=self.title, title_justify="left", title_style="bold", show_edge=False)
        for index, name in enumerate(self.names):
            table.add_column(name, style="cyan" if index == 0 else "", no_wrap=index == 0, overflow="fold")
        for row in self.rows:
            table.add_row(*(Text(cell) for cell in row))
        return table
