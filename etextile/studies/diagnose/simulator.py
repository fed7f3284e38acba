"""The simulator behind a diagnosis: a case, run with other laws, effects and lattices than it was written with."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from etextile.diagnose.data.observe import Record
from etextile.diagnose.predict.simulate import (
    LONGER,
    TABLE,
    VERDICT,
    EffectSpec,
    Law,
    Patience,
    Request,
    run_model,
)
from loadcases.schema import Case


if TYPE_CHECKING:
    from etextile.effects.base import Effect
    from etextile.mechanics.model import Model


@dataclass(frozen=True)
class CaseSimulator:
    """Runs requests on a case without wires: the coupons contained them, so the fabric laws carry their share."""

    case: Case
    fingerprint: str

    def __call__(self, request: Request) -> Record:
        """Return the record of one run; effects of the request act together with the case's own."""
        from etextile.effects.registry import apply_effects, build_effect
        from loadcases.build import build, settings

        if request.bent:
            return _bent(self.case, request)
        case = _reduced(self.case, request)
        own = [build_effect(item.id, item.parameters) for item in self.case.effects]
        model = _with_laws(build(case).model, request.laws)
        return run_model(
            apply_effects(model, [*own, *map(_built, request.effects)]),
            settings(case),
            patience=_patience(request),
            back=request.back is not None,
        )


def _patience(request: Request) -> Patience | None:
    """Return when a run is given up; None for never, without effects."""
    if not request.effects:
        return None
    return VERDICT.within(request.solves, times=LONGER) if request.patient else TABLE.within(request.solves)


def _bent(case: Case, request: Request) -> Record:
    """Return the record of a bending test; the laws of the trusses play no part in it."""
    from etextile.diagnose.predict.bent import bent_record
    from loadcases.build_bent import bent_piece

    fabric = case.fabric.model_copy(update={"coarsening": request.coarsening})
    piece = bent_piece(case.model_copy(update={"fabric": fabric}), map(_built, request.effects))
    return bent_record(piece.model, request.total * np.arange(1, request.steps + 1) / request.steps)


def _built(item: EffectSpec) -> Effect:
    from etextile.effects.registry import build_effect

    return build_effect(item.id, {**dict(item.parameters), **({"file": item.file} if item.file else {})})


def _reduced(case: Case, request: Request) -> Case:
    """Return the case of a request without wires and effects."""
    path = request.stations or (None if request.back is None else (request.total, request.back))
    motion = case.motion.straight(request.total, request.steps, path)
    changes = {
        "wires": None,
        "fabric": case.fabric.model_copy(update={"coarsening": request.coarsening}),
        "motion": case.motion.model_copy(update=motion),
        "effects": (),
    }
    return case.model_copy(update=changes)


def _with_laws(model: Model, laws: tuple[Law, Law, Law]) -> Model:
    """Return the model with other numbers in the laws of warp, weft and diagonals."""
    block = model.lattice_block
    changed = tuple(
        replace(law, E=E, sigma_y0=sigma_y0, H=H, n=n)
        for law, (E, sigma_y0, H, n) in zip(block.laws, laws, strict=True)
    )
    other = replace(block, laws=changed)
    return replace(model, contributions=tuple(other if part is block else part for part in model.contributions))
