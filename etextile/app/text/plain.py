"""Rich content as plain text, for files, pipes and tests."""

from __future__ import annotations

import io

from rich.console import Console, RenderableType


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
