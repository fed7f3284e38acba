"""Verbs that take the output folder of a run: report."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from etextile.app.options import Folder, Verbose
from etextile.errors import BadInput


def report(
    folder: Folder,
    /,
    *,
    format_: Annotated[Literal["text", "json", "html"], Parameter(name="--format")] = "text",
    verbose: Verbose = False,
) -> int:
    """Print the reliability report of a run again.

    Parameters
    ----------
    format_
        text for people, json for programs, html for the self-contained page.
    """
    if format_ == "html":
        sys.stdout.write(_existing(folder, "report.html").read_text(encoding="utf-8"))
        return 0
    path = _existing(folder, "report.json")
    text = path.read_text(encoding="utf-8")
    data = _parsed(text, path)
    if format_ == "json":
        sys.stdout.write(text if text.endswith("\n") else f"{text}\n")
        return 0
    from rich.console import Console

    from etextile.app.text import print_report

    print_report(data, Console(), folder=folder)
    return 0


def _existing(folder: Path, name: str) -> Path:
    """Return a file of an output folder; raises BadInput that says what is missing and what to do."""
    path = folder / name
    if path.is_file():
        return path
    if not folder.is_dir():
        what = "this is a file" if folder.is_file() else "no such folder"
        raise BadInput.of(f"{what}, give the output folder of a run", file=str(folder))
    if (folder / "results.vtkhdf").is_file():
        raise BadInput.of(f"no {name} in it: the run did not end, go on with run --resume", file=str(folder))
    raise BadInput.of(f"no {name} in it: not the output folder of a run", file=str(folder))


def _parsed(text: str, path: Path) -> Any:
    """Return the parsed report; raises BadInput when it is damaged."""
    try:
        return json.loads(text)
    except ValueError as error:
        raise BadInput.of(f"not a report, the file is damaged ({error}), run the case again", file=str(path)) from error
