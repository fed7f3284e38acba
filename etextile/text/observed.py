"""Observed wire states beside those of a run or of the paper's sites, as tables on the terminal."""

from __future__ import annotations

from collections.abc import Iterator

from etextile.text.columns import Columns
from wires.observed import FALSE_ALARM, HIT, MISSED, Comparison, ObservedPlace, Score
from wires.wording import probability


COLUMNS = ("place", "observed", "predicted", "strain", "P(broken)", "P(open)", "outcome")


def rows_of(places: tuple[ObservedPlace, ...]) -> list[tuple[str, ...]]:
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


def comparison(found: Comparison, title: str) -> Iterator[str | Columns]:
    """Yield the table of hits and misses and the scores."""
    if found.places:
        yield Columns(title, COLUMNS, rows_of(found.places))
    yield from sentences(found)
