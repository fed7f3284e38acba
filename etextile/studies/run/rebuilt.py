"""The report of a run made again from its result file alone, which holds the case and all that was computed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from etextile import foreign_code
from etextile.errors import BadInput
from etextile.results.reader import Results, open_results
from etextile.studies.run.drawing import live_scenes
from etextile.studies.run.run import made_report
from etextile.studies.run.simulate import INTERRUPTED, simulated
from loadcases.judging import judge_for, marked_strain
from loadcases.reader import LoadedCase, stored_case
from loadcases.schema import Case


REMARK = "made again from the result file"
REMEDY = "run the case again (map and report --measured need the result file alone)"


def rebuilt_report(folder: Path) -> dict[str, Any]:
    """Return the report of the result file in a folder; nothing is written.

    What a run was told beside its case (a patch's remarks, a repeat on other lattices) is not in it. Raises BadInput
    for a run that may go on, and for a case that names files or code which are not here.
    """
    results = open_results(folder)
    if not results.completed and results.ending in ("", INTERRUPTED):
        raise BadInput.of("no report.json in it: the run did not end, go on with run --resume", file=str(folder))
    case = stored_case(results.case.effective, str(results.path))
    judge = judge_for(case)
    try:
        with foreign_code.never("report"):
            done = simulated(results, case)
    except BadInput as error:
        why = error.problems[0].message
        message = f"no report.json in it, its result file came alone, and it needs more than that ({why}): {REMEDY}"
        raise BadInput.of(message, file=str(folder)) from error
    return made_report(
        _loaded(results, case), done, judge, damage=judge.verdict(results.wires), remarks=(f"this report was {REMARK}",)
    )


def rebuilt_page(folder: Path, report: dict[str, Any]) -> str:
    """Return the page of a report that was made again, with the maps that lie in the folder."""
    from viz.html import render_report_html

    results = open_results(folder)
    case = stored_case(results.case.effective, str(results.path))
    judge = judge_for(case)
    live = live_scenes(
        results, report, damage=judge.verdict(results.wires), onset=marked_strain(case, judge), title=case.title
    )
    return render_report_html(report, maps=tuple(sorted((folder / "maps").glob("*.png"))), live=live)


def _loaded(results: Results, case: Case) -> LoadedCase:
    """Return the case of a result file under the name of the file it was read from."""
    source = Path(results.case.source) if results.case.source else None
    return LoadedCase(case, results.case.text, results.case.sha256, source, results.case.overrides)
