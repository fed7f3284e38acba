"""What commands wrote beside a solver that shares nothing with the package: forces, places of nodes, own laws.

    python tests/benchmarks/own_solutions.py [names of rows]

Each row runs `etextile run punch` with an effect, reads force and displacements from the result file with h5py, and
solves the same piece of fabric with the solver of the gauntlet (numpy and scipy, laws as tables, contact by a stiff
penalty, friction that grips over a short slip). Coupons cut at an angle stand beside a continuous sheet (`own_sheet`).
The rows are those of the validation page of claims; about three minutes.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np


sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "workflow" / "gauntlet"))

from mechanisms import Truth, simulate
from own_sheet import Sheet
from scipy.stats import norm
from solver import MID, PATTERNS, Ball, Lattice, Law, Trusses, march


TOTAL, STEPS, CELLS = 36.0, 18, (9, 16)
DEPTHS = (20.0, 28.0, 36.0)
COMMON = (
    "wires=null", f"motion.total={TOTAL} mm", f"motion.steps={STEPS}", "outputs.maps=[]",
    "contact.max_penetration=0.002 mm",
)  # fmt: skip


@dataclass(frozen=True)
class Row:
    """Changes of the case, and what is hidden in the independent solver."""

    changes: tuple[str, ...] = ()
    effects: dict[str, dict[str, float]] = field(default_factory=dict)
    form: str = "same"


def effect(name: str, form: str = "same", **numbers: float) -> Row:
    inside = ", ".join(f"{key}: {value}" for key, value in numbers.items())
    return Row((f"effects=[{{id: {name}, {inside}}}]",), {name: numbers}, form)


ROWS = {
    "nothing": Row(),
    "compression_ratio 1": Row(("fabric.compression_ratio=1",), {"compression_carry": {"ratio": 1.0}}),
    "compression_carry 0.04": effect("compression_carry", ratio=0.04),
    "yarn_tail": effect("yarn_tail", slope_change=-0.65, onset=0.11),
    "geometry, radius -1.5 mm": effect("geometry", radius=-1.5),
    "yarn_sliding": effect("yarn_sliding", limit=0.18),
    "friction 0.2": Row(("contact.friction=0.2",), {"punch_friction": {"mu": 0.2}}),
    "friction 0.5": Row(("contact.friction=0.5",), {"punch_friction": {"mu": 0.5}}),
    "clamp_compliance, mount": effect("clamp_compliance", compliance=0.04),
    "clamp_compliance, mount in one piece": effect("clamp_compliance", "piece", compliance=0.04),
}


def run(case: str, changes: tuple[str, ...], folder: Path) -> dict[str, Any]:
    """Run a case as a user does and return its report."""
    sets = [part for change in changes for part in ("--set", change)]
    command = [sys.executable, "-m", "etextile", "run", case, "-o", str(folder), *sets, "--quiet", "--force"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 4):
        raise RuntimeError(done.stderr[-1000:])
    return json.loads((folder / "report.json").read_text(encoding="utf-8"))


def written(row: Row, folder: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Travel (S,) mm, force (S,) N, flat points (N, 3) and places (S, N, 3) that `etextile run` wrote."""
    run("punch", (*COMMON, *row.changes), folder)
    with h5py.File(folder / "results.vtkhdf") as file:
        own = file["etextile"]
        flat = own["lattice/reference"][()]
        moved = file["VTKHDF/PointData/displacement"][()].reshape(-1, len(flat), 3)
        travel = np.atleast_1d(file["VTKHDF/Steps/Values"][()])
        increments = own["increments"]
        at, force = increments["travel_mm"][()], increments["punch_force_N"][()]
        ended = increments["converged"][()].astype(bool)
    return travel, np.interp(travel, at[ended], force[ended]), flat, flat + moved


def beside_the_lattice(name: str, row: Row) -> None:
    """Print forces at three depths of the product and of the independent solver, and how far nodes lie apart."""
    with tempfile.TemporaryDirectory() as folder:
        travel, force, flat, places = written(row, Path(folder) / "out")
    own = simulate(Truth(row.effects, cells=CELLS, form=row.form, total=TOTAL, steps=STEPS))
    order = np.lexsort((own.lattice.points[:, 1].round(6), own.lattice.points[:, 0].round(6)))
    theirs = np.lexsort((flat[:, 1].round(6), flat[:, 0].round(6)))
    pairs = [(float(np.interp(d, travel, force)), float(np.interp(d, own.travel, own.force))) for d in DEPTHS]
    apart = np.linalg.norm(places[-1][theirs] - own.positions[-1][order], axis=1)
    print(
        f"{name:40}" + "   ".join(f"{a:7.1f} /{b:7.1f} ({100 * (a / b - 1):+.2f} %)" for a, b in pairs)
        + f"   nodes apart {np.median(apart):.3f} mm in the middle, {apart.max():.3f} at most",
        flush=True,
    )  # fmt: skip


def continued(numbers: tuple[float, ...], *, onset: float, factor: float) -> Law:
    """A law whose slope is `factor` times its own beyond the engineering strain it was identified to."""
    plain = Law(*numbers)
    start = float(np.interp(np.log1p(onset), plain.total, plain.p))
    at = float(np.interp(start, plain.p, plain.undamaged))
    return Law(*numbers, change=lambda p, s: np.where(p > start, at + factor * (s - at), s))


def pushed(laws: list[Law], total: float, steps: int) -> tuple[Lattice, np.ndarray, np.ndarray]:
    """The lattice, forces (S,) and places (S, N, 3) of a punch without friction, by the independent solver."""
    PATTERNS.clear()
    lattice = Lattice.quarter(*CELLS)
    fixed = np.zeros_like(lattice.points, dtype=bool)
    fixed[lattice.line("clamp")] = True
    fixed[lattice.line("x0"), 0] = True
    fixed[lattice.line("y0"), 1] = True
    ball = Ball(lattice)
    travels = np.linspace(0.0, total, steps + 1)[1:]
    force, places, _ = march(lattice.points, fixed, [Trusses(lattice, tuple(laws)), ball], ball, travels)
    return lattice, force, places


