"""Slack for the loops of a case, and crimp for its weave: simulate once, size, write; on request simulate again."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from etextile.errors import BadInput
from etextile.files import one_writer, write_table, write_whole
from etextile.results.layout import FILE_NAME
from etextile.results.reader import open_results
from etextile.results.wire_history import WireHistory
from etextile.studies.cases import AnyCase, loaded_case
from etextile.studies.ensemble.plan import plan_of
from etextile.studies.layout import read_layout
from etextile.studies.run.continuation import WAYS, followed, identified_to, reached_in
from etextile.studies.run.limits import check, limits_of
from etextile.studies.run.simulate import Simulation, Watcher, simulate
from etextile.studies.run.worn import folded_loops
from etextile.types import Array
from loadcases.build_wires import constructions_of, wire_layout
from loadcases.fabric import load_fabric
from loadcases.judging import judge_for
from loadcases.nets import numbered_nets
from loadcases.reader import LoadedCase, as_loaded
from loadcases.schema import Case
from loadcases.schema_wires import Wires
from wires.construction import percent_of
from wires.damage import FailureResult
from wires.dependence import EventProbability
from wires.drawing_files import write_drawing
from wires.failure import DEFAULT_CRITERION
from wires.judge import Judge
from wires.report_files import plain
from wires.sizing import LARGEST, LoopSizes, NetStretch, Per, reached, surely
from wires.sizing import size_loops as sizes_of
from wires.trust import exceeded, withheld
from wires.wording import probability


PAGE = "sizing.html"
SIZED_DRAWING = "sized.csv"
"""The drawing of a case with the slack that was found, beside loop_sizes.json."""
STEP = 0.005
"""Slack for all loops and crimp are rounded up to this."""
ROUNDS = 5
"""Simulations at most that verify, each with more slack or crimp than the one before."""
COLUMNS = (
    "wire", "name", "loop", "weft_mm", "warp_mm", "span_strain", "slack_now", "probability_now", "slack", "probability",
    "length_mm",
)  # fmt: skip


@dataclass(frozen=True)
class Sized:
    """What sizing leaves: exit code, the data of loop_sizes.json, its folder."""

    exit_code: int
    data: dict[str, Any]
    folder: Path


@one_writer("folder")
def size_loops(
    case: AnyCase,
    folder: str | Path,
    *,
    target: float = 0.01,
    per: Per = "loop",
    verify: bool = False,
    force: bool = False,
    watch: Watcher | None = None,
) -> Sized:
    """Find the slack, and the crimp of the weave, that keep breaks as rare as `target`; write tables and a page.

    The target is the probability that a filament breaks, `per` garment, net (each wire where none is named by its
    loops) or loop and woven piece. The case is simulated, or its results in `folder` are read. `verify`: simulate it
    once more with what was found. Raises BadInput for a case without loops and for a target that is no probability.
    """
    loaded = loaded_case(case)
    with loaded.locating():
        sized = _size(loaded, Path(folder), target=target, per=per, force=force, watch=watch)
    return verify_sizes(loaded, sized, watch=watch) if verify else sized


def _size(loaded: LoadedCase, folder: Path, *, target: float, per: Per, force: bool, watch: Watcher | None) -> Sized:
    """Do what `size_loops` says, without verifying."""
    case = loaded.case
    crimp = crimp_of_wires(case)
    judge = sizing_judge(case)
    done = _simulated(loaded, folder, force=force, watch=watch)
    history = _history(done)

    def sized(own: WireHistory) -> LoopSizes:
        return sizes_of(own, target, judge=judge, per=per, nets=_nets(case, history), crimp=crimp)

    sizes = sized(history)
    continued = _continued(done, sized, crimp)
    limits = exceeded(check(done, case))
    own = {"slack_for_all": rounded_up(sizes.everywhere), "crimp": needed_crimp(sizes, crimp)}
    largest = {
        name: float(np.max([value, *(item[name] for item in continued.values())])) for name, value in own.items()
    }
    ok = not limits and not done.trouble
    rows = _rows(history, sizes)
    data: dict[str, Any] = {
        "title": case.title,
        "target": target,
        "per": per,
        "whole_wires": per == "net" and not named_stretches(case),
        "criterion": judge.criterion.name,
        "strain_kind": judge.strain_kind,
        "slack_for_all": largest["slack_for_all"],
        "crimp_now": crimp.min(),
        "crimp_now_most": crimp.max(),
        "crimp": largest["crimp"],
        "probability_now": sizes.reached_now,
        "probability": sizes.reached,
        "verdict": _verdict(limits),
        "loops": rows,
        "continuations": continued,
        "notes": _notes(case, done, continued),
        "verified": None,
    }
    data = _written(data, folder)
    _write_csv(rows, folder / "loop_sizes.csv")
    return Sized(3 if done.trouble else 0 if ok else 4, data, folder)


def _continued(
    done: Simulation, sized: Callable[[WireHistory], LoopSizes], crimp: Array
) -> dict[str, dict[str, float]]:
    """Return slack and crimp under the low and the high continuation of laws that are used beyond their range."""
    built = done.built
    if done.trouble or not np.any(reached_in(done.results, built) > identified_to(built)):
        return {}
    paths = {way: followed(built, done.results, way=way, inside=done.inside).history for way in WAYS}
    sizes = {way: sized(history) for way, history in paths.items() if history is not None}
    return {
        way: {"slack_for_all": rounded_up(item.everywhere), "crimp": needed_crimp(item, crimp)}
        for way, item in sizes.items()
    }


def needed_crimp(sizes: LoopSizes, crimp: Array) -> float:
    """Return the crimp that all wires need at least, rounded up; the smallest they have (W,) where it is enough."""
    least = float(crimp.min())
    return least if sizes.crimp <= least else rounded_up(sizes.crimp)


def crimp_of_wires(case: Case) -> Array:
    """Return the crimp (W,) of the wires of a case; raises BadInput where there are no loops."""
    wires = case.wires
    layout = None if wires is None else wire_layout(case, load_fabric(case.fabric.set))
    if wires is None or layout is None or not layout.n_loops:
        raise BadInput.of("the case has no loops to size", key="wires.loops")
    return np.array([made.crimp for made in constructions_of(case, layout)])


def sizing_judge(case: Case) -> Judge:
    """Return who sizes: the case's own judge, but the calibrated one where the paper's reading knows no slack."""
    return judge_for(case, criterion=DEFAULT_CRITERION if case.failure.criterion == "span_strain" else None)


def _nets(case: Case, history: WireHistory) -> tuple[NetStretch, ...]:
    """Return the nets of the case that are stretches between loops, or every wire where it names none."""
    return named_stretches(case) or tuple(NetStretch(wire) for wire in range(history.layout.n_wires))


def named_stretches(case: Case) -> tuple[NetStretch, ...]:
    """Return the nets of the case that are stretches of a wire between loops."""
    return tuple(NetStretch(net.wire, net.from_loop, net.to_loop) for net in numbered_nets(case))


def _simulated(loaded: LoadedCase, folder: Path, *, force: bool, watch: Watcher | None) -> Simulation:
    """Return the simulation of the case, gone on with where the folder has some of it."""
    path = folder / FILE_NAME
    resume = path.exists() and not force and open_results(path).case.sha256 == loaded.sha256
    return simulate(loaded, folder, resume=resume, force=force, seed=0, watch=watch)


def _history(done: Simulation) -> WireHistory:
    if done.results.wires is None or done.results.steps == 0:
        raise BadInput.of(f"no increment converged, there is nothing to size: {done.trouble}")
    return done.results.wires


def rounded_up(value: float) -> float:
    """Return a slack or crimp rounded up."""
    return float(np.ceil(value / STEP - 1e-9) * STEP)


def _rows(history: WireHistory, sizes: LoopSizes) -> list[dict[str, Any]]:
    layout = history.layout
    columns = (
        layout.loop_wire, [layout.names[wire] for wire in layout.loop_wire], layout.loop_index,
        layout.loop_weft_mm, layout.loop_warp_mm, history.max_span_strain,
        layout.loop_slack, sizes.probability_now, sizes.slack, sizes.probability,
        layout.loop_span_mm * (1.0 + sizes.slack),
    )  # fmt: skip
    return [dict(zip(COLUMNS, row, strict=True)) for row in zip(*columns, strict=True)]


def _verdict(limits: list[str]) -> dict[str, Any]:
    """Return whether sizes are withheld, and the sentence about it; `limits`: sentences on those that are exceeded."""
    return {"withheld": bool(limits), "limits": limits, "sentence": withheld(limits)}


def _slack_words(slack: float) -> str:
    """Return a slack that is enough in words."""
    return percent_of(slack) if np.isfinite(slack) else f"none up to {percent_of(LARGEST)}"


def _notes(case: Case, done: Simulation, continued: dict[str, dict[str, float]]) -> list[str]:
    """Return what a reader must know: who sized, sliding, what is left out, broken-off runs."""
    notes = [done.trouble] if done.trouble else []
    if case.worn and done.results.wires is not None:
        folded = int(folded_loops(done.results).sum())
        if folded:
            notes.append(f"{folded} of the loops lie in folds of the crook: what they need there is undetermined")
    if continued:
        under = ", ".join(f"{way} {_slack_words(item['slack_for_all'])}" for way, item in continued.items())
        notes.append(
            f"laws are used beyond their range; slack for all by their continuations: {under}; the most counts"
        )
    if case.failure.criterion == "span_strain":
        notes.append("sized by the calibrated criterion: the paper's own reading, span_strain, knows no slack")
    if case.wires is not None and case.wires.bond != "perfect":
        notes.append("the wires slide, so the weave beside a loop shares its slack: check the sizes with --verify")
    left_out = _left_out(case)
    if left_out:
        notes.append(
            f"left out is the scatter of {', '.join(left_out)} (etextile ensemble has it); counted are the strength of "
            "wires, between loops and between garments, and what is not known of the coupons"
        )
    return notes


def _left_out(case: Case) -> list[str]:
    """Return what scatters from specimen to specimen by the case and is not in the sizes, each with its size."""
    plan, scatter = plan_of(case), case.scatter
    found = [f"the laws of {', '.join(plan.families)} ({scatter.fabric:g} x their covariance)"] if plan.families else []
    alike: dict[tuple[str, str], list[str]] = {}
    for item in plan.inputs:
        if item.name != "strength":
            label, _, axis = (
                item.label.rpartition(" ") if item.label[-2:] in (" x", " y", " z") else (item.label, "", "")
            )
            alike.setdefault((label, f"{item.std:g} {item.unit}".strip()), []).append(axis)
    found += [f"{label} {', '.join(axes)}".strip() + f" ({size})" for (label, size), axes in alike.items()]
    return [*found, f"slack from loop to loop ({percent_of(plan.loop_slack)} of it)"] if plan.loop_slack else found


def verify_sizes(loaded: LoadedCase, sized: Sized, *, watch: Watcher | None = None) -> Sized:
    """Simulate the case again with slack and crimp found, judge every loop and woven piece, add what was found.

    Where the probability keeps the target and its interval (what is not known of the coupons) does not, slack and crimp
    are enlarged until the upper end does too, each time by another simulation: `ROUNDS` at most, and none once a trust
    limit is passed. Nothing is done where no slack is enough. The last simulation is kept in the folder `verify`.
    """
    target, per, notes = sized.data["target"], sized.data["per"], list(sized.data["notes"])
    slack, crimp, rounds = sized.data["slack_for_all"], sized.data["crimp"], 0
    if loaded.case.wires is None or slack is None or not np.isfinite(slack):
        return sized
    while True:
        found = _verified(loaded, sized.folder, per, slack, crimp, watch=watch)
        rounds += 1
        if found.trouble or found.limits or found.event.high <= target or rounds == ROUNDS:
            break
        more, crimped = surely(
            found.history, target, judge=found.judge, per=per, nets=_nets(found.case, found.history),
            crimp=crimp_of_wires(found.case),
        )  # fmt: skip
        if not np.isfinite(more):
            break
        notes.append(
            f"with a slack of {percent_of(slack)} and a crimp of {percent_of(crimp)} the probability is "
            f"{probability(found.event.value)}, but up to {probability(found.event.high)} for what is not known of the "
            "coupons: taken further"
        )
        wider = rounded_up(max(more, slack)), max(rounded_up(crimped), crimp) if crimped > crimp else crimp
        slack, crimp = wider if wider != (slack, crimp) else (slack + STEP, crimp)
    verified = {"slack": slack, "crimp": crimp, "rounds": rounds, **found.report(target)}
    code = 3 if found.trouble else 4 if found.limits else 0
    both = [*sized.data["verdict"]["limits"], *(f"with these sizes: {sentence}" for sentence in found.limits)]
    own = {"slack_for_all": slack, "crimp": crimp, "notes": notes}
    data = _written({**sized.data, **own, "verified": verified, "verdict": _verdict(both)}, sized.folder)
    return replace(sized, exit_code=max(sized.exit_code, code, key=(0, 4, 3).index), data=data)


@dataclass(frozen=True)
class _Verified:
    """A case simulated with the slack and crimp found: its wires, who judged them and how, limits that are passed."""

    case: Case
    history: WireHistory
    judge: Judge
    found: FailureResult
    event: EventProbability
    limits: list[str]
    trouble: str

    def report(self, target: float) -> dict[str, Any]:
        """Return what loop_sizes.json says of it; `surely_met`: by the whole interval."""
        found, event = self.found, self.event
        garment = None if found.reliability is None else found.reliability.garment("broken").anything
        return {
            "probability": event.value,
            "low": event.low,
            "high": event.high,
            "met": event.value <= target,
            "surely_met": event.high <= target,
            "limits": self.limits,
            "garment": None if garment is None else vars(garment),
            "largest_probability": found.failure_probability.max(initial=0.0),
            "largest_woven_probability": None
            if found.woven is None
            else found.woven.failure_probability.max(initial=0.0),
            "largest_woven_strain": None if found.woven is None else found.woven.max_strain.max(initial=0.0),
        }


def _verified(
    loaded: LoadedCase, folder: Path, per: Per, slack: float, crimp: float, *, watch: Watcher | None
) -> _Verified:
    """Simulate and judge the case with one slack for all loops and at least so much crimp."""
    changed = loaded.case.model_copy(update={"wires": sized_wires(loaded.case, slack, crimp, folder)})
    done = simulate(as_loaded(changed), folder / "verify", resume=False, force=True, seed=0, watch=watch)
    history, judge = _history(done), sizing_judge(changed)
    found = judge.judge(history)
    _, checks = limits_of(done, changed, judge, damage=found)
    event = reached(found, per, _nets(changed, history))
    return _Verified(changed, history, judge, found, event, exceeded(checks), done.trouble or "")


def sized_wires(case: Case, slack: float, crimp: float, folder: Path) -> Wires:
    """Return the wires with one slack for all loops, and at least so much crimp.

    Drawn ones are given by a drawing of them, sized.csv, in the folder.
    """
    wires = case.wires
    if wires is None:
        raise ValueError("the case has no wires")
    common = max(crimp, wires.crimp)
    if not wires.drawn:
        loops = None if wires.loops is None else wires.loops.model_copy(update={"slack": slack})
        return wires.model_copy(update={"loops": loops, "crimp": common})
    drawn = read_layout(case)
    slackened = tuple(
        replace(spec, loops=tuple(replace(loop, slack=slack) for loop in spec.loops)) for spec in drawn.wires
    )
    path = folder / SIZED_DRAWING
    write_drawing(replace(drawn, wires=slackened), path)
    nothing = dict.fromkeys(("along", "at", "from", "to", "path", "loops"))
    paths = tuple(
        item.model_copy(update={**nothing, "crimp": None if item.crimp is None else max(item.crimp, crimp)})
        for item in wires.paths
    )
    named = {"layout": str(path.resolve()), "layout_units": None, "paths": paths, "crimp": common}
    return wires.model_copy(update=named)


def _written(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Write loop_sizes.json and return what is in it."""
    cleaned: dict[str, Any] = plain(data)
    text = json.dumps(cleaned, indent=1, allow_nan=False) + "\n"
    write_whole(folder / "loop_sizes.json", text)
    from viz.sizing_html import render_sizing_html

    write_whole(folder / PAGE, render_sizing_html(cleaned))
    return cleaned


def _write_csv(rows: list[dict[str, Any]], path: Path) -> None:
    write_table(path, [COLUMNS, *([row.get(name, "") for name in COLUMNS] for row in rows)])
