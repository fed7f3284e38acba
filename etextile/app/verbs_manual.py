"""Verb about the manual: where it lies, and building its pages."""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

from cyclopts import Parameter


HOW_TO_BUILD = """These are its sources. Pages for the browser (minutes: its commands and its gallery are run):

  pip install 'etextile[manual]'
  etextile manual --build FOLDER"""


def manual(
    *,
    build: Annotated[Path | None, Parameter(show_default=False)] = None,
    keep: Annotated[Path | None, Parameter(show_default=False)] = None,
) -> int:
    """Say where the manual lies, or build its pages.

    Parameters
    ----------
    build
        Build the pages into this folder.
    keep
        Keep what the build needs in this folder, so that the next build does only what changed.
    """
    from etextile.manual import build as code

    if build is not None:
        with TemporaryDirectory(prefix="etextile-manual-") as scratch:
            print(code.build(build, stage=(keep or Path(scratch)) / "stage"))
        return 0
    page = code.first_page()
    print(page or code.SOURCES / "index.md")
    if page is None:
        print(HOW_TO_BUILD, file=sys.stderr)
    return 0
