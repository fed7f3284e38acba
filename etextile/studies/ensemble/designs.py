"""Two designs on the same random numbers: which loses fewer wires, by how much, and how sure that is.

Sample k of both designs has the same fabric, strength, mounting and places, so that what they share cancels in the
difference and few samples tell designs apart.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from etextile.ensemble.sample import Method
from etextile.ensemble.statistics import Probability, bounds, difference, mean_difference
from etextile.ensemble.store import DONE, Sample
from etextile.errors import BadInput
from etextile.files import one_writer, write_whole
from etextile.studies.cases import AnyCase, loaded_case
from etextile.studies.ensemble.differs import differences
from etextile.studies.ensemble.plan import Ensemble
from etextile.studies.ensemble.report import specimen_bounds, travel_of
from etextile.studies.ensemble.run import EnsembleOutcome, Watcher, conclude, prepare, run_missing
from etextile.studies.ensemble.specimen import nominal
from etextile.types import Array
from loadcases.build import Built
from wires.layout import WireLayout
from wires.report_files import plain
from wires.trust import withheld


VERSION = 1
NAMES = ("A", "B")
EVENTS = {
    "any_failure": difference,
    "any_open": difference,
    "share_failed": mean_difference,
    "share_open": mean_difference,
}
"""What is compared, and how its difference gets an interval."""
DECIDING = "share_failed"
"""What the verdict goes by: the share of wires that lost a filament, which also tells designs of few wires apart."""


@dataclass(frozen=True)
class Design:
    """One of the two: its ensemble, samples, wires, and the outcome written into its own folder."""

    ensemble: Ensemble
    samples: Sequence[Sample]
    built: Built
    layout: WireLayout
    outcome: EnsembleOutcome


@one_writer("folder")
def compare_designs(
    first: AnyCase,
    second: AnyCase,
    folder: str | Path,
    *,
    samples: int = 128,
    seed: int = 0,
    method: Method = "sobol",
    jobs: int | None = None,
    scheduler: str | None = None,
    force: bool = False,
    watch: Watcher | None = None,
) -> EnsembleOutcome:
    """Run both designs on the same random numbers and write compare.json, plots and both ensembles into `folder`.

    Exit codes as of `ensemble`, the worse of the two. Raises BadInput for designs that cannot be compared.
    """
    place = Path(folder)
    pair = [
        prepare(loaded_case(case), place / name, samples=samples, seed=seed, method=method, force=force)
        for name, case in zip(NAMES, (first, second), strict=True)
    ]
    _check(pair[0], pair[1])
    found = run_missing(pair, jobs=jobs, scheduler=scheduler, watch=watch)
    designs = [_design(ensemble, own) for ensemble, own in zip(pair, found, strict=True)]
    data = comparison(designs[0], designs[1])
    write_whole(place / "compare.json", json.dumps(data, indent=1, allow_nan=False) + "\n")
    from etextile.studies.ensemble.drawing import chances, draw_comparison

    drawn = [
        chances(design.outcome.data, design.built, place / name, name)
        for name, design in zip(NAMES, designs, strict=True)
    ]
    draw_comparison(data, place, designs=drawn)
    code = max(design.outcome.exit_code for design in designs)
    return EnsembleOutcome(code, place, data)


def _check(first: Ensemble, second: Ensemble) -> None:
    """Raise BadInput for designs that are the same or move differently."""
    if first.key == second.key:
        raise BadInput.of("A and B are the same case, change one of them (--set-b wires.loops.slack='4 %')")
    motions = [(item.case.motion.reach, item.case.motion.path) for item in (first, second)]
    units = [item.case.motion.unit for item in (first, second)]
    key = "flexion" if units[0] == "deg" else "total"
    if motions[0] != motions[1] or units[0] != units[1]:
        raise BadInput.of(
            f"A and B move differently (got {motions[0][0]:g} {units[0]} and {motions[1][0]:g} {units[1]}), give both "
            f"the same motion (--set motion.{key}='30 {units[0]}' is for both)",
            key=f"motion.{key}",
        )


def _design(ensemble: Ensemble, samples: Sequence[Sample]) -> Design:
    built = nominal(ensemble.case_text).built
    if built.wires is None:
        raise BadInput.of("there are no wires", key="wires")
    return Design(ensemble, samples, built, built.wires.layout, conclude(ensemble, samples))


def comparison(first: Design, second: Design) -> dict[str, Any]:
    """Return the comparison in JSON types; differences are B less A, negative where B is better."""
    travel, of_specimen = _specimen(first, second)
    events = {name: method(*of_specimen[name]) for name, method in EVENTS.items()}
    deciding = tuple(0.5 * (low + high)[:, -1] for low, high in of_specimen[DECIDING])
    data = {
        "compare_version": VERSION,
        "designs": {
            name: {
                "title": design.ensemble.case.title,
                "case": design.ensemble.name,
                "sha256": design.ensemble.key.sha256,
                "failed_runs": sum(sample.status != DONE for sample in design.samples),
                "specimen": design.outcome.data["specimen"],
            }
            for name, design in zip(NAMES, (first, second), strict=True)
        },
        "differs": differences(first.ensemble.case, second.ensemble.case),
        "unit": first.ensemble.case.motion.unit,
        "samples": len(first.samples),
        "seed": first.ensemble.key.seed,
        "method": first.ensemble.key.method,
        "difference": {name: _last(events[name]) for name in EVENTS},
        "first_failure_mm": _first_failure(first, second),
        "better": _better(events[DECIDING]),
        "better_in": {"A": float(np.mean(deciding[0] < deciding[1])), "B": float(np.mean(deciding[1] < deciding[0]))},
        "wires": _wires(first, second),
        "over_displacement": {
            "travel_mm": travel,
            **{name: {"value": item.value, "low": item.low, "high": item.high} for name, item in events.items()},
        },
        "notes": _notes(first, second),
    }
    cleaned: dict[str, Any] = plain(data)
    instead = withheld(
        [
            f"{name}: {said}"
            for name, design in zip(NAMES, (first, second), strict=True)
            for said in design.outcome.data["trust"]["exceeded"]
        ]
    )
    return {**cleaned, "verdict": {"withheld": bool(instead), "sentence": instead or sentence(cleaned)}}


def _specimen(first: Design, second: Design) -> tuple[Array, dict[str, list[tuple[Array, Array]]]]:
    """Return the steps (S,) of A and, per event, the bounds (N, S) of both designs at these."""
    travel = travel_of(first.samples[0].displacement_mm)
    result: dict[str, list[tuple[Array, Array]]] = {name: [] for name in EVENTS}
    for design in (first, second):
        own = travel_of(design.samples[0].displacement_mm)
        for name, pair in specimen_bounds(design.samples, design.layout.wire_copies).items():
            low, high = (_at(values, own, travel) for values in pair)
            result[name].append((low, high))
    return travel, result


def _at(values: Array, own: Array, wanted: Array) -> Array:
    """Return curves (N, S) at other places, linear between their own."""
    return np.stack([np.interp(wanted, own, curve) for curve in values])


def _last(curve: Probability) -> dict[str, float]:
    return {"value": float(curve.value[-1]), "low": float(curve.low[-1]), "high": float(curve.high[-1])}


def _better(curve: Probability) -> str:
    """Return A, B, or undecided when the interval holds zero."""
    if curve.low[-1] > 0.0:
        return "A"
    return "B" if curve.high[-1] < 0.0 else "undecided"


def _first_failure(first: Design, second: Design) -> dict[str, Any]:
    """Return the mean gain in displacement up to the first break, B less A; a wire that holds counts with the end.

    Only pairs of runs that ended are used.
    """
    end = float(travel_of(first.samples[0].displacement_mm)[-1])
    pairs = [
        tuple(end if sample.first_failure_mm is None else sample.first_failure_mm for sample in pair)
        for pair in zip(first.samples, second.samples, strict=True)
        if all(sample.status == DONE for sample in pair)
    ]
    if len(pairs) < 2:
        return {"value": None, "low": None, "high": None, "pairs": len(pairs)}
    ends = [np.array(column) for column in zip(*pairs, strict=True)]
    gain = mean_difference((ends[0], ends[0]), (ends[1], ends[1]))
    return {"value": gain.value, "low": gain.low, "high": gain.high, "pairs": len(pairs)}


def _wires(first: Design, second: Design) -> list[dict[str, Any]]:
    """Return the wires of A with the same of B, and the difference."""
    ends = [bounds(np.stack([sample.wire_failure for sample in item.samples])) for item in (first, second)]
    places = first.layout.weft_mm, second.layout.weft_mm
    rows = []
    for wire, other in _partners(first.layout, second.layout):
        columns = [tuple(part[:, -1, k] for part in end) for end, k in zip(ends, (wire, other), strict=True)]
        found = difference((columns[0][0], columns[0][1]), (columns[1][0], columns[1][1]))
        means = [0.5 * (low + high).mean() for low, high in columns]
        rows.append(
            {"A": wire, "B": other, "names": [first.layout.names[wire], second.layout.names[other]],
             "weft_mm": [places[0][wire], places[1][other]], "failure_probability": means,
             "difference": found.value, "low": found.low, "high": found.high}
        )  # fmt: skip
    return rows


def _partners(first: WireLayout, second: WireLayout) -> list[tuple[int, int]]:
    """Return the wires of A and B that are the same: of one name where drawings name them, else the nearest.

    Near: within half of the smallest distance between wires.
    """
    if any(name != str(number) for layout in (first, second) for number, name in enumerate(layout.names)):
        there = {name: number for number, name in enumerate(second.names)}
        return [(number, there[name]) for number, name in enumerate(first.names) if name in there]
    if not first.n_wires or not second.n_wires:
        return []
    spacing = min(float(np.min(np.diff(layout.weft_mm), initial=np.inf)) for layout in (first, second))
    nearest = [int(np.argmin(np.abs(second.weft_mm - place))) for place in first.weft_mm]
    return [
        (wire, other) for wire, other in enumerate(nearest)
        if abs(second.weft_mm[other] - first.weft_mm[wire]) <= 0.5 * spacing
    ]  # fmt: skip


def _notes(first: Design, second: Design) -> list[str]:
    """Say what makes the comparison less than like with like."""
    own = [tuple(design.outcome.data["notes"]) for design in (first, second)]
    notes = [note for note in own[0] if note in own[1]]
    for name, its in zip(NAMES, own, strict=True):
        notes += [f"{name}: {note}" for note in its if note not in notes]
    inputs = [{item.name for item in design.ensemble.plan.inputs} for design in (first, second)]
    if inputs[0] != inputs[1]:
        notes.append(f"not the same scatters in both: {', '.join(sorted(inputs[0] ^ inputs[1]))} only in one")
    if all(np.array_equal(a.wire_failure, b.wire_failure) for a, b in zip(first.samples, second.samples, strict=True)):
        criterion = first.ensemble.case.failure.criterion
        notes.append(f"no sample differs: what sets the designs apart does not count for the criterion {criterion}")
    return notes


def sentence(data: Mapping[str, Any]) -> str:
    """Say which design is better, by how much and how sure."""
    found = data["difference"][DECIDING]
    size, low, high = (100 * found[name] for name in ("value", "low", "high"))
    if data["better"] == "undecided":
        return (
            f"Undecided: the share of wires that lose a filament differs by {size:+.1f} points from A to B, "
            f"anything from {low:+.1f} to {high:+.1f} is possible (95 %). More samples narrow it."
        )
    better = data["better"]
    least, most = map(_points, sorted((abs(low), abs(high))))
    return (
        f"{better} is better: {_points(abs(size))} points fewer of its wires lose a filament "
        f"(95 %: {least} to {most}), in "
        f"{100 * data['better_in'][better]:.0f} % of the pairs.{_gain(data)}"
    )


def _points(value: float) -> str:
    """Return a share in points: a decimal, more where a decimal would say nothing."""
    return f"{value:.1f}" if value >= 0.1 else f"{value:.2g}"


def _gain(data: Mapping[str, Any]) -> str:
    """Say how much later the first filament breaks in the better design, where that is sure."""
    gain = data["first_failure_mm"]
    sign = 1.0 if data["better"] == "B" else -1.0
    if gain["value"] is None or min(sign * gain["low"], sign * gain["high"]) <= 0.0:
        return ""
    low, high = sorted((sign * gain["low"], sign * gain["high"]))
    unit = data.get("unit", "mm").replace("**", "")
    return f" Its first filament breaks {sign * gain['value']:.1f} {unit} later (95 %: {low:.1f} to {high:.1f})."
