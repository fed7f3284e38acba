"""A test of a hidden truth as the diagnosis gets it: specimens, scatter, noise, coupons, the files of one folder."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from solver import AREA, CELL, THICKNESS, Law


@dataclass
class Clean:
    """What is kept of a simulated truth: force over recorded displacement, and the free edge at material points."""

    displacement: np.ndarray
    force: np.ndarray
    warp0: np.ndarray
    edge: np.ndarray
    laws: np.ndarray


def clean(result, laws, warp0=(0.0, 6.0, 12.0, 18.0, 24.0, 30.0, 36.0, 42.0, 47.0)):
    """Reduce a result (steps, nodes) to the channels, with the flat start as first step."""
    lattice = result.lattice
    free = np.flatnonzero(lattice.line("free"))
    x = lattice.points[free, 0]
    warp0 = np.array(warp0)
    flat = np.stack([warp0, np.full_like(warp0, lattice.half[1]), np.zeros_like(warp0)], axis=1)
    edges = [flat]
    for positions in result.positions:
        own = positions[free]
        both = np.concatenate([own[:0:-1] * [-1.0, 1.0, 1.0], own])
        edges.append(CubicSpline(np.concatenate([-x[:0:-1], x]), both, axis=0)(warp0))
    start = result.travel[0] - (result.travel[1] - result.travel[0])
    return Clean(
        np.concatenate([[start], result.travel]),
        np.concatenate([[0.0], result.force]),
        warp0,
        np.array(edges),
        np.array(laws),
    )


def write(folder, truth, *, noise, seed, specimens=3, total=40.0, coupons=True, title="hidden"):
    """Write a folder of measurements of a `Clean` truth with noise level `noise` (relative) and specimen scatter."""
    rng = np.random.default_rng(seed)
    folder.mkdir(parents=True, exist_ok=True)
    lines = [f"title: {title}", "channels:"]
    at = np.arange(0.5, total + 1e-9, 0.5)
    force = CubicSpline(truth.displacement, truth.force)
    size = np.sqrt(np.mean(np.interp(at, truth.displacement, truth.force) ** 2))
    names = []
    for number in range(1, specimens + 1):
        gain, shift = 1.0 + noise * rng.standard_normal(), 5.0 * noise * rng.standard_normal()
        drift = 0.5 * noise * _smooth(rng, at / total)
        u = np.clip(at - shift, truth.displacement[0], truth.displacement[-1])
        clean_force = np.where(u > truth.displacement[0], force(u), 0.0)
        values = gain * clean_force * (1.0 + drift) + noise * size * rng.standard_normal(len(at))
        name = f"punch_{number}.csv"
        _csv(folder / name, "displacement_mm,force_N", [at, values], "%.3f,%.4f")
        names.append(name)
    lines.append(f"  punch_force: {{files: [{', '.join(names)}], noise: {noise * size:.4g} N}}")
    lines.append(_edge(folder, truth, rng, noise=noise, total=total))
    if coupons:
        lines += ["  tensile:", "    strain_from: specimen", *_coupons(folder, truth, rng, noise=noise)]
    (folder / "measured.yaml").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _smooth(rng, t):
    """A smooth random curve of unit size over t in 0..1."""
    return sum(rng.standard_normal() * np.cos(np.pi * k * t + rng.uniform(0, np.pi)) / k for k in (1, 2, 3)) / 1.17


def _edge(folder, truth, rng, *, noise, total):
    steps = np.arange(2.5, total + 1e-9, 2.5)
    points = CubicSpline(truth.displacement, truth.edge, axis=0)(np.maximum(steps, truth.displacement[0]))
    motion = points - truth.edge[0]
    sigma = noise * np.sqrt(np.mean((motion**2).sum(axis=2)))
    points = points + sigma * rng.standard_normal(points.shape)
    u, x = np.repeat(steps, len(truth.warp0)), np.tile(truth.warp0, len(steps))
    columns = [u, x, *points.reshape(-1, 3).T]
    _csv(
        folder / "free_edge.csv",
        "displacement_mm,warp0_mm,warp_mm,weft_mm,height_mm",
        columns,
        "%.3f,%.3f,%.4f,%.4f,%.4f",
    )
    return f"  free_edge: {{file: free_edge.csv, noise: {sigma:.4g} mm}}"


def _coupons(folder, truth, rng, *, noise, specimens=3):
    diagonal = np.hypot(*CELL)
    nominal = {"warp": CELL[1], "weft": CELL[0], "bias": CELL[0] * CELL[1] / diagonal}
    lines = []
    for (direction, width), numbers, top in zip(nominal.items(), truth.laws, (0.12, 0.12, 0.40), strict=True):
        law, names = Law(*numbers), []
        for number in range(1, specimens + 1):
            strain = np.concatenate([np.linspace(0.0, top, 70)[1:], np.linspace(top, 0.93 * top, 30)[1:]])
            stress = law.coupon(strain, 68) * AREA / (width * THICKNESS)
            values = stress * (1.0 + noise * rng.standard_normal())
            values = np.maximum(values + 0.3 * noise * stress.max() * rng.standard_normal(len(stress)), 0.0)
            name = f"tensile_{direction}_{number}.csv"
            _csv(folder / name, "strain,stress_MPa", [strain, values], "%.6f,%.5f")
            names.append(name)
        lines.append(f"    {direction}: [{', '.join(names)}]")
    return lines


def _csv(path, header, columns, form):
    rows = [form % row for row in zip(*columns, strict=True)]
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
