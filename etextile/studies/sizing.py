"""Slack for the loops of a case: simulate once, size every loop, write the table; on request simulate again with it."""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from etextile.errors import BadInput
from etextile.results.layout import FILE_NAME
from etextile.results.reader import open_results
from etextile.studies.cases import AnyCase, loaded_case
from etextile.studies.run.judged import judged_by, wire_history
from etextile.studies.run.run import check
from etextile.studies.run.simulate import Simulation, Watcher, simulate
from loadcases.reader import LoadedCase, as_loaded
from loadcases.schema import Case
from wires.failure import CRITERIA, evaluate
from wires.history import WireHistory
from wires.report import plain
from wires.sizing import LoopSizes
from wires.sizing import size_loops as sizes_of


STEP = 0.005
"""The slack for all loops is rounded up to this."""
COLUMNS = (
    "wire", "loop", "weft_mm", "warp_mm", "span_strain", "slack_now", "probability_now", "slack", "probability",
    "length_mm",
)  # fmt: skip


@dataclass(frozen=True)
class Sized:
    """What sizing leaves: exit code, the data of loop_sizes.json, its folder."""

    exit_code: int
    data: dict[str, Any]
    folder: Path


def size_loops(
    case: AnyCase,
    folder: str | Path,
    *,
    target: float = 0.01,
    verify: bool = False,
    force: bool = False,
    watch: Watcher | None = None,
) -> Sized:
    """Find the slack that keeps every loop's failure probability under `target`; write loop_sizes.json and .csv.

    The case is simulated, or its results in `folder` are read. `verify`: simulate it once more with the slack found.
    Raises BadInput for a case without loops and for a target that is no probability.
    """
    loaded = loaded_case(case)
    with loaded.locating():
        sized = _size(loaded, Path(folder), target=target, force=force, watch=watch)
    return verify_sizes(loaded, sized, watch=watch) if verify else sized


def _size(loaded: LoadedCase, folder: Path, *, target: float, force: bool, watch: Watcher | None) -> Sized:
    """Do what `size_loops` says, without verifying."""
    case = loaded.case
    criterion, parameters = _criterion(case)
    done = _simulated(loaded, folder, force=force, watch=watch)
    history = _history(done)
    sizes = sizes_of(history, target, criterion=criterion, parameters=parameters)
    limits = [item.sentence for item in check(done, case) if not item.ok]
    ok = not limits and not done.trouble
    rows = _rows(history, sizes)
    data: dict[str, Any] = {
        "title": case.title,
        "target": target,
        "criterion": criterion,
        "slack_for_all": _rounded(sizes),
        "loops": rows,
        "notes": _notes(case, done, limits),
        "verified": None,
    }
    data = _written(data, folder)
    _write_csv(rows, folder / "loop_sizes.csv")
    return Sized(3 if done.trouble else 0 if ok else 4, data, folder)


def _criterion(case: Case) -> tuple[str, dict[str, float]]:
    """Return the criterion to size by: the case's own, but the wire strain in place of the paper's span strain."""
    name = case.failure.criterion
    if name == "span_strain":
        name = "wire_strain"
        case = case.model_copy(update={"failure": case.failure.model_copy(update={"criterion": name})})
    values = judged_by(case)
    known = {parameter.name for parameter in CRITERIA[name].parameters}
    return name, {key: value for key, value in values.items() if key in known}


def _simulated(loaded: LoadedCase, folder: Path, *, force: bool, watch: Watcher | None) -> Simulation:
    """Return the simulation of the case, gone on with where the folder has some of it."""
    path = folder / FILE_NAME
    resume = path.exists() and not force and open_results(path).case.sha256 == loaded.sha256
    return simulate(loaded, folder, resume=resume, force=force, seed=0, watch=watch)


def _history(done: Simulation) -> WireHistory:
    if done.results.wires is None or done.results.steps == 0:
        raise BadInput.of(f"no increment converged, there is nothing to size: {done.trouble}")
    return wire_history(done.results.wires)


def _rounded(sizes: LoopSizes) -> float:
    """Return the slack that serves all loops, rounded up."""
    return float(np.ceil(sizes.everywhere / STEP - 1e-9) * STEP)


def _rows(history: WireHistory, sizes: LoopSizes) -> list[dict[str, Any]]:
    layout = history.layout
    columns = (
        layout.loop_wire, layout.loop_index, layout.loop_weft_mm, layout.loop_warp_mm, history.max_span_strain,
        layout.loop_slack, sizes.probability_now, sizes.slack, sizes.probability,
        layout.loop_span_mm * (1.0 + sizes.slack),
    )  # fmt: skip
    return [dict(zip(COLUMNS, row, strict=True)) for row in zip(*columns, strict=True)]


def _notes(case: Case, done: Simulation, limits: list[str]) -> list[str]:
    """Return what a reader must know: sliding, broken-off runs, exceeded limits."""
    notes = [done.trouble] if done.trouble else []
    notes += [f"provisional: {sentence}" for sentence in limits]
    if case.wires is not None and case.wires.bond != "perfect":
        notes.append("the wires slide, so the weave beside a loop shares its slack: check the sizes with --verify")
    return notes


def verify_sizes(loaded: LoadedCase, sized: Sized, *, watch: Watcher | None = None) -> Sized:
    """Simulate the case again with the slack found for all loops and add the greatest failure probability of a loop.

    Nothing is done where no slack is enough. The second simulation is kept in the folder `verify`.
    """
    case, slack = loaded.case, sized.data["slack_for_all"]
    if case.wires is None or case.wires.loops is None or slack is None:
        return sized
    criterion, parameters = _criterion(case)
    loops = case.wires.loops.model_copy(update={"slack": slack})
    changed = case.model_copy(update={"wires": case.wires.model_copy(update={"loops": loops})})
    folder = sized.folder / "verify"
    done = simulate(as_loaded(changed), folder, resume=False, force=True, seed=0, watch=watch)
    found = evaluate(_history(done), criterion, parameters=parameters)
    verified = {"slack": slack, "largest_probability": found.failure_probability.max(initial=0.0)}
    return replace(sized, data=_written({**sized.data, "verified": verified}, sized.folder))


def _written(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Write loop_sizes.json and return what is in it."""
    cleaned: dict[str, Any] = plain(data)
    text = json.dumps(cleaned, indent=1, allow_nan=False) + "\n"
    folder.joinpath("loop_sizes.json").write_text(text, encoding="utf-8")
    return cleaned


def _write_csv(rows: list[dict[str, Any]], path: Path) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
