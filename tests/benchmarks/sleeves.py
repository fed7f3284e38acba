"""Sleeves in numbers: what ease, friction and cuffs do to the wires, and whether random sleeves come to an end.

    python tests/benchmarks/sleeves.py designs [--coarsening 52] [--flexion 120] [--folder DIR]
    python tests/benchmarks/sleeves.py random [--count 60] [--seed 1]

`designs` bends the case elbow_sleeve for every ease, friction and cuff and prints the share of its wires that lose a
filament and that are interrupted (expected, over all scatter but that of the limb); with --folder it leaves a table
that it goes on with when called again, and a picture. `random` draws ease, friction, girths, ends, angle and wires.
A run without equilibrium is judged up to where it came, and the table says where that is.
"""

from __future__ import annotations

import argparse
import csv
import itertools
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np

import etextile as et
from etextile.results.reader import Results
from etextile.studies.run.limits import check
from etextile.studies.run.simulate import simulate
from etextile.studies.run.worn import FOLDED
from loadcases.judging import judge_for


EASE = (-0.10, 0.15, 0.05, 0.0, -0.05, 0.10)
"""The ends first: a table that is not finished is a picture already."""
FRICTION = (0.0, 0.1, 0.3, 0.5)
CUFFS = ("held", "band", "free")
SIMPLE = {"solver.max_cut_backs": 4}
"""A path that cannot go on is left soon: it is one of many."""


@dataclass(frozen=True)
class Outcome:
    """What came of a sleeve: angle reached, shares of its wires, shares of loops in folds, effort, and the verdict."""

    ease: float
    friction: float
    cuff: str
    reached_deg: float
    damaged: float
    interrupted: float
    folded: float
    moment_Nmm: float
    increments: int
    solves: int
    cut_backs: int
    seconds: float
    limits: str
    trouble: str


def run(changes: Mapping[str, object], *, ease: float, friction: float, cuff: str) -> Outcome:
    """Bend one sleeve and judge its wires."""
    chosen = {"fabric.ease": ease, "contact.friction": friction, **SIMPLE, **changes}
    case, begun = et.load("elbow_sleeve", chosen), time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        done = simulate(case, Path(folder), resume=False, force=True, seed=0, watch=None)
        results = done.results
        damaged, interrupted, folded = _wires(case, results) if results.steps else (np.nan, np.nan, np.nan)
        rows = results.increments
        return Outcome(
            ease=ease,
            friction=friction,
            cuff=cuff,
            reached_deg=float(results.displacement_mm[-1]) if results.steps else 0.0,
            damaged=damaged,
            interrupted=interrupted,
            folded=folded,
            moment_Nmm=float(np.degrees(results.curves.punch_force_N[-1])) if results.steps else 0.0,
            increments=len(rows.linear_solves),
            solves=int(np.sum(rows.linear_solves)),
            cut_backs=int(np.sum(rows.cut_backs)),
            seconds=time.perf_counter() - begun,
            limits="; ".join(item.name for item in check(done, case.case) if not item.ok),
            trouble=done.trouble.split(" (")[0],
        )


def _wires(case: et.LoadedCase, results: Results) -> tuple[float, float, float]:
    """Return the shares of wires damaged and interrupted, and of loops that were in folds while the joint bent."""
    if results.wires is None:
        return np.nan, np.nan, np.nan
    found = judge_for(case.case).judge(results.wires)
    copies = found.layout.wire_copies
    bends = results.displacement_mm > 0.0
    folded = (results.wires.span_strain[1:][bends] < -FOLDED).any(axis=0)
    loops = found.layout.loop_copies * copies[found.layout.loop_wire]
    chances = found.wires
    if chances is None:
        return np.nan, np.nan, np.nan
    shares = [float(copies @ values / copies.sum()) for values in (chances.failure, chances.opened)]
    return shares[0], shares[1], float(loops @ folded / loops.sum())


def designs(coarsening: float, flexion: float, folder: Path | None) -> Iterator[Outcome]:
    """Yield the outcome of every design, those that the folder's table has first."""
    path = None if folder is None else folder / "designs.csv"
    known = _read(path)
    yield from known
    there = {(item.ease, item.friction, item.cuff) for item in known}
    common = {"fabric.coarsening": coarsening, "motion.flexion": flexion, "motion.steps": int(np.ceil(flexion / 10.0))}
    for ease, friction, cuff in itertools.product(EASE, FRICTION, CUFFS):
        if (ease, friction, cuff) not in there:
            ends = {"supports.ends": ["held", cuff]}
            found = run({**common, **ends}, ease=ease, friction=friction, cuff=cuff)
            if path is not None:
                _append(found, path)
            yield found


