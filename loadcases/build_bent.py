"""The piece of a case as a bending tester holds it: free of clamps, body and load, with the fabric's own effects."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from etextile.errors import BadInput
from loadcases.build import build
from loadcases.fabric import Fabric
from loadcases.schema import Case


if TYPE_CHECKING:
    from etextile.effects.base import Effect
    from etextile.mechanics.model import Model


def bent_model(case: Case, effects: Iterable[Effect] = (), *, fabric: Fabric | None = None) -> Model:
    """Return the model of a flat case for pure bending; `effects` act beside the case's own.

    Effects on supports, body and machine play no part in it, nor do those that make no sense without clamps.
    """
    from etextile.effects.base import Stage
    from etextile.effects.registry import build_effect

    motion = case.motion.model_copy(update={"target": "weight", "total": 1.0, "steps": 1, "path": None})
    bare = case.model_copy(update={"wires": None, "body": None, "effects": (), "motion": motion})
    model = build(bare, fabric=fabric).model
    free = np.zeros_like(model.fixed)
    for axis, cut in enumerate(model.lattice.symmetry):
        if cut:
            free[: len(model.lattice.points), axis] = model.lattice.points[:, axis] == 0.0
    own = [build_effect(item.id, item.parameters) for item in case.effects]
    model = replace(model, fixed=free)
    for effect in sorted((*own, *effects), key=lambda item: item.stage):
        with suppress(BadInput):
            model = effect.apply(model) if effect.stage < Stage.SUPPORT else model
    return model
