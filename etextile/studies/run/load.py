"""What the report of a run says whose motion raises a load: pressure, height and volume, or how a strip hangs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from etextile.motion.diaphragm import Diaphragm
from etextile.motion.pressure import Pressure
from etextile.results.reader import Results
from etextile.types import Array
from loadcases.build import Built
from loadcases.schema import Case


EDGE_ANGLE = 41.5
"""Angle below the horizontal to which a strip is let down in a cantilever test, deg (ASTM D1388, option A)."""


def is_load(built: Built) -> bool:
    """Tell whether the travel of a run is a load and no displacement."""
    return built.case.motion.target in ("pressure", "weight")


def deflection(results: Results, built: Built) -> Array:
    """Return the largest motion along the load over the steps (S,), mm: height of a bulge, drop of a strip."""
    along = built.model.direction
    nodes = len(built.model.lattice.points)
    start = built.model.lattice.points @ along
    return np.array(
        [float((results.points(step)[:nodes] @ along - start).max()) for step in range(results.steps)]
    )  # fmt: skip


def load_block(results: Results, built: Built) -> dict[str, Any]:
    """Return the block of report.json that belongs to the motion, named `pressure` or `weight`; {} for others."""
    target = built.case.motion.target
    if target == "pressure":
        return {"pressure": pressure_block(results, built)}
    if target == "weight":
        return {"weight": weight_block(results, built)}
    return {}


def pressure_block(results: Results, built: Built) -> dict[str, Any]:
    """Return pressure (bar), height (mm) and volume (mm3) of the whole specimen over the steps.

    With a diaphragm also its pressure at the same height, and what the gauge shows: both together, bar.
    """
    gas = next(part for part in built.model.contributions if isinstance(part, Pressure))
    factor = built.model.lattice.multiplicity
    pressure, height = results.displacement_mm, deflection(results, built)
    block = {
        "pressure_bar": pressure,
        "height_mm": height,
        "volume_mm3": np.array([factor * gas.volume(results.points(step)) for step in range(results.steps)]),
    }
    rubber = diaphragm_of(built.case)
    if rubber is not None:
        taken = rubber.at(height)
        block |= {"diaphragm_bar": taken, "gauge_bar": pressure + taken, "diaphragm_known_to_mm": rubber.height[-1]}
    return block


def load_note(report: Mapping[str, Any]) -> str | None:
    """Return that a bulge goes higher than its diaphragm was measured; None where it does not."""
    block = report.get("pressure", {})
    known = block.get("diaphragm_known_to_mm")
    if known is None or max(block["height_mm"], default=0.0) <= known:
        return None
    return f"the diaphragm was measured up to {known:.4g} mm; beyond that its pressure goes on with its last slope"


def diaphragm_of(case: Case) -> Diaphragm | None:
    """Return the diaphragm of a case, None without one."""
    curve = case.motion.diaphragm_curve
    return None if curve is None else Diaphragm(*np.array(curve, dtype=float).T)


def weight_block(results: Results, built: Built) -> dict[str, Any]:
    """Return mass per area (g/m2), drop (mm) and angle (deg) of the far edge below the held one over the steps.

    `at_standard_angle`: mass per area at which the angle is 41.5 deg, and the stiffness w (L / 2)^3 (N mm) that the
    standard reads from it (Peirce); null when the strip does not come down so far.
    """
    lattice = built.model.lattice
    points = lattice.points
    edges = built.case.supports.edges
    axis = 0 if {"x_min", "x_max"} & set(edges) else 1
    held = float(np.mean([points[lattice.edges[name], axis].mean() for name in edges if name[0] == "xy"[axis]]))
    far = np.abs(points[:, axis] - held) > np.abs(points[:, axis] - held).max() - 1e-9
    mass = results.displacement_mm
    ends = [results.points(step)[: len(points)][far].mean(axis=0) for step in range(results.steps)]
    drop = np.array([-end[2] for end in ends])
    reach = np.array([abs(end[axis] - held) for end in ends])
    angle = np.degrees(np.arctan2(drop, reach))
    return {
        "mass_g_m2": mass,
        "drop_mm": drop,
        "angle_deg": angle,
        "overhang_mm": float(np.abs(points[:, axis] - held).max()),
        "at_standard_angle": _standard(mass, angle, float(np.abs(points[:, axis] - held).max())),
    }


def _standard(mass: Array, angle: Array, length: float) -> dict[str, float] | None:
    """Return mass at the standard angle and the stiffness that Peirce's rule gives there."""
    from etextile.motion.weight import GRAVITY

    rises = np.concatenate([[0.0], angle])
    if not rises.max() >= EDGE_ANGLE or np.any(np.diff(rises) < 0.0):
        return None
    found = float(np.interp(EDGE_ANGLE, rises, np.concatenate([[0.0], mass])))
    return {"mass_g_m2": found, "peirce_stiffness_Nmm": GRAVITY * found * (0.5 * length) ** 3}
