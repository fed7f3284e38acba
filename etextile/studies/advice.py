"""What to change so that the wires hold: slack, position, depth; each tried by a run with the change and nothing else.

What is tried follows from the run itself: the slack by sizing, the position from where its wires hold, the depth from
when the first one does not. Whether it is enough is what the run with the change says, not what was expected of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from etextile.errors import BadInput, NoEquilibrium
from etextile.results.wire_history import WireHistory
from etextile.solve.path import Increment
from etextile.studies.layout import read_layout
from etextile.studies.run.lattice_limit import solve_at
from etextile.studies.run.outcome import Run
from etextile.studies.sizing import crimp_of_wires, needed_crimp, rounded_up, sized_wires, sizing_judge
from etextile.types import Array
from loadcases.reader import stored_case
from loadcases.schema import Case
from wires.construction import percent_of
from wires.drawing_files import write_drawing
from wires.failure import DEFAULT_CRITERION
from wires.judge import Judge
from wires.report_files import plain, write_report_json
from wires.sizing import LARGEST, reached, size_loops
from wires.wording import chance


TARGET = 0.01
"""Probability that a filament breaks, of a loop or a piece in the weave, that a change has to keep."""
FOLDER = "advice"
MARGIN_MM = 1.0
"""What is left between a drawing that was moved and the edge of the piece."""
Watch = Callable[[Increment], None]


@dataclass(frozen=True)
class Standing:
    """How the wires stand a motion: probability of a broken filament of the worst part, expected wires with one."""

    worst: float
    broken: float
    wires: int

    @classmethod
    def of(cls, history: WireHistory, judge: Judge) -> Standing:
        """Judge a history."""
        found = judge.judge(history)
        garment = None if found.reliability is None else found.reliability.garment("broken").expected.value
        return cls(reached(found, "loop").value, garment or 0.0, int(history.layout.wire_copies.sum()))


@dataclass(frozen=True)
class AdviceTrial:
    """A change that is tried: `what` and `how` in words, the keys that change; or `reason`, why there is none."""

    what: str
    how: str = ""
    case: Case | None = None
    keys: tuple[tuple[str, Any], ...] = ()
    reason: str = ""


def advise(found: Run, *, target: float = TARGET, watch: Watch = lambda _: None) -> dict[str, Any]:
    """Try slack, position and depth on a run, add what came out to its report (`advice`), write report.json again.

    At most three runs in memory, as long as the first. Judged by the case's criterion, by `calibrated` where that is
    `span_strain`, which knows no slack. Raises BadInput for a run without wires.
    """
    if found.results.wires is None or found.results.steps == 0:
        raise BadInput.of("the run has no wires to keep whole", file=str(found.folder))
    case = stored_case(found.results.case.effective, str(found.results.path))
    history, judge = found.results.wires, sizing_judge(case)
    now = Standing.of(history, judge)
    block: dict[str, Any] = {"target": target, "criterion": judge.criterion.name, "now": asdict(now), "changes": []}
    if case.failure.criterion != judge.criterion.name:
        block["note"] = f"judged by {DEFAULT_CRITERION}: {case.failure.criterion} knows no slack"
    if now.worst <= target:
        block["sentence"] = (
            f"Nothing has to change: the worst loop or piece in the weave loses a filament with {chance(now.worst)}."
        )
    else:
        trials = _trials(case, history, judge, target, found.folder / FOLDER)
        block["changes"] = [_tried(trial, now, judge, target, watch) for trial in trials]
        block["sentence"] = ""
    cleaned: dict[str, Any] = plain(block)
    found.report["advice"] = cleaned
    write_report_json(found.report, found.folder / "report.json", overwrite=True)
    return cleaned


def _trials(case: Case, history: WireHistory, judge: Judge, target: float, folder: Path) -> Sequence[AdviceTrial]:
    """Return what is worth a try."""
    found = []
    for what, make in (("Slack", _slack), ("Position", _position), ("Depth", _depth)):
        try:
            found.append(make(case, history, judge, target, folder))
        except BadInput as error:
            found.append(AdviceTrial(what, reason=error.problems[0].message))
    return found


def _slack(case: Case, history: WireHistory, judge: Judge, target: float, folder: Path) -> AdviceTrial:
    """Return one slack for all loops, and crimp where the weave breaks too, by sizing."""
    crimps = crimp_of_wires(case)
    crimp = float(crimps.min())
    sizes = size_loops(history, target, judge=judge, crimp=crimps)
    if not np.isfinite(sizes.everywhere):
        reason = f"no slack up to {percent_of(LARGEST)} is enough ({chance(sizes.reached)} in the worst part with that)"
        return AdviceTrial("Slack", reason=reason)
    slack, more = rounded_up(sizes.everywhere), needed_crimp(sizes, crimps)
    before = sorted({float(value) for value in history.layout.loop_slack})
    was = " to ".join(percent_of(value) for value in (before[:1] + before[-1:] if len(before) > 1 else before))
    same = len(before) == 1 and abs(slack - before[0]) < 1e-9
    how = f"with slack as it is ({was})" if same else f"with {percent_of(slack)} slack in every loop (now {was})"
    keys: list[tuple[str, Any]] = [("wires.loops.slack", slack)]
    if more != crimp:
        how += f" and {percent_of(more)} crimp (now {percent_of(crimp)})"
        keys.append(("wires.crimp", more))
    folder.mkdir(parents=True, exist_ok=True)
    changed = case.model_copy(update={"wires": sized_wires(case, slack, more, folder)})
    return AdviceTrial("Slack", how, changed, tuple(keys))


def _position(case: Case, history: WireHistory, judge: Judge, target: float, folder: Path) -> AdviceTrial:
    """Return the wires far enough from the middle line, alone: those beyond the last one that does not hold."""
    wires, layout = case.wires, history.layout
    if wires is None or wires.drawn:
        holding = [name for name, p in zip(layout.names, _by_wire(history, judge), strict=True) if p <= target]
        return _shifted(case, holding, folder)
    away = np.abs(layout.weft_mm)
    failing = away[_by_wire(history, judge) > target].max(initial=-1.0)
    kept = away > failing + 1e-6
    if not kept.any():
        return AdviceTrial("Position", reason=f"the wires fail up to the edge, {failing:.1f} mm from the middle line")
    least = float(away[kept].min())
    drawing = read_layout(case)
    chosen = tuple(item for item in drawing.wires if abs(item.points[0][1]) > failing + 1e-6)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "wires.csv"
    write_drawing(replace(drawing, wires=chosen), path)
    alone = wires.model_copy(update={"layout": str(path.resolve()), "first_offset": 0.0, "loops": None, "nets": ()})
    count = len(chosen)
    how = (
        f"with wires only where they lie {least:.1f} mm or more from the middle line ({count} of {len(drawing.wires)})"
    )
    return AdviceTrial(
        "Position", how, case.model_copy(update={"wires": alone}), (("wires.layout", f"{FOLDER}/wires.csv"),)
    )


def _shifted(case: Case, holding: Sequence[str], folder: Path) -> AdviceTrial:
    """Return the whole drawing, parts with it, moved to where the piece has most room beside it.

    Parts and nets hold drawn wires together, so they are moved as one; `holding`: the wires that hold as they are.
    """
    drawing, wires = read_layout(case), case.wires
    places = [place for item in drawing.wires for place in item.points]
    corners = [
        (part.at[0] + x * part.size[0] / 2, part.at[1] + y * part.size[1] / 2)
        for part in drawing.parts for x in (-1, 1) for y in (-1, 1)
    ]  # fmt: skip
    low, high = np.min(places + corners, axis=0), np.max(places + corners, axis=0)
    room = 0.5 * np.array(case.pattern) + np.stack([low, -high])  # (2, 2): down and up by direction
    side, axis = np.unravel_index(int(np.argmax(room)), room.shape)
    far = float(np.floor(room[side, axis] - MARGIN_MM))
    said = f"those that hold as they are: {', '.join(holding) or 'none'}"
    if wires is None or far < 1.0:
        return AdviceTrial("Position", reason=f"the drawing fills the piece, its wires cannot be moved; {said}")
    move = np.zeros(2)
    move[axis] = far if side else -far
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "wires.csv"
    write_drawing(drawing.moved(float(move[0]), float(move[1])), path)
    nothing = dict.fromkeys(("along", "at", "from", "to", "path", "loops"))
    named = {
        "layout": str(path.resolve()), "layout_units": None, "components": (),
        "paths": tuple(item.model_copy(update=nothing) for item in wires.paths),
    }  # fmt: skip
    update: dict[str, Any] = {"wires": wires.model_copy(update=named)}
    keys: list[tuple[str, Any]] = [("wires.layout", f"{FOLDER}/wires.csv")]
    if case.fabric.portion != "whole":
        update["fabric"] = case.fabric.model_copy(update={"portion": "whole"})
        keys.append(("fabric.portion", "whole"))
    where = f"{far:g} mm along the {('warp', 'weft')[axis]}, to where the piece has most room"
    how = f"with the whole drawing moved by {where} ({said})"
    return AdviceTrial("Position", how, case.model_copy(update=update), tuple(keys))


def _by_wire(history: WireHistory, judge: Judge) -> Array:
    """Return the probability (W,) of a broken filament of the worst part of each wire."""
    found = judge.judge(history)
    worst = np.zeros(history.layout.n_wires)
    np.maximum.at(worst, history.layout.loop_wire, found.failure_probability)
    if found.woven is not None:
        np.maximum.at(worst, found.woven.pieces.wire, found.woven.failure_probability)
    return worst


def _depth(case: Case, history: WireHistory, judge: Judge, target: float, folder: Path) -> AdviceTrial:
    """Return the motion cut at the last output up to which the wires hold."""
    travel, motion = history.displacement_mm, case.motion
    low, high = 0, len(travel) - 1
    while high - low > 1:
        middle = (low + high) // 2
        holds = reached(judge.judge(_first(history, middle + 1)), "loop").value <= target
        low, high = (middle, high) if holds else (low, middle)
    depth, name = float(travel[: low + 1].max()), "flexion" if motion.target == "joint" else "total"
    if depth <= 0.0:
        return AdviceTrial("Depth", reason=f"a filament is lost within the first output, {travel[1]:.3g} {motion.unit}")
    update: dict[str, Any] = {name: depth}
    if motion.path is not None:
        cut = [min(value, depth) for value in motion.path]
        update["path"] = tuple(value for k, value in enumerate(cut) if k == 0 or value != cut[k - 1])
    changed = case.model_copy(update={"motion": motion.model_copy(update=update)})
    how = f"up to {depth:.4g} {motion.unit} (now {motion.reach:.4g})"
    return AdviceTrial("Depth", how, changed, ((f"motion.{name}", depth),))


def _first(history: WireHistory, steps: int) -> WireHistory:
    """Return the first steps of a history."""
    names = ("displacement_mm", "span_strain", "wire_strain", "element_strain")
    return replace(history, **{name: getattr(history, name)[:steps] for name in names})


def _tried(trial: AdviceTrial, now: Standing, judge: Judge, target: float, watch: Watch) -> dict[str, Any]:
    """Run a trial and return what came out, in words too."""
    row: dict[str, Any] = {"what": trial.what, "change": dict(trial.keys), "after": None, "enough": False}
    if trial.case is None:
        return row | {"sentence": f"{trial.what}: {trial.reason}."}
    try:
        _, history = solve_at(trial.case, trial.case.fabric.coarsening, watch)
    except (BadInput, NoEquilibrium) as error:
        text = error.problems[0].message if isinstance(error, BadInput) else str(error)
        return row | {"sentence": f"{trial.what}: {trial.how}; the run with it did not end ({text}), not confirmed."}
    if history is None:
        raise ValueError("the wires are gone")
    after = Standing.of(history, judge)
    enough = after.worst <= target
    end = "confirmed by a run with it" if enough else f"a run with it says: not enough for {chance(target)}"
    sentence = (
        f"{trial.what}: {trial.how} the worst loop or piece in the weave loses a filament with {chance(after.worst)} "
        f"(now {chance(now.worst)}), on average {after.broken:.1f} of {after.wires} wires do (now {now.broken:.1f} of "
        f"{now.wires}); {end}."
    )
    return row | {"after": asdict(after), "enough": enough, "sentence": sentence}
