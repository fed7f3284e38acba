"""The standard streams as they really are: closed by cron, cut by `head`, in a code page, on a full disk.

Text is a by-product: whatever becomes of it, a simulation writes its files and ends with its own exit code.
"""

from __future__ import annotations

import codecs
import errno
import io
import os
import sys
import unicodedata
from contextlib import suppress
from typing import Any, TextIO


PLAIN = {
    "─": "-", "━": "-", "│": "|", "┃": "|", "╭": "+", "╮": "+", "╰": "+", "╯": "+", "°": " deg", "µ": "u", "μ": "u",
    "×": "x", "±": "+-", "–": "-", "—": "-", "−": "-", "→": "->", "≤": "<=", "≥": ">=", "…": "...", "’": "'",
    "Ω": "Ohm", "█": "#", "·": ".", "“": '"', "”": '"',
}  # fmt: skip
"""What stands for characters that a code page lacks."""


class Outlet(io.RawIOBase):
    """The bytes of a stream; what it does not take is dropped, and `failure` is the first error."""

    def __init__(self, descriptor: int) -> None:
        super().__init__()
        self._descriptor = descriptor
        self.failure: OSError | None = None

    def writable(self) -> bool:
        """Return True."""
        return True

    def fileno(self) -> int:
        """Return the descriptor."""
        return self._descriptor

    def isatty(self) -> bool:
        """Tell whether this is a terminal."""
        return os.isatty(self._descriptor)

    def write(self, data: Any) -> int:
        """Write bytes, or drop them once the stream has failed."""
        if self.failure is None:
            try:
                return os.write(self._descriptor, data)
            except OSError as error:
                self.failure = error
        return len(data)


def prepare() -> Outlet:
    """Make the standard streams safe to print to, and return what is below the output."""
    for descriptor in (0, 1, 2):
        _occupied(descriptor)
    codecs.register_error("plain", _plainly)
    below = Outlet(1)
    sys.stdout = _text(below, sys.stdout)
    sys.stderr = _text(Outlet(2), sys.stderr)
    return below


def ended(below: Outlet) -> str:
    """Flush the output; return what is to be said of it: '' also where the reader had enough (`| head`)."""
    with suppress(ValueError):
        sys.stdout.flush()
    if below.failure is None or below.failure.errno == errno.EPIPE:
        return ""
    return f"etextile: the text could not be written ({below.failure.strerror})"


def _occupied(descriptor: int) -> None:
    """Open nothing in place of a closed stream, so that no file of ours gets its number and the text of others."""
    try:
        os.fstat(descriptor)
    except OSError:
        nothing = os.open(os.devnull, os.O_RDWR)
        if nothing != descriptor:
            os.dup2(nothing, descriptor)
            os.close(nothing)


def _text(below: Outlet, before: TextIO | None) -> TextIO:
    """Return a text stream over an outlet in the encoding that the stream has now."""
    if before is not None:
        with suppress(OSError, ValueError):
            before.flush()
    encoding = getattr(before, "encoding", None) or "utf-8"
    return io.TextIOWrapper(io.BufferedWriter(below), encoding, errors="plain", line_buffering=True)


def _plainly(error: UnicodeError) -> tuple[str, int]:
    """Replace what an encoding lacks by something like it, at last by a question mark."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    text = error.object[error.start : error.end]
    return "".join(_like(character) for character in text), error.end


def _like(character: str) -> str:
    """Return plain letters for one character."""
    if character in PLAIN:
        return PLAIN[character]
    plain = unicodedata.normalize("NFKD", character).encode("ascii", "ignore").decode()
    return plain or "?"
