"""What a record keeps of a worn piece: moments instead of forces, the straight limb as its start, slip on the skin."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from etextile.diagnose.data.surface import Surface
from etextile.mechanics.model import Model
from etextile.motion.flexion import Cuffs, Flexion
from etextile.solve.path import Increment
from etextile.types import Array


def flexion_of(model: Model) -> Flexion | None:
    """Return the motion of the joint that a model is worn on, None for a flat piece."""
    return model.guide.motion if isinstance(model.guide, Cuffs) else None


def straight(model: Model, increments: Sequence[Increment]) -> tuple[Array, float]:
    """Return positions (N, 3) and moment (N mm) on the straight limb, where the flexion begins."""
    before = [item for item in increments if item.displacement_mm <= 0.0]
    count = len(model.lattice.points)
    if not before:
        return model.points[:count], 0.0
    return before[-1].positions[:count], float(np.degrees(before[-1].state.force_onward)) * model.force_factor


def slips(motion: Flexion, positions: Array, angle: Array) -> Array:
    """Return how far nodes at positions (S, N, 3) have slipped along the skin since the first step, (S, N) mm."""
    places = np.stack([motion.along(points, float(at)) for points, at in zip(positions, angle, strict=True)])
    return np.asarray(places - places[0])


def worn_surface(surface: Surface, model: Model, motion: Flexion, increments: Sequence[Increment]) -> Surface:
    """Return the surface of a worn piece with the straight limb as its first step, and its slip."""
    start, moment = straight(model, increments)
    flat = model.lattice.points
    moved, force = surface.motion.copy(), surface.force.copy()
    moved[0], force[0] = start - flat, np.radians(moment)
    return replace(surface, motion=moved, force=force, slip=slips(motion, flat + moved, surface.load))
