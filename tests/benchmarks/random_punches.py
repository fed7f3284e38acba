"""Randomised punch cases: does each one converge or end with a truthful verdict? Prints a table of outcomes.

    python tests/benchmarks/random_punches.py [--count 100] [--seed 1]

Drawn per case: fabric set, sphere radius 8-25 mm, its offset up to 15 mm, friction (none, Coulomb 0.05-1, sticking),
coarsening 10-20, quarter or whole piece, mounting strain -3 to +3 % (slack or taut), 11 to 42 steps to 30-50 mm.
A verdict is checked against the increment itself: residual, penetration, clamp force against punch force.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from dataclasses import dataclass

import numpy as np

from etextile.effects.registry import build_effect
from etextile.errors import NoEquilibrium
from etextile.solve.path import Increment, advance
from loadcases.build import build, settings
from loadcases.reader import load_case


SETS = ("estimated_low", "estimated_mid", "estimated_high")


@dataclass(frozen=True)
class Punch:
    """One random case: overrides of the shipped punch case, and the mounting strain."""

    overrides: tuple[str, ...]
    mounting: float


@dataclass(frozen=True)
class Outcome:
    """What came of it: increments, worst numbers, seconds, and the sentence when the path ended early."""

    increments: int
    reached: float
    solves: int
    cut_backs: int
    force: float
    seconds: float
    sentence: str
    doubt: str


def draw(random: np.random.Generator) -> Punch:
    """Return a random case."""
    quarter = random.random() < 0.5
    offset = (0.0, 0.0) if quarter else tuple(random.uniform(-15.0, 15.0, 2).round(2).tolist())
    friction = random.choice(["0", f"{random.uniform(0.05, 1.0):.3f}", "stick"])
    overrides = (
        f"fabric.set={random.choice(SETS)}",
        f"fabric.coarsening={random.uniform(10.0, 20.0):.2f}",
        f"fabric.portion={'quarter' if quarter else 'whole'}",
        f"body.radius={random.uniform(8.0, 25.0):.2f}",
        f"body.position=[{offset[0]}, {offset[1]}]",
        f"contact.friction={friction}",
        f"motion.total={random.uniform(30.0, 50.0):.2f}",
        f"motion.steps={random.integers(11, 43)}",
        "wires=null",
    )
    return Punch(overrides, float(np.round(random.uniform(-0.03, 0.03), 4)))


def run(punch: Punch) -> Outcome:
    """Run one case to its end."""
    case = load_case("punch", overrides=list(punch.overrides)).case
    model = build(case).model
    if punch.mounting != 0.0:
        model = build_effect("pretension", {"strain": punch.mounting}).apply(model)
    start, steps, sentence = time.perf_counter(), [], ""
    try:
        for step in advance(model, settings(case)):
            steps.append(step)
    except NoEquilibrium as error:
        sentence = str(error)
    return Outcome(
        increments=len(steps),
        reached=steps[-1].displacement_mm / case.motion.total if steps else 0.0,
        solves=sum(step.verdict.linear_solves for step in steps),
        cut_backs=sum(step.verdict.cut_backs for step in steps),
        force=steps[-1].punch_force_N if steps else 0.0,
        seconds=time.perf_counter() - start,
        sentence=sentence,
        doubt=doubt(steps, case.contact.max_penetration),
    )


def doubt(steps: list[Increment], limit: float) -> str:
    """Return what contradicts the verdicts of the increments, nothing if all is as they say."""
    for step in steps:
        if not step.verdict.converged or not step.verdict.residual_N <= step.verdict.tolerance_N:
            return f"residual {step.verdict.residual_N:.2g} N"
        if not np.all(np.isfinite(step.positions)) or not np.isfinite(step.punch_force_N):
            return "not finite"
        if step.max_penetration_mm > limit:
            return f"penetration {step.max_penetration_mm:.3g} mm"
        if abs(step.clamp_force_N - step.punch_force_N) > 1e-3 + 1e-4 * abs(step.punch_force_N):
            return f"clamps {step.clamp_force_N:.6g} N, punch {step.punch_force_N:.6g} N"
    return ""


def main() -> int:
    """Run all cases, print the table; the exit code is 1 when a verdict was not truthful."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, default=None, help="number of the one case to run")
    chosen = parser.parse_args()
    random = np.random.default_rng(chosen.seed)
    punches = [draw(random) for _ in range(chosen.count)]
    tally: Counter[str] = Counter()
    print(f"{'case':>4} {'increments':>10} {'solves':>7} {'cut-backs':>9} {'force N':>9} {'s':>6}  outcome")
    for number, punch in enumerate(punches):
        if chosen.only not in (None, number):
            continue
        found = run(punch)
        outcome = "untruthful" if found.doubt else "ended" if found.sentence else "converged"
        tally[outcome] += 1
        text = f"{number:>4} {found.increments:>10} {found.solves:>7} {found.cut_backs:>9} {found.force:>9.1f}"
        print(f"{text} {found.seconds:>6.1f}  {outcome} {found.doubt}", flush=True)
        if outcome != "converged" or chosen.only is not None:
            print(f"     {' '.join(punch.overrides)} mounting={punch.mounting}\n     {found.sentence}", flush=True)
    print(", ".join(f"{count} {outcome}" for outcome, count in sorted(tally.items())))
    return 1 if tally["untruthful"] else 0


if __name__ == "__main__":
    sys.exit(main())
