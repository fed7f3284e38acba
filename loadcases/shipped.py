"""Shipped measurements by name, so that a diagnosis can be tried from any folder."""

from __future__ import annotations

from pathlib import Path

from etextile.errors import BadInput, nearest
from loadcases.catalogue import ROOT, is_path


FOLDER = ROOT / "data"
NAME = "measured.yaml"


def measured_names() -> tuple[str, ...]:
    """Return the names of the shipped folders of measurements."""
    return tuple(sorted(path.parent.name for path in FOLDER.glob(f"*/{NAME}")))


def measured_folder(name: str) -> Path:
    """Return the shipped folder of that name, or the path; raises BadInput for a name that is neither."""
    path = Path(name).expanduser()
    if path.exists() or is_path(name):
        return path
    known = measured_names()
    if name in known:
        return FOLDER / name
    message = f"no such folder of measurements (got {name!r}), give a path or a shipped one: {', '.join(known)}"
    raise BadInput.of(f"{message}{nearest(name, known)}", key="--measured")
