"""Words and tables on the standard output: tables drawn where it is a terminal, plain where it is piped."""

from __future__ import annotations

import sys
from collections.abc import Iterable

from etextile.text.columns import Columns


def show(blocks: Iterable[str | Columns]) -> None:
    """Print lines and tables one after the other."""
    terminal = sys.stdout.isatty()
    for block in blocks:
        if terminal and isinstance(block, Columns):
            from rich.console import Console

            Console(markup=False, emoji=False).print(block, "")
        else:
            print(block)
