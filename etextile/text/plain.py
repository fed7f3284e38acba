"""Rich content as plain text, for files, pipes and tests, and the one look of its tables."""

from __future__ import annotations

import io
from collections.abc import Container

from rich.box import SIMPLE_HEAD
from rich.console import Console, JustifyMethod, RenderableType
from rich.table import Table


def as_text(content: RenderableType, *, width: int = 80) -> str:
    """Return rich content as plain text of the given width."""
    stream = io.StringIO()
    console = Console(
        file=stream,
        width=width,
        color_system=None,
        force_terminal=False,
        legacy_windows=False,
        markup=False,
        emoji=False,
    )
    console.print(content)
    return "\n".join(line.rstrip() for line in stream.getvalue().splitlines()) + "\n"


def framed(title: str, *names: str, words: Container[str] = (), fold: Container[str] = ()) -> Table:
    """Return an empty table with a title above it, numbers on the right.

    `words`: first words of the names whose columns hold text, on the left; `fold`: of those that may be wrapped.
    """
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), show_edge=False, title=f"\n {title}", title_justify="left")
    table.title_style = "bold"
    for name in names:
        first = (name.split() or [""])[0]
        justify: JustifyMethod = "left" if first in words or first in fold else "right"
        table.add_column(name, justify=justify, no_wrap=first not in fold, overflow="fold")
    return table