def spans(lattice: Lattice, places: np.ndarray, loops: np.ndarray) -> np.ndarray:
    """Greatest strain (L,) so far of lines along the warp; loops (L, 3): from, to, weft place; bilinear in cells."""
    nx, ny = lattice.nx, lattice.ny
    hx, hy = lattice.half[0] / nx, lattice.half[1] / ny
    found = np.zeros(len(loops))
    for x in places:
        grid = x.reshape(nx + 1, ny + 1, 3)
        for number, (first, last, weft) in enumerate(loops):
            k = min(int(weft / hy), ny - 1)
            line = grid[:, k] + (weft / hy - k) * (grid[:, k + 1] - grid[:, k])
            stops = np.unique(np.clip([first, *np.arange(nx + 1) * hx, last], first, last))
            at = np.stack([np.interp(stops, np.arange(nx + 1) * hx, line[:, c]) for c in range(3)], axis=1)
            length = np.linalg.norm(np.diff(at, axis=0), axis=1).sum()
            found[number] = max(found[number], length / (last - first) - 1.0)
    return found


def beyond_the_range() -> None:
    """Print forces and verdicts of loops under the low and high continuation of all laws, product and own."""
    with tempfile.TemporaryDirectory() as folder:
        report = run("punch", ("outputs.maps=[]",), Path(folder) / "out")
        with h5py.File(Path(folder) / "out" / "results.vtkhdf") as file:
            wires = file["etextile/wires"]
            loops = np.stack(
                [wires["loop_exit_mm"][()], wires["loop_entry_mm"][()], wires["weft_mm"][()][wires["loop_wire"][()]]], 1
            )
            wire, index = wires["loop_wire"][()], wires["loop_index"][()]
    said = report["extrapolation"]
    numbers = {key: item["value"] for key, item in report["failure"]["parameters"].items()}
    limits = report["reliability"]["limits"]
    # onsets of loops in numbers: all filaments of a loop are gone with the mean of share^N over them
    onsets = numbers["onset"] + numbers["scatter"] * norm.ppf((np.arange(2000) + 0.5) / 2000)
    loops[:, :2] = np.maximum(loops[:, :2], 0.0)
    own = {}
    for way in ("tangent", "low", "high"):
        factor = 1.0 if way == "tangent" else said["warp"][way]
        laws = [
            continued(law, onset=said[family]["identified_to"], factor=factor)
            for law, family in zip(MID, ("warp", "weft", "diagonal"), strict=True)
        ]
        lattice, force, places = pushed(laws, 52.5, 42)
        strain = spans(lattice, places, loops)
        broken = norm.cdf((strain - numbers["onset"]) / numbers["scatter"])
        over = np.maximum(strain[:, None] - onsets, 0.0) / numbers["scale"]
        opened = ((-np.expm1(-(over ** numbers["shape"]))) ** numbers["filaments"]).mean(axis=1)
        own[way] = np.where(
            opened >= limits["open_from"], "interrupted", np.where(broken < limits["whole_below"], "whole", "damaged")
        )
        theirs = report["punch"]["force_N"][-1] if way == "tangent" else said["continuations"][way]["force_N"]
        print(f"laws as they are or {way:8} force at 52.5 mm {theirs:8.1f} / {force[-1]:8.1f} N", flush=True)
    flips = {(int(wire[k]), int(index[k])) for k in np.flatnonzero(own["low"] != own["high"])}
    reported = {(item["wire"], item["loop"]): (item["low"], item["high"]) for item in said["verdicts_that_hang_on_it"]}
    print(f"loops open to the law: product {sorted(reported)}, own {sorted(flips)}")
    for k in range(len(loops)):
        key = (int(wire[k]), int(index[k]))
        if key in reported:
            print(f"  {key}: product {reported[key]}, own {(str(own['low'][k]), str(own['high'][k]))}")


def cut_coupon() -> None:
    """Print the force of a coupon cut at 45 degrees whose yarns carry compression: lattice and continuous sheet."""
    sheet = Sheet((60.0, 29.0), 30, 15, angle=45.0, shares=(1.0, 1.0, 0.0, 0.0)).pulled(np.linspace(1.2, 16.8, 14))
    for coarsening in (6, 3):
        with tempfile.TemporaryDirectory() as folder:
            run("bias_extension", (f"fabric.coarsening={coarsening}", "outputs.maps=[]"), Path(folder) / "out")
            table = np.genfromtxt(Path(folder) / "out" / "force_displacement.csv", delimiter=",", names=True)
        text = ", ".join(
            f"{table['force_N'][k]:.1f} / {sheet[k]:.1f} ({100 * (table['force_N'][k] / sheet[k] - 1):+.1f} %)"
            for k in (4, 9, 13)
        )
        print(f"bias_extension at coarsening {coarsening}, 10, 20, 28 %: {text} N", flush=True)


FURTHER = {"laws beyond their range": beyond_the_range, "cut coupon": cut_coupon}


def main(names: list[str]) -> None:
    """Print the rows whose names hold one of `names`; all without any."""
    print(f"force, N: product / own at {', '.join(f'{d:g}' for d in DEPTHS)} mm")
    for name, row in ROWS.items():
        if not names or any(part in name for part in names):
            beside_the_lattice(name, row)
    for name, work in FURTHER.items():
        if not names or any(part in name for part in names):
            work()


if __name__ == "__main__":
    main(sys.argv[1:])
