"""The verb that opens the page of an output folder."""

from __future__ import annotations

from pathlib import Path

from etextile.app.options import Folder


def show(folder: Folder, /) -> int:
    """Open the page of an output folder in the browser, or say where it is."""
    from etextile.studies.page import page_of

    tell_page(page_of(folder))
    return 0


def tell_page(page: Path) -> None:
    """Open a page and say so, or say where it lies."""
    from etextile.studies.page import open_page

    print(f"opened {page}" if open_page(page) else f"the page is {page.resolve()}")
