"""Which pictures of a gallery script the manual shows: the PNG files that it leaves beside itself, in that order."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

from sphinx_gallery.scrapers import figure_rst


def scrape(block: object, variables: dict[str, Any], configuration: dict[str, Any]) -> str:
    """Move what the script has drawn to where sphinx-gallery keeps pictures, and return the lines that show it."""
    folder = Path(variables["src_file"]).parent
    shown = []
    for path in sorted(folder.glob("*.png"), key=lambda path: path.stat().st_mtime_ns):
        target = Path(next(variables["image_path_iterator"]))
        shutil.move(path, target)
        shown.append(str(target))
    return str(figure_rst(shown, configuration["src_dir"]))


def prepare(configuration: dict[str, Any], script: str) -> None:
    """Give every script matplotlib as it comes, drawing without a screen, at the size of a page."""
    import matplotlib.pyplot as plt

    plt.close("all")
    plt.rcdefaults()
    plt.switch_backend("agg")
    plt.rcParams.update({"figure.figsize": (6.4, 4.0), "savefig.dpi": 130, "savefig.bbox": "tight"})
