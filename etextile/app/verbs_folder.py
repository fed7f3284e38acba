"""Verbs that take the output folder of a run: report."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from etextile.app.options import Folder, Verbose
from etextile.errors import BadInput


if TYPE_CHECKING:
    from wires.observed import Comparison


def report(
    folder: Folder,
    /,
    *,
    format_: Annotated[Literal["text", "json", "html"], Parameter(name="--format")] = "text",
    measured: Annotated[str | None, Parameter(show_default=False)] = None,
    verbose: Verbose = False,
) -> int:
    """Print the reliability report of a run again.

    Parameters
    ----------
    format_
        text for people, json for programs, html for the self-contained page.
    measured
        Folder with observed wire states (or the name of a shipped one): adds hits, misses and the Brier score.
    """
    if format_ == "html":
        if measured is not None:
            raise BadInput.of("the page is as the run wrote it, take --format text or json", key="--measured")
        sys.stdout.write(_existing(folder, "report.html").read_text(encoding="utf-8"))
        return 0
    path = _existing(folder, "report.json")
    text = path.read_text(encoding="utf-8")
    data = _parsed(text, path)
    observed = _observed(folder, measured)
    if format_ == "json" and observed is not None:
        text = json.dumps({**data, "observed": observed.as_dict()}, indent=1, ensure_ascii=False)
    if format_ == "json":
        sys.stdout.write(text if text.endswith("\n") else f"{text}\n")
        return 0
    from rich.console import Console

    from etextile.app.text.run import print_report

    print_report(data, Console(), folder=folder)
    if observed is not None:
        from etextile.studies.run.observed import print_comparison

        print_comparison(observed, "Observed wire states")
    return 0


def _observed(folder: Path, measured: str | None) -> Comparison | None:
    """Return what the run predicts where wires were observed."""
    if measured is None:
        return None
    from etextile.studies.run.observed import observed_in

    return observed_in(folder, measured)


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
