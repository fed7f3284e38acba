"""The piece of a case as a bending tester holds it: free of clamps, body and load, with the fabric's own effects."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from etextile.errors import BadInput
from loadcases.build import build
from loadcases.fabric import Fabric
from loadcases.schema import Case


if TYPE_CHECKING:
    from etextile.effects.base import Effect
    from etextile.mechanics.model import Model


@dataclass(frozen=True)
class BentPiece:
    """A piece for pure bending; `left_out`: by id the effects that play no part in it, and why."""

    model: Model
    left_out: dict[str, str]

    def told(self, ids: Iterable[str]) -> tuple[str, ...]:
        """Return a sentence for each of these effects that plays no part."""
        return tuple(f"{name} plays no part in bending: {self.left_out[name]}" for name in ids if name in self.left_out)


def bent_piece(case: Case, effects: Iterable[Effect] = (), *, fabric: Fabric | None = None) -> BentPiece:
    """Return the piece of a flat case for pure bending; `effects` act beside the case's own.

    Effects on supports, body and machine play no part in it, nor do those that refuse a piece without clamps.
    """
    from etextile.effects.registry import build_effect

    model, left_out = _free(case, fabric), {}
    own = [build_effect(item.id, item.parameters) for item in case.effects]
    for effect in sorted((*own, *effects), key=lambda item: item.stage):
        try:
            model = _with(model, effect)
        except BadInput as error:
            left_out[effect.card.id] = error.problems[0].message
    return BentPiece(model, left_out)


def _with(model: Model, effect: Effect) -> Model:
    """Return the piece with an effect; raises BadInput where that has nothing to act on."""
    from etextile.effects.base import Stage

    if effect.stage >= Stage.SUPPORT:
        raise BadInput.of("nothing clamps the piece and no body presses it", key="id")
    return effect.apply(model)


def _free(case: Case, fabric: Fabric | None) -> Model:
    """Return the bare piece, held on its planes of symmetry alone."""
    motion = case.motion.model_copy(update={"target": "weight", "total": 1.0, "steps": 1, "path": None})
    bare = case.model_copy(update={"wires": None, "body": None, "effects": (), "motion": motion})
    model = build(bare, fabric=fabric).model
    fixed = np.zeros_like(model.fixed)
    for axis, cut in enumerate(model.lattice.symmetry):
        if cut:
            fixed[: len(model.lattice.points), axis] = model.lattice.points[:, axis] == 0.0
    return replace(model, fixed=fixed)
