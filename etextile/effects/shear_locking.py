"""Fabric stiffens once the yarns have turned against each other by a locking angle.

Beyond it neighbouring yarns touch side by side. Per area of fabric the energy is K <|gamma| - gamma_0>^2 / 2 with the
shear angle gamma of the yarns at the corners of each lattice cell, elastic, on top of the diagonals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from etextile.effects.angles import FIRST_ARM, SECOND_ARM, AngleBlock, AngleResult, arm_lengths, corners
from etextile.effects.base import Card, Effect, Example, Parameter, Signature, Stage
from etextile.mechanics.model import Model
from etextile.mechanics.protocol import Energy
from etextile.types import Array


STEEPEST = 1.0 - 1e-9
"""Largest sine of the shear angle: the yarns lie on each other and the angle's derivative is singular."""


@dataclass(frozen=True)
class LockingPotential:
    """Quadratic in the shear angle beyond `onset` (rad), times `stiffness` (n,) N mm per corner."""

    stiffness: Array
    onset: float

    def initial_state(self) -> None:
        """Return nothing: locking is elastic."""

    def evaluate(self, cosine: Array, state: None) -> AngleResult:
        """Return energy and derivatives with respect to sin(gamma)."""
        sine = np.clip(cosine, -STEEPEST, STEEPEST)
        beyond = np.maximum(np.abs(np.arcsin(sine)) - self.onset, 0.0)
        flat = 1.0 - sine**2
        moment = self.stiffness * beyond
        curvature = np.where(beyond > 0.0, self.stiffness / flat, 0.0) + moment * np.abs(sine) / flat**1.5
        energy = 0.5 * float(moment @ beyond)
        return AngleResult(np.sign(sine) * moment / np.sqrt(flat), curvature, None, Energy(stored=energy))


@dataclass(frozen=True)
class ShearLocking(Effect):
    """Stiffness per area and angle squared beyond a locking angle."""

    stiffness: float = 0.0
    angle: float = 40.0

    stage: ClassVar[Stage] = Stage.ELEMENTS
    card: ClassVar[Card] = Card(
        id="shear_locking",
        mechanism="Shear stiffens beyond a locking angle, when yarns touch side by side.",
        parameters=(
            Parameter(
                "stiffness",
                "N/mm",
                0.0,
                200.0,
                "the moment per area and radian beyond the locking angle",
                limits=(0.0, 2000.0),
            ),
            Parameter("angle", "deg", 5.0, 80.0, "the angle from which on yarns lock", neutral=None, default=40.0),
        ),
        example=Example(
            {"stiffness": 20.0, "angle": 10.0}, (0.0, 0.1, 0.5, 1.0, 1.6), (-0.01, -0.05, -0.12, -0.38, -1.35)
        ),
        signature=(
            Signature("punch_force", 1, 20.0, "a little more, once cells towards the corners have locked"),
            Signature("free_edge", 0, 20.0, "the edge bends less sharply near the clamps"),
            Signature("tensile", 1, 0.0, "the bias curve stiffens at large angle, warp and weft do not"),
        ),
        confused_with=("rotational_shear",),
        separate="Bias coupons pulled beyond the locking angle.",
        literature="Prodromou and Chen, Composites A 28 (1997) 491; Cao et al., Composites A 39 (2008) 1037.",
    )

    def transform(self, model: Model) -> Model:
        """Return the model with locking springs at the corners of every cell."""
        nodes = corners(model.lattice.quads)
        warp, weft = arm_lengths(model.points, nodes)
        potential = LockingPotential(0.25 * self.stiffness * warp * weft, float(np.radians(self.angle)))
        return model.with_contribution(AngleBlock("shear locking", nodes, FIRST_ARM, SECOND_ARM, potential))
