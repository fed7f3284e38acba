"""The page of an output folder: where it is, opened in a browser, or printed to PDF by one."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import webbrowser
from pathlib import Path

from etextile.errors import BadInput, EtextileError


PAGES = ("report.html", "ensemble.html", "compare.html", "life.html", "sizing.html")
"""Names of pages in output folders, in the order in which they are looked for."""
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
TIMEOUT_S = 120


def page_of(folder: Path) -> Path:
    """Return the page of an output folder, or the page itself; raises BadInput that says what there is."""
    if folder.is_file() and folder.suffix == ".html":
        return folder
    found = next((folder / name for name in PAGES if (folder / name).is_file()), None)
    if found is None:
        what = "there is no page in it" if folder.is_dir() else "no such folder"
        raise BadInput.of(f"{what}, give the output folder of a run, a diagnosis or an ensemble", file=str(folder))
    return found


def open_page(page: Path) -> bool:
    """Open a page in the user's browser; return False where there is none to open it in (no display)."""
    windows = sys.platform in ("win32", "darwin") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    return bool(windows) and webbrowser.open(page.resolve().as_uri())


def print_pdf(page: Path, output: Path) -> Path:
    """Print a page to a PDF with a headless browser; raises EtextileError with what to install or do by hand."""
    browser = next((place for name in BROWSERS if (place := shutil.which(name))), None)
    if browser is None:
        raise EtextileError(
            f"no Chromium or Chrome found to print with: install one (Debian: apt install chromium), or open {page} in "
            "any browser and print it to a file"
        )
    with tempfile.TemporaryDirectory() as profile:
        command = [
            browser, "--headless", "--disable-gpu", "--no-pdf-header-footer", f"--user-data-dir={profile}",
            f"--print-to-pdf={output.resolve()}", page.resolve().as_uri(),
        ]  # fmt: skip
        if hasattr(os, "geteuid") and os.geteuid() == 0:
            command.insert(1, "--no-sandbox")  # Chromium refuses root otherwise; the page is ours
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, check=False)
        except subprocess.TimeoutExpired:
            raise EtextileError(f"{browser} did not print {page} within {TIMEOUT_S} s: print it by hand") from None
    if done.returncode or not output.is_file():
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise EtextileError(f"{browser} could not print {page}: {last}")
    return output
