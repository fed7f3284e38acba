"""Where the manual lies, and how its pages are built from it.

The pages are built from a copy of this folder (the stage), so that an installed package stays as it is: the gallery
writes what its scripts draw beside them, and texts that live elsewhere in the repository (scores, benchmarks, pictures)
are laid into the copy instead of being kept twice. `make manual` builds into `html` here; a wheel built afterwards
carries the pages.
"""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

from etextile.errors import EtextileError


SOURCES = Path(__file__).parent
PAGES = SOURCES / "html"
ROOT = SOURCES.parents[1]
ELSEWHERE = {
    "validation/scores.md": "tests/workflow/SCORES.md",
    "validation/benchmarks.md": "tests/benchmarks/README.md",
    "validation/nylon.md": "loadcases/data/nylon_woven/README.md",
    "validation/hidden_clamp.md": "loadcases/data/hidden_clamp/README.md",
}
"""Page of the manual: file of the repository that it shows."""

LOADED = re.compile(r"<(?:script|img|iframe|link)\b[^>]*?\b(?:src|href)=\"(?:https?:)?//[^\"]*\"[^>]*>")
REMEDY = "the manual is built with Sphinx: pip install 'etextile[manual]'"


def first_page() -> Path | None:
    """Return the first page of the built manual, None while it is not built."""
    page = PAGES / "index.html"
    return page if page.is_file() else None


def build(output: Path, *, stage: Path) -> Path:
    """Build the pages from the copy `stage` into `output` and return the first one.

    Raises EtextileError without Sphinx, and when a page has a warning or loads something from the network.
    """
    try:
        from sphinx.cmd.build import build_main
    except ImportError as error:
        raise EtextileError(REMEDY) from error
    fill(stage)
    arguments = ["-b", "html", "-W", "--keep-going", "-q", "-j", "auto", "-d", str(stage.parent / "doctrees")]
    if build_main([*arguments, str(stage), str(output)]) != 0:
        raise EtextileError("the manual has warnings, which count as errors: see above")
    if found := sorted(from_the_network(output)):
        raise EtextileError("pages load from the network:\n" + "\n".join(found))
    return output / "index.html"


def fill(stage: Path) -> None:
    """Lay the pages and all that they show into the folder `stage`; what a page no longer needs goes."""
    if stage.exists():
        for path in stage.rglob("*.md"):
            path.unlink()
    skipped = shutil.ignore_patterns("html", "gallery", "__pycache__")
    shutil.copytree(SOURCES, stage, ignore=skipped, dirs_exist_ok=True)
    shutil.rmtree(stage / "scripts", ignore_errors=True)
    shutil.copytree(SOURCES / "gallery", stage / "scripts", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(ROOT / "viz" / "pictures", stage / "pictures", dirs_exist_ok=True)
    for page, home in ELSEWHERE.items():
        (stage / page).write_text(elsewhere(home), encoding="utf-8")
    for index in stage.glob("*/index.md"):
        index.write_text(without_idle_glob(index), encoding="utf-8")


def without_idle_glob(index: Path) -> str:
    """Return the text of a section's index without the line `*` where every page is listed: Sphinx would complain."""
    lines = index.read_text(encoding="utf-8").splitlines()
    pages = {path.stem for path in index.parent.glob("*.md")} - {"index"}
    idle = bool(pages) and pages <= set(lines)
    return "\n".join(line for line in lines if not (idle and line == "*")) + "\n"


def elsewhere(home: str) -> str:
    """Return the text of a file of the repository, or where it stands for an installation that lacks it."""
    path = ROOT / home
    if path.is_file():
        return path.read_text(encoding="utf-8")
    return f"# {Path(home).parent.name}\n\nThis page shows `{home}` of the repository, which this installation lacks.\n"


def from_the_network(pages: Path) -> Iterator[str]:
    """Yield what built pages load from an address: a manual is read from disk, without a network."""
    for path in pages.rglob("*.html"):
        for tag in LOADED.findall(path.read_text(encoding="utf-8")):
            if 'rel="canonical"' not in tag:
                yield f"{path.relative_to(pages)}: {tag}"
