"""Observed wire states beside those of a run or of the paper's sites, as tables on the terminal."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from etextile.errors import BadInput
from etextile.results.reader import open_results
from etextile.studies.run.run import judged_by, wire_history
from loadcases.measurements import load_measurements
from loadcases.reader import read_case
from loadcases.shipped import measured_folder
from wires.failure import CRITERIA
from wires.observed import FALSE_ALARM, HIT, MISSED, Comparison, Place, Score, compare_states
from wires.wording import probability


COLUMNS = ("place", "observed", "predicted", "strain", "P(broken)", "P(open)", "outcome")


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
    case = read_case(results.case.effective, file=str(results.path)).case
    criterion = case.failure.criterion
    parameters = judged_by(case)
    known = {parameter.name for parameter in CRITERIA[criterion].parameters}
    used = {name: value for name, value in parameters.items() if name in known}
    return compare_states(wire_history(results.wires), found.wires, criterion=criterion, parameters=used)


def rows_of(places: tuple[Place, ...]) -> list[tuple[str, ...]]:
    """Return the places as rows of COLUMNS."""
    return [
        (
            place.name,
            place.observed,
            place.predicted,
            f"{100 * place.strain:.1f} %",
            probability(place.failure_probability),
            probability(place.open_probability),
            place.outcome,
        )
        for place in places
    ]


def sentences(found: Comparison) -> Iterator[str]:
    """Yield hits, misses and scores in words."""
    if not found.places:
        yield "No place could be compared."
    else:
        yield (
            f"{found.count(HIT)} of {len(found.places)} places agree on whether a filament is broken, "
            f"{found.count(FALSE_ALARM)} false alarms, {found.count(MISSED)} missed breaks; "
            f"{found.same_state} agree in state."
        )
        yield from _score("a filament is broken", found.broken)
        yield from _score("the wire is interrupted", found.opened)
    for sentence in found.left_out:
        yield f"left out: {sentence}"


def _score(event: str, score: Score | None) -> Iterator[str]:
    if score is not None:
        yield (
            f"Brier score of `{event}`: {score.brier:.3f} "
            f"(0 is perfect, always giving the observed share scores {score.base_rate:.3f})."
        )


def print_comparison(found: Comparison, title: str) -> None:
    """Print the table of hits and misses and the scores."""
    from etextile.app.tables import print_table

    if found.places:
        print_table(title, COLUMNS, rows_of(found.places))
    print("\n".join(sentences(found)))
