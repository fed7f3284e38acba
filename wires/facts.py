"""What a report is made from besides the damage: plain facts of the case, the run, the solver and the wires."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from etextile.types import Array, BoolArray


@dataclass(frozen=True)
class CaseFacts:
    """Which case was run, on which fabric, with which body."""

    title: str
    sha256: str
    name: str = ""
    description: str = ""
    fabric: str = ""
    coarsening: float = 1.0
    size_mm: tuple[float, float] = (0.0, 0.0)
    portion: str = "whole"
    body: str = ""
    friction: float | str = 0.0
    effects: tuple[str, ...] = ()


@dataclass(frozen=True)
class RunCurves:
    """Curves over the S steps: travel, force, greatest engineering strain of each family, motion of the free edge.

    Of a worn case: flexion (deg), moment (N mm) and how far the ends slip along the limb.
    """

    displacement_mm: Array
    force_N: Array
    warp_max: Array
    weft_max: Array
    diagonal_max: Array
    draw_in_mm: Array
    """(S,) largest inward motion of the free edge."""

    def __post_init__(self) -> None:
        """Refuse curves of different length."""
        sizes = {name: np.shape(values) for name, values in vars(self).items()}
        if len(set(sizes.values())) > 1:
            raise ValueError(f"curves differ in length: {sizes}")


@dataclass(frozen=True)
class SolverFacts:
    """What the solution cost and how well it holds."""

    nodes: int
    trusses: int
    steps: int
    linear_solves: int
    cut_backs: int
    all_converged: bool
    wall_s: float
    solve_s: float
    max_penetration_mm: float
    energy_error: float
    linear: str = ""


@dataclass(frozen=True)
class WireFacts:
    """What the wires are made of, and the share of the warp stiffness of the coupons that is theirs."""

    material: str
    filaments: int
    filament_diameter_mm: float
    stiffness_share: float
    bond: str = "perfect"
    crimp: float | None = None


@dataclass(frozen=True)
class WornFacts:
    """What only a worn case has: blocks of the report for the joint, the skin and putting on; loops (L,) in folds."""

    joint: Mapping[str, Any]
    contact: Mapping[str, Any]
    donning: Mapping[str, Any] | None
    hold: Mapping[str, Any] | None
    folded: BoolArray
