"""Time, memory and linear solves of the punch from 600 to 876 000 trusses, with a log-log plot and its exponent.

    python tests/benchmarks/solver_scaling.py [--largest 37000] [--seconds 900] [--folder DIR]

Sphere of 30 mm to 52.5 mm from flat and slack, frictionless, 21 increments. Every case runs in a process of its own, so
that peak memory is its own, after a small run that loads compiled kernels and oneMKL. A case that is not through after
`--seconds` is ended at its next increment, and the row says how far it came. `factors` is the processor time of the
run over that of one bare factorisation of its last tangent in the same process: a busy machine slows both.
"""

from __future__ import annotations

import argparse
import multiprocessing
import resource
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from etextile.solve.path import advance
from etextile.solve.system import System
from loadcases.build import build, settings
from loadcases.reader import load_case


@dataclass(frozen=True)
class Size:
    """A row: coarsening of the lattice, portion of the specimen, with or without wires."""

    coarsening: float
    portion: str = "quarter"
    wires: bool = False


@dataclass(frozen=True)
class Row:
    """What came of it: trusses, increments, seconds (wall, processors, factors and solves), solves, GB, N, mm."""

    size: Size
    trusses: int
    increments: int
    wall: float
    processor: float
    solving: float
    solves: int
    memory: float
    force: float
    penetration: float
    factor: float

    @property
    def factors(self) -> float:
        """Processor time in bare factorisations."""
        return self.processor / self.factor

    @property
    def rest(self) -> float:
        """Assembly, evaluation, contact and everything else over factorisation and substitution."""
        return (self.wall - self.solving) / self.solving


SIZES = (
    Size(19.5), Size(9.75), Size(4.87), Size(2.437), Size(1.0), Size(1.0, wires=True), Size(1.0, "whole", wires=True),
)  # fmt: skip
COLUMNS = (
    ("trusses", 8), ("portion", 9), ("wires", 6), ("increments", 11), ("wall s", 9), ("cpu s", 9), ("solves", 8),
    ("growth", 8), ("factors", 9), ("other/solving", 15), ("peak GB", 9), ("force N", 10), ("deepest mm", 12),
)  # fmt: skip
TRUSSES = {19.5: 600, 9.75: 2400, 4.87: 9400, 2.437: 37100, 1.0: 219100}


def expected(size: Size) -> int:
    """Return about how many trusses a row has."""
    return TRUSSES[size.coarsening] * (4 if size.portion == "whole" else 1)


def overrides(size: Size, *, steps: int = 21) -> list[str]:
    """Return the overrides of the shipped punch case."""
    chosen = [f"fabric.coarsening={size.coarsening}", f"fabric.portion={size.portion}", f"motion.steps={steps}"]
    return chosen if size.wires else [*chosen, "wires=null"]


def measure(size: Size, seconds: float) -> Row:
    """Run one case; called in a fresh process."""
    small = load_case("punch", overrides=[*overrides(Size(25.0, wires=size.wires)), "motion.total=5", "motion.steps=2"])
    list(advance(build(small.case).model, settings(small.case)))
    case = load_case("punch", overrides=overrides(size)).case
    model = build(case).model
    begun, spent = time.perf_counter(), time.process_time()
    system = System(model)
    solves, last, penetration, done = 0, 0.0, 0.0, 0
    for step in advance(model, settings(case), system=system):
        solves += step.verdict.linear_solves
        done += step.output
        last, penetration = step.punch_force_N, max(penetration, step.max_penetration_mm)
        if time.perf_counter() - begun > seconds:
            break
    wall, processor, counters = time.perf_counter() - begun, time.process_time() - spent, system.counters
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024**2
    return Row(
        size, model.truss_count, done, wall, processor, counters.factorise_s, solves, memory, last, penetration,
        bare_factorisation(system),
    )  # fmt: skip


def bare_factorisation(system: System, *, times: int = 5) -> float:
    """Return the processor seconds of one factorisation of the last tangent: the least of some."""
    values, found = system._values.copy(), []
    for _ in range(times):
        begun = time.process_time()
        system.solver.factorise(values)
        found.append(time.process_time() - begun)
    return min(found)


def exponent(rows: list[Row]) -> float:
    """Return the slope of log time over log trusses by least squares."""
    size, wall = ([np.log(getattr(row, name)) for row in rows] for name in ("trusses", "wall"))
    return float(np.polyfit(size, wall, 1)[0])


def draw(rows: list[Row], folder: Path) -> None:
    """Write solver_scaling.png."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    count, wall = (np.array([getattr(row, name) for row in rows]) for name in ("trusses", "wall"))
    axes.loglog(count, wall, "o-", label=f"measured, exponent {exponent(rows):.2f}")
    axes.loglog(count, wall[0] * (count / count[0]) ** 1.3, "--", color="0.6", label="exponent 1.3")
    axes.set(xlabel="trusses", ylabel="wall time of 21 increments, s")
    axes.legend()
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "solver_scaling.png", dpi=130)
    print(f"wrote {folder / 'solver_scaling.png'}")


def main() -> None:
    """Print one row per size, then the exponent."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--largest", type=int, default=37100, help="most trusses of a row")
    parser.add_argument("--smallest", type=int, default=0, help="fewest trusses of a row")
    parser.add_argument("--seconds", type=float, default=900.0, help="a case is ended after about this long")
    parser.add_argument("--folder", type=Path, default=None, help="where the plot goes; none without it")
    options = parser.parse_args()
    print("".join(f"{name:>{width}}" for name, width in COLUMNS))
    rows: list[Row] = []
    for size in SIZES:
        if not options.smallest <= expected(size) <= options.largest:
            continue
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(1, mp_context=context) as pool:
            row = pool.submit(measure, size, options.seconds).result()
        rows.append(row)
        growth = f"{row.solves / rows[0].solves:.2f}" if row.increments == rows[0].increments else ""
        cells = (
            row.trusses, size.portion, "yes" if size.wires else "no", row.increments, f"{row.wall:.2f}",
            f"{row.processor:.2f}", row.solves, growth, f"{row.factors:.0f}",
            f"{row.rest:.2f}", f"{row.memory:.2f}", f"{row.force:.1f}",
            f"{row.penetration:.4f}",
        )  # fmt: skip
        print("".join(f"{cell:>{width}}" for cell, (_, width) in zip(cells, COLUMNS, strict=True)), flush=True)
    complete = [row for row in rows if row.increments == 21]
    if len(complete) > 1:
        print(f"time grows with the number of trusses to the power {exponent(complete):.2f}")
    if options.folder is not None and len(complete) > 1:
        draw(complete, options.folder)


if __name__ == "__main__":
    main()
