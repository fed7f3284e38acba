"""Observed wire states beside those of a run."""

from __future__ import annotations

from pathlib import Path

from etextile.errors import BadInput
from etextile.results.reader import open_results
from loadcases.judging import judge_for
from loadcases.measurements import load_measurements
from loadcases.reader import stored_case
from loadcases.shipped import measured_folder
from wires.observed import Comparison, compare_states


def observed_in(folder: Path, measured: str) -> Comparison:
    """Return what a run predicts where wires were observed.

    `measured`: a folder, its yaml file, or the name of a shipped one.
    Raises BadInput for a run without wires and for measurements without the channel `wires`.
    """
    found = load_measurements(measured_folder(measured))
    if found.wires is None:
        raise BadInput.of("no channel `wires` in it, there are no states to compare", file=found.folder)
    results = open_results(folder)
    if results.wires is None:
        raise BadInput.of("the case has no wires", file=str(folder))
    case = stored_case(results.case.effective, str(results.path))
    return compare_states(results.wires, found.wires, judge_for(case))
