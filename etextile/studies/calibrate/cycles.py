"""Runs of a trial along a path there and back, read at the places of a measured record."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from etextile.errors import NoEquilibrium
from etextile.solve.path import advance
from etextile.types import Array
from loadcases.build import build, settings, travel_points
from loadcases.fabric import Fabric
from loadcases.schema import Case


LEAST_STEPS = 6
"""Output steps of a branch at least."""


@dataclass(frozen=True)
class Cycle:
    """Way travelled (S,) mm along a path, and the force (S,) N, the start included."""

    travelled: Array
    force: Array


def run_cycle(case: Case, fabric: Fabric, path: tuple[float, ...]) -> Cycle | None:
    """Return the run of a case along a path from 0 on, None when it finds no equilibrium."""
    motion = case.motion.model_copy(update={"total": max(path), "path": None, "history": None})
    spacing = float(np.diff(travel_points(case), prepend=0.0).max())
    turns = (0.0, *path)
    branches = [
        np.linspace(start, end, max(LEAST_STEPS, int(np.ceil(abs(end - start) / spacing - 1e-9))) + 1)[1:]
        for start, end in pairwise(turns)
    ]
    case = case.model_copy(update={"motion": motion})
    model = replace(build(case, fabric=fabric).model, travel=np.concatenate(branches))
    try:
        steps = [(item.displacement_mm, item.punch_force_N) for item in advance(model, settings(case)) if item.output]
    except NoEquilibrium:
        return None
    place, force = np.array([(0.0, 0.0), *steps]).T
    return Cycle(np.concatenate([[0.0], np.cumsum(np.abs(np.diff(place)))]), force)


def along_path(cycle: Cycle | None, path: tuple[float, ...], travelled: Array) -> Array:
    """Return the forces (n,) of a run at places (n,) of its path: monotone cubics that end where it turns."""
    from scipy.interpolate import PchipInterpolator

    found = np.full(len(travelled), np.nan)
    if cycle is None:
        return found
    ends = np.concatenate([[0.0], np.cumsum(np.abs(np.diff([0.0, *path])))])
    for low, high in pairwise(ends):
        steps = (cycle.travelled >= low - 1e-9) & (cycle.travelled <= high + 1e-9)
        own = (travelled >= low) & (travelled <= high)
        found[own] = PchipInterpolator(cycle.travelled[steps], cycle.force[steps])(travelled[own])
    return found
