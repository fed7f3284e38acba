"""Whether the packages `wires`, `loadcases` and `viz` that Python finds are ours.

Other distributions use these names too. Installed into one environment they hide our files or overwrite them, and what
then fails says nothing of the cause. So the command and `import etextile` look where the three packages lie before they
use them, and `etextile check` looks through what is installed for other owners of the names.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from importlib.util import find_spec
from pathlib import Path

from etextile.errors import BadInput


OURS = "etextile"
FIRST_LINES = {
    "wires": '"""Conductive wires: layout, embedding in the lattice, histories, failure and reports."""',
    "loadcases": '"""Load cases: schema, strict reader, build, and the shipped cases."""',
    "viz": '"""Pictures: scenes, maps, plots and pages."""',
}
"""Top-level package beside `etextile`, and all that its `__init__.py` holds."""


def find_foreign(root: Path | None = None) -> dict[str, str]:
    """Return the packages that are not ours, each with the file that Python finds in place of it.

    `root`: folder that holds the package `etextile`.
    """
    root = root or Path(__file__).resolve().parents[1]
    found = {}
    for name, line in FIRST_LINES.items():
        spec = find_spec(name)
        place = Path(spec.origin) if spec is not None and spec.origin else None
        ours = root / name / "__init__.py"
        if (
            place is None
            or place.resolve() != ours
            or ours.read_text(encoding="utf-8", errors="replace").strip() != line
        ):
            found[name] = str(place or "nothing")
    return found


def other_owners(folders: Iterable[str] | None = None) -> dict[str, list[str]]:
    """Return the names of other distributions that install files into our packages, by package.

    `folders`: where to look for installed distributions, `sys.path` by default. Their lists of files are searched as
    they are: `importlib.metadata` takes ten times longer to read them.
    """
    pattern = re.compile(rb"^(" + "|".join(FIRST_LINES).encode() + rb")/", re.MULTILINE)
    found: dict[str, list[str]] = {}
    for folder in sys.path if folders is None else folders:
        for listing in Path(folder or ".").glob("*.dist-info/RECORD"):
            name = listing.parent.name.split("-")[0]
            if name != OURS:
                for package in sorted(set(pattern.findall(listing.read_bytes()))):
                    found.setdefault(package.decode(), []).append(name)
    return found


def require_own_packages() -> None:
    """Raise BadInput when one of the packages is not ours, naming who brought it and what to do."""
    foreign = find_foreign()
    if foreign:
        raise BadInput.of(message(foreign, other_owners()))


def message(foreign: dict[str, str], owners: dict[str, list[str]]) -> str:
    """Return what is in the way, whose it is and the remedy."""
    parts = []
    for name, place in foreign.items():
        who = f", of the distribution {' and '.join(owners[name])}" if name in owners else ""
        parts.append(f"package {name!r} is not that of etextile (Python finds {place}{who})")
    others = sorted({name for names in owners.values() for name in names})
    remedy = f"pip uninstall {' '.join(others)} && " if others else "take the other one away, then "
    again = "pip install --force-reinstall --no-deps etextile, or use an environment of its own"
    return f"{'; '.join(parts)}; {remedy}{again}"


def shared_with() -> str | None:
    """Return what to say when another distribution shares our package names although nothing is hidden yet."""
    owners = other_owners()
    if not owners:
        return None
    shared = ", ".join(f"{name!r} ({' and '.join(names)})" for name, names in owners.items())
    return (
        f"other distributions install into packages of etextile: {shared}; use an environment of its own for etextile"
    )
