"""Arrays kept for later: caches and samples, written whole with a digest, taken as not there when anything is wrong.

What is kept can always be computed again, so a file that is damaged, incomplete or of another kind is no error: a
reader that gets None makes it anew. Every value in it is covered by the digest.
"""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from etextile.errors import BadInput
from etextile.files import read_bounded, write_whole


DIGEST = "sha256"
MOST_BYTES = 2_000_000_000
"""Bytes of a file, and of what it says it holds."""


def keep(path: Path, arrays: Mapping[str, Any], *, packed: bool = True) -> None:
    """Write arrays by name, forced to the disk before the file gets its name; a link at its place is replaced."""
    content = {name: np.asarray(values) for name, values in arrays.items()}
    stream = io.BytesIO()
    save: Any = np.savez_compressed if packed else np.savez
    save(stream, **content, **{DIGEST: np.array(_digest(content))})
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, stream.getvalue())


def recall(path: Path, names: Iterable[str]) -> dict[str, NDArray[Any]] | None:
    """Return the arrays of these names, None when there is no such file or any part of it is not as it was kept."""
    try:
        data = read_bounded(path, MOST_BYTES)
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(item.file_size for item in archive.infolist()) > MOST_BYTES:
                return None
        with np.load(io.BytesIO(data), allow_pickle=False) as stored:
            content = {name: stored[name] for name in stored.files}
        digest = str(content.pop(DIGEST))
    except BadInput:
        return None
    except Exception:  # a damaged file may end in any error of zip, zlib, numpy or the parser of its headers
        return None
    return content if digest == _digest(content) and set(names) <= set(content) else None


def code_digest(root: Path, parts: Iterable[str]) -> str:
    """Return a hash of the Python files in these folders (or of these files) below `root`, names included."""
    found = hashlib.sha256()
    for part in parts:
        place = root / part
        for path in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            found.update(str(path.relative_to(root)).encode())
            found.update(hashlib.sha256(path.read_bytes()).digest())
    return found.hexdigest()


def _digest(content: Mapping[str, NDArray[Any]]) -> str:
    """Return the digest of names, types, shapes and values."""
    found = hashlib.sha256()
    for name in sorted(content):
        values = content[name]
        found.update(repr((name, values.dtype.str, values.shape)).encode())
        found.update(np.ascontiguousarray(values).tobytes())
    return found.hexdigest()
