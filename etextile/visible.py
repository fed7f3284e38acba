"""Characters that do not show are written out, so that a text of somebody else is text wherever it goes.

A title may hold terminal escapes, characters that turn the direction of what follows, or halves of characters that no
file can hold. What comes from a file passes here once, at the edge.
"""

from __future__ import annotations

import re
from typing import Any


HIDDEN = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f"  # control characters but tab and line feed
    "\u200e\u200f\u061c\u202a-\u202e\u2066-\u2069"  # marks that turn the direction of writing
    "\u200b\u2060\u2028\u2029"  # marks without width, separators of lines
    "\ufeff\ufffe\uffff\ud800-\udfff]"  # no characters, halves of characters
)


def visible(text: str) -> str:
    r"""Return a text in which every character that does not show is spelled, such as \\x1b for the escape."""
    return HIDDEN.sub(lambda found: _spelled(found[0]), text)


def visible_data(data: Any) -> Any:
    """Return data of a JSON file with `visible` texts and keys."""
    if isinstance(data, str):
        return visible(data)
    if isinstance(data, dict):
        return {visible(key): visible_data(value) for key, value in data.items()}
    if isinstance(data, list):
        return [visible_data(item) for item in data]
    return data


def _spelled(character: str) -> str:
    code = ord(character)
    return f"\\x{code:02x}" if code < 256 else f"\\u{code:04x}"
