"""What all measured channels have in common: the file they stand in."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Channel:
    """What all channels have: the file, the line of it that each row stands in (empty when not read from one), and

    `notes`: how the file was read and what of it was left out, where that is worth a word.
    """

    file: str
    lines: tuple[int, ...] = field(default=(), kw_only=True, repr=False)
    notes: tuple[str, ...] = field(default=(), kw_only=True, repr=False)

    def line(self, row: int) -> int | None:
        """Return the line that a row stands in, None when it was not read from a file."""
        return self.lines[row] if self.lines else None
