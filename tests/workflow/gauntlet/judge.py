"""Diagnose the sets of the gauntlet: `python tests/workflow/gauntlet/judge.py OUT [--only NAME ...] [--jobs 2]`.

Every folder OUT/sets/NAME is diagnosed as a user would do it, on the shipped case `punch`; what was found goes to
OUT/results/NAME.json, and where another measurement is asked for, its folder to OUT/next/NAME. Nothing here knows what
is hidden.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from etextile.diagnose.predict.simulate import Runner
from etextile.diagnose.workflow import diagnose
from etextile.environment import single_threaded
from etextile.studies.diagnose.next_folder import write_folder
from etextile.studies.diagnose.plan import plan
from etextile.studies.diagnose.question import Silence
from etextile.studies.diagnose.rounds import go_on
from etextile.studies.diagnose.setting import assemble
from etextile.studies.diagnose.simulator import CaseSimulator
from loadcases.measurements import load_measurements
from loadcases.reader import load_case


def judged(folder, cache, *, ask_in=None, case="punch", changes=(), among=(), fingerprint=None, workers=1):
    """Diagnose one folder and return what counts as plain data; `ask_in`: where a next measurement is asked for."""
    start, spent = time.perf_counter(), time.process_time()
    task = assemble(load_case(case, overrides=changes), load_measurements(folder), among=among)
    simulator = task.simulator if fingerprint is None else CaseSimulator(task.simulator.case, fingerprint)
    lines = []
    runner = Runner(simulator, cache, workers)
    found = diagnose(task.setting, runner, lambda stage, text: lines.append(f"{stage}: {text}"))
    found = go_on(task, found, runner, Silence())
    coming = plan(task, found, runner) if ask_in is not None else None
    asked = None if coming is None else write_folder(coming, task, found, ask_in)
    runner.close()
    return {
        "set": folder.name,
        "asked": None if asked is None else coming.best.trial.id,
        "rounds": [{"test": item.test, "after": item.after} for item in found.rounds],
        "verdict": found.verdict.kind,
        "effects": list(found.verdict.effects),
        "ambiguous_with": list(found.verdict.ambiguous_with),
        "classes": [list(group) for group in found.verdict.classes],
        "faults": [item.id for item in found.verdict.faults],
        "failed_checks": [item.id for item in found.verdict.failed],
        "sentence": found.verdict.sentence,
        "next": found.next_measurement,
        "finalists": [_finalist(item) for item in found.finalists],
        "ranking": [
            (item.kind, item.label, float(p), float(item.score - found.ranking.best.score))
            for item, p in list(zip(found.ranking.contenders, found.ranking.probabilities, strict=True))[:12]
        ],
        "p_value": found.scan.p_value,
        "lines": lines,
        "simulations": runner.count,
        "wall_s": time.perf_counter() - start,
        "cpu_s": time.process_time() - spent,
        "places": [_place(place) for place in found.places],
        "split": found.split,
        "parameters": _parameters(found),
    }


def _place(place):
    """Return where the gap is: channel, window of displacement, onset with its interval."""
    window = place.window
    return {
        "sentence": place.sentence, "channel": place.channel, "window": (window.low, window.high),
        "onset": (place.onset.at, place.onset.low, place.onset.high),
    }  # fmt: skip


def _finalist(item):
    return {
        "ids": list(item.contender.ids),
        "probability": item.probability,
        "alone": item.alone,
        "coarse": item.probability_coarse,
        "rest_p": item.rest_p,
        "bound": list(item.at_bound),
        "objections": list(item.objections()),
        "closed": item.closed,
        "held_out": [(part.what, part.closed, part.low, part.high, part.before, part.after) for part in item.held_out],
    }


def _parameters(found):
    best = found.verdict.best or (found.finalists[0] if found.finalists else None)
    if best is None:
        return {}
    values, start = {}, 0
    for name in best.contender.ids:
        for axis in found.tables[name].grid.axes:
            middle, low, high = best.contender.evidence.interval(start)
            values[f"{name}.{axis.parameter.name}"] = [float(axis.to_value(c)) for c in (middle, low, high)]
            start += 1
    return values


def judge(folder, out, options, *, name=None, round_number=0):
    """Diagnose one folder into OUT/results unless that is done already, and return a line about it.

    After further measurements: OUT/results_1, OUT/next_2, and so on, under the `name` of the set.
    """
    name, behind = name or folder.name, f"_{round_number}" if round_number else ""
    target = out / f"results{behind}" / f"{name}.json"
    if target.exists():
        return ""
    ask_in = out / (f"next_{round_number + 1}" if round_number else "next") / name
    try:
        found = {**judged(folder, out / "cache", ask_in=ask_in, **options), "set": name}
    except Exception as error:
        found = {"set": name, "verdict": "error", "sentence": f"{type(error).__name__}: {error}", "effects": []}
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps(found, indent=1), encoding="utf-8")
    chance = found["finalists"][0]["probability"] if found.get("finalists") else 0.0
    effects = "+".join(found["effects"])
    return f"{name:34s} {found['verdict']:12s} {effects:34s} {chance:.2f} {found.get('wall_s', 0):.0f} s"


def judge_all(out, *, only=("",), jobs=1, **options):
    """Diagnose folders OUT/sets/NAME in the order of `only`: the first with all processes, the others side by side.

    The first simulates the tables; with those that take longest next, all processes end at about the same time.
    """
    every = sorted((out / "sets").iterdir())
    folders = list(dict.fromkeys(folder for start in only for folder in every if folder.name.startswith(start)))
    if jobs > 1 and folders:
        print(judge(folders[0], out, {**options, "workers": jobs}), flush=True)
    context = multiprocessing.get_context("spawn")
    with single_threaded(), ProcessPoolExecutor(jobs, mp_context=context) as pool:
        for future in [pool.submit(judge, folder, out, options) for folder in folders]:
            if future.result():
                print(future.result(), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--only", nargs="*", default=("",), help="beginnings of names, in the order to be done")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--case", default="punch")
    parser.add_argument("--set", nargs="*", default=(), dest="changes")
    parser.add_argument("--fingerprint", help="name under which runs are cached, whatever the code")
    given = parser.parse_args()
    options = {"case": given.case, "changes": given.changes, "fingerprint": given.fingerprint}
    judge_all(given.out, only=given.only, jobs=given.jobs, **options)


if __name__ == "__main__":
    main()
