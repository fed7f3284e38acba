"""Make the measurement that a diagnosis asks for: `python again.py TRUTH FOLDER [--noise 0.01] [--form other]`.

FOLDER is the `next` of a diagnosis: its measured.yaml says which test is wanted, its CSV files are filled with what the
independent solver says of the hidden truth TRUTH, with specimen scatter and noise as in the first test.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from ruamel.yaml import YAML
from scipy.interpolate import CubicSpline, RegularGridInterpolator


sys.path.insert(0, str(Path(__file__).parent))

from measure import _csv, _edge, _smooth, clean
from mechanisms import simulate
from truths import truths


DOWN_TO = 0.6


def answer(truth, folder, *, noise, seed):
    """Fill the files of a folder with a test of a truth."""
    spec = YAML(typ="safe").load((folder / "measured.yaml").read_text(encoding="utf-8"))["tests"][-1]
    rng = np.random.default_rng(seed)
    other = asked(truth, spec)
    result = simulate(other)
    ((channel, entry),) = spec["channels"].items()
    if channel in ("punch_force", "punch_unloading"):
        forces(folder, entry["files"], result, rng, noise=noise, total=truth.total, back=other.back)
    elif channel == "free_edge":
        _edge(folder, clean(result, truth.laws), rng, noise=noise, total=truth.total)
        (folder / "free_edge.csv").rename(folder / entry["file"])
    elif channel == "strain_field":
        strains(folder / entry["file"], result, rng, total=truth.total)
    else:
        slips(folder / entry["file"], result, rng, total=truth.total)


def asked(truth, spec):
    """Return the truth in the test that is asked for."""
    case, changes = spec.get("case", {}), {}
    if "body.radius" in case:
        changes["radius"] = float(str(case["body.radius"]).split()[0])
    if "motion.speed" in case:
        changes["speed"] = float(str(case["motion.speed"]).split()[0])
    if "punch_unloading" in spec["channels"]:
        changes["back"] = DOWN_TO * truth.total
    effects = {name: own for name, own in truth.effects.items() if name not in spec.get("without", ())}
    return replace(truth, effects=effects, **changes)


def forces(folder, names, result, rng, *, noise, total, back):
    """Write force curves of specimens, of the way back alone where there is one."""
    travel, force = np.concatenate([[0.0], result.travel]), np.concatenate([[0.0], result.force])
    top = int(np.argmax(travel))
    if back is None:
        at, there = np.arange(0.5, total + 1e-9, 0.5), CubicSpline(travel[: top + 1], force[: top + 1])
        at = at[at <= travel[top]]
    else:
        at = np.arange(travel[top], back - 1e-9, -0.25)
        at, there = at[at >= travel[-1]], CubicSpline(travel[top:][::-1], force[top:][::-1])
    size = np.sqrt(np.mean(there(at) ** 2))
    for name in names:
        gain, shift = 1.0 + noise * rng.standard_normal(), 5.0 * noise * rng.standard_normal()
        drift = 0.5 * noise * _smooth(rng, at / total)
        u = np.clip(at - shift, min(travel[0], at.min()), travel[top])
        values = gain * there(u) * (1.0 + drift) + noise * size * rng.standard_normal(len(at))
        _csv(folder / name, "displacement_mm,force_N", [at, values], "%.3f,%.4f")


def strains(path, result, rng, *, total, sigma=0.003):
    """Write engineering strains of warp and weft segments at ordinary places of a quarter."""
    lattice = result.lattice
    x, y = (np.unique(np.round(lattice.points[:, k], 9)) for k in (0, 1))
    shape = (len(x), len(y), 3)
    order = np.lexsort((lattice.points[:, 1], lattice.points[:, 0]))
    flat = lattice.points[order].reshape(shape)
    rows = []
    fields = {"warp": [], "weft": []}
    for positions in (lattice.points, *result.positions):
        grid = positions[order].reshape(shape)
        fields["warp"].append(np.linalg.norm(np.diff(grid, axis=0), axis=2) / np.diff(flat[:, :1, 0], axis=0) - 1.0)
        fields["weft"].append(np.linalg.norm(np.diff(grid, axis=1), axis=2) / np.diff(flat[:1, :, 1], axis=1) - 1.0)
    travel = np.concatenate([[0.0], result.travel])
    mx, my = 0.5 * (x[1:] + x[:-1]), 0.5 * (y[1:] + y[:-1])
    warp = RegularGridInterpolator((travel, mx, y), np.array(fields["warp"]))
    weft = RegularGridInterpolator((travel, x, my), np.array(fields["weft"]))
    for u in total * np.array([0.25, 0.5, 0.75, 1.0]):
        for a in x[-1] * np.array([0.05, 0.25, 0.5, 0.75, 0.95]):
            for b in y[-1] * np.array([0.05, 0.25, 0.5, 0.75, 0.95]):
                at = min(u, travel[-1])
                first = float(warp([[at, np.clip(a, mx[0], mx[-1]), np.clip(b, y[0], y[-1])]])[0])
                second = float(weft([[at, np.clip(a, x[0], x[-1]), np.clip(b, my[0], my[-1])]])[0])
                rows.append((u, a, b, *(np.array([first, second]) + sigma * rng.standard_normal(2))))
    columns = np.array(rows).T
    header = "displacement_mm,warp0_mm,weft0_mm,strain_warp,strain_weft"
    _csv(path, header, columns, "%.3f,%.3f,%.3f,%.6f,%.6f")


def slips(path, result, rng, *, total, sigma=0.1):
    """Write the motion of the fabric out of the clamp at ordinary places of the clamp line."""
    lattice = result.lattice
    own = np.flatnonzero(lattice.line("clamp"))
    y = lattice.points[own, 1]
    order = np.argsort(y)
    own, y = own[order], y[order]
    travel = np.concatenate([[0.0], result.travel])
    moved = [np.zeros(len(own))]
    moved += [np.linalg.norm(positions[own] - lattice.points[own], axis=1) for positions in result.positions]
    table = RegularGridInterpolator((travel, y), np.array(moved))
    rows = [
        (u, b, float(table([[min(u, travel[-1]), b]])[0]) + sigma * rng.standard_normal())
        for u in total * np.array([0.25, 0.5, 0.75, 1.0])
        for b in y[-1] * np.array([0.02, 0.25, 0.5, 0.75, 0.95])
    ]
    _csv(path, "displacement_mm,weft0_mm,slip_mm", np.array(rows).T, "%.3f,%.3f,%.4f")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("truth")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--noise", type=float, default=0.01)
    parser.add_argument("--form", default="other", choices=("other", "same"))
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    answer(truths(options.form)[options.truth], options.folder, noise=options.noise, seed=options.seed)


if __name__ == "__main__":
    main()