def _read(path: Path | None) -> list[Outcome]:
    if path is None or not path.is_file():
        return []
    kinds = {item.name: {"float": float, "int": int, "str": str}[str(item.type)] for item in fields(Outcome)}
    with path.open(encoding="utf-8", newline="") as file:
        return [Outcome(**{name: kinds[name](value) for name, value in row.items()}) for row in csv.DictReader(file)]


def _append(found: Outcome, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    fresh = not path.is_file()
    with path.open("a", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, [item.name for item in fields(Outcome)], lineterminator="\n")
        if fresh:
            writer.writeheader()
        writer.writerow(asdict(found))


def draw_designs(found: Sequence[Outcome], path: Path) -> None:
    """Draw the share of wires damaged over ease: a panel per cuff, a line per friction; hollow: ended early."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from viz.style import FAINT, SERIES, drawing

    reach = max(item.reached_deg for item in found)
    with drawing():
        figure = Figure(figsize=(9.6, 3.6), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots(1, len(CUFFS), sharey=True)
        for panel, cuff in zip(axes, CUFFS, strict=True):
            for number, friction in enumerate(FRICTION):
                own = sorted((o for o in found if (o.cuff, o.friction) == (cuff, friction)), key=lambda o: o.ease)
                colour = SERIES[number % len(SERIES)]
                own = [o for o in own if o.reached_deg > 0.0]
                through = [o for o in own if o.reached_deg >= reach - 1e-6]
                x, y = ([100.0 * getattr(o, name) for o in through] for name in ("ease", "damaged"))
                panel.plot(x, y, color=colour, linewidth=1.2, label=f"friction {friction:g}")
                for o in own:
                    whole = o.reached_deg >= reach - 1e-6
                    panel.plot(
                        100.0 * o.ease, 100.0 * o.damaged, "o", color=colour, markersize=4.5,
                        markerfacecolor=colour if whole else "white",
                    )  # fmt: skip
            panel.set_title(f"lower end {cuff}", fontsize=10)
            panel.set_xlabel("ease, %")
            panel.set_ylim(-3.0, 103.0)
            panel.grid(color=FAINT, linewidth=0.6)
        axes[0].set_ylabel("wires that lose a filament, %")
        axes[0].legend(fontsize=8)
        figure.savefig(path, dpi=150)


def drawn(count: int, seed: int) -> Iterator[Outcome]:
    """Yield the outcomes of random sleeves."""
    random = np.random.default_rng(seed)
    for _ in range(count):
        girth = random.uniform(220.0, 300.0)
        ends = [str(random.choice(CUFFS)) for _ in range(2)]
        changes = {
            "fabric.coarsening": 58.5,
            "body.joint_girth": round(girth, 1),
            "body.upper_girth": round(girth * random.uniform(1.0, 1.25), 1),
            "body.lower_girth": round(girth * random.uniform(0.7, 1.0), 1),
            "supports.ends": ends,
            "motion.flexion": round(random.uniform(40.0, 130.0), 1),
            "motion.steps": int(random.integers(6, 14)),
            "wires.every_warp_yarns": int(random.integers(80, 300)),
        }
        friction = float(random.choice([0.0, random.uniform(0.05, 0.5)]))
        yield run(changes, ease=round(random.uniform(-0.1, 0.2), 3), friction=round(friction, 3), cuff=" ".join(ends))


def main() -> None:
    """Print the table that was asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    verbs = parser.add_subparsers(dest="verb", required=True)
    grid = verbs.add_parser("designs", help="ease, friction and cuff of the elbow sleeve")
    grid.add_argument("--coarsening", type=float, default=52.0)
    grid.add_argument("--flexion", type=float, default=120.0)
    grid.add_argument("--folder", type=Path, help="for the table and the picture")
    chance = verbs.add_parser("random", help="random sleeves")
    chance.add_argument("--count", type=int, default=60)
    chance.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    print("  ease    mu      cuff    deg  damaged   open folded solves  /inc      s")
    found = []
    many = (
        designs(chosen.coarsening, chosen.flexion, chosen.folder)
        if chosen.verb == "designs"
        else drawn(chosen.count, chosen.seed)
    )
    for o in many:
        found.append(o)
        print(
            f"{o.ease:6.2f} {o.friction:5.2f} {o.cuff:>9} {o.reached_deg:6.1f} {o.damaged:8.1%} {o.interrupted:6.1%} "
            f"{o.folded:6.1%} {o.solves:6d} {o.solves / max(o.increments, 1):5.1f} {o.seconds:6.1f}  "
            f"{o.trouble or o.limits or 'ok'}",
            flush=True,
        )
    print(Counter("no equilibrium" if o.trouble else "limit passed" if o.limits else "ok" for o in found))
    if chosen.verb == "designs" and chosen.folder is not None:
        draw_designs(found, chosen.folder / "designs.png")


if __name__ == "__main__":
    main()
