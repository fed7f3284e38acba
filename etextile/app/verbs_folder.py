"""Verbs that take the output folder of a run: report."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from etextile import foreign_code
from etextile.app.options import Folder, Verbose, warn
from etextile.errors import BadInput
from wires.seal import SEAL


if TYPE_CHECKING:
    from wires.observed import Comparison


def report(
    folder: Folder,
    /,
    *,
    format_: Annotated[Literal["text", "json", "html"], Parameter(name="--format")] = "text",
    measured: Annotated[str | None, Parameter(show_default=False)] = None,
    pdf: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    verbose: Verbose = False,
) -> int:
    """Print the reliability report of a run again.

    Parameters
    ----------
    format_
        text for people, json for programs, html for the self-contained page.
    measured
        Folder with observed wire states (or the name of a shipped one): adds hits, misses and the Brier score.
    pdf
        Print the page to report.pdf with the Chromium or Chrome of this machine.
    """
    from etextile.studies.run.outcome import REPORT, as_written, existing

    if pdf:
        from etextile.studies.page import print_pdf

        print(print_pdf(existing(folder, "report.html"), folder / "report.pdf"))
        return 0
    if format_ == "html":
        if measured is not None:
            raise BadInput.of("the page is as the run wrote it, take --format text or json", key="--measured")
        sys.stdout.write(_page(folder))
        return 0
    observed = _observed(folder, measured)
    if observed is not None and not (folder / REPORT).is_file():
        return _print_alone(observed, as_json=format_ == "json")
    data, text = _report(folder)
    if format_ == "json" and observed is not None:
        text = json.dumps({**data, "observed": observed.as_dict()}, indent=1, ensure_ascii=False)
    if format_ == "json":
        sys.stdout.write(text if text.endswith("\n") else f"{text}\n")
        return 0
    from rich.console import Console

    from etextile.text.run import render

    with as_written(folder / REPORT):
        Console(markup=False, emoji=False).print(render(data, folder=folder))
    if observed is not None:
        _tell_observed(observed)
    return 0


def _tell_observed(observed: Comparison) -> None:
    from etextile.app.show import show
    from etextile.text.observed import comparison

    show(comparison(observed, "Observed wire states"))


def _report(folder: Path) -> tuple[dict[str, Any], str]:
    """Return the report of a folder and its JSON text, made again where the result file lies alone."""
    from etextile.results.layout import FILE_NAME
    from etextile.studies.run.outcome import REPORT, read_report

    if (folder / REPORT).is_file() or not (folder / FILE_NAME).is_file():
        data = read_report(folder)
        text = (folder / REPORT).read_text(encoding="utf-8")
        if SEAL not in json.loads(text):
            warn(f"{folder / REPORT} has no seal: whether it is as the run wrote it cannot be told")
        return data, text
    from etextile.studies.run.rebuilt import REMARK, rebuilt_report

    data = rebuilt_report(folder)
    warn(f"no {REPORT} in {folder}: it is {REMARK}, nothing is written")
    return data, json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False)


def _page(folder: Path) -> str:
    """Return the page of a folder, made again where the result file lies alone."""
    from etextile.results.layout import FILE_NAME
    from etextile.studies.run.outcome import existing

    if (folder / "report.html").is_file() or not (folder / FILE_NAME).is_file():
        return existing(folder, "report.html").read_text(encoding="utf-8")
    from etextile.studies.run.rebuilt import rebuilt_page

    return rebuilt_page(folder, _report(folder)[0])


def _print_alone(observed: Comparison, *, as_json: bool) -> int:
    """Print what a result file without a report predicts where wires were observed."""
    if as_json:
        print(json.dumps({"observed": observed.as_dict()}, indent=1, ensure_ascii=False))
        return 0
    _tell_observed(observed)
    return 0


def _observed(folder: Path, measured: str | None) -> Comparison | None:
    """Return what the run predicts where wires were observed."""
    if measured is None:
        return None
    from etextile.studies.run.observed import observed_in

    with foreign_code.never("report"):
        return observed_in(folder, measured)
