"""Where the shipped cases, fabrics and wire materials are, and how a name or a path given by a user finds its file."""

from __future__ import annotations

import difflib
import os
from pathlib import Path

from etextile.errors import BadInput, nearest
from etextile.files import too_long


ROOT = Path(__file__).resolve().parent
FOLDERS = {"case": ROOT, "fabric": ROOT / "fabrics", "wire material": ROOT / "wires"}
SUFFIXES = (".yaml", ".yml")


def names(kind: str) -> tuple[str, ...]:
    """Return the shipped names of a kind ('case', 'fabric' or 'wire material')."""
    return tuple(sorted(path.stem for path in FOLDERS[kind].glob("*.yaml")))


def is_path(name: str) -> bool:
    """Tell a path from a shipped name: a path has a folder in it or ends with .yaml or .yml."""
    return name.endswith(SUFFIXES) or "/" in name or os.sep in name or name.startswith("~")


def find(kind: str, name: str, *, folder: Path | None = None) -> Path:
    """Return the file behind a shipped name or a path (relative to `folder`); raises BadInput with what is near."""
    if found := too_long(name):
        raise BadInput.of(found)
    if not is_path(name) and name in names(kind):
        return FOLDERS[kind] / f"{name}.yaml"
    path = Path(name).expanduser()
    path = path if path.is_absolute() or folder is None else folder / path
    if path.is_file():
        return path
    raise BadInput.of(_why_not(kind, name, path))


def _why_not(kind: str, name: str, path: Path) -> str:
    """Say why no file was found: a folder, a path that is missing, or an unknown name."""
    if path.is_dir():
        inside = ", ".join(sorted(item.name for item in path.glob("*.y*ml"))[:5])
        hint = f", it holds {inside}" if inside else ""
        return f"this is a folder, not a {kind} file (got {name!r}){hint}"
    if path.exists():
        return f"this is a device or a pipe, not a {kind} file (got {name!r}), give an ordinary file"
    if is_path(name):
        if not path.parent.is_dir():
            return (
                f"no such folder (got {str(path.parent)!r}), give a path or a shipped {kind}: {', '.join(names(kind))}"
            )
        near = _nearest_file(kind, path)
        return f"no such file (got {name!r}), give a path or a shipped {kind}: {', '.join(names(kind))}{near}"
    known = names(kind)
    return f"no such {kind} (got {name!r}), shipped are {', '.join(known)}, or give a path{nearest(name, known)}"


def _nearest_file(kind: str, path: Path) -> str:
    """Suggest a shipped name that equals the file's stem, else a file beside it with a similar stem."""
    if path.stem in names(kind):
        return f", did you mean {path.stem!r}?"
    beside = {item.stem: item.name for item in path.parent.glob("*.y*ml")}
    match = difflib.get_close_matches(path.stem, list(beside), n=1, cutoff=0.7)
    return f", did you mean {beside[match[0]]!r}?" if match else ""
