"""A rehearsal of what is a user's own in a case, before it is run: bodies, effects and criteria do what they will do.

The body is built and checked, effects change the model and what they add is asked once for its forces, the criterion
judges loops that are stretched. So a fault in a file of the user is found by `etextile check`, at its line.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from loadcases.schema import Case


if TYPE_CHECKING:
    from loadcases.build import Built

STRETCHED = (0.05, 0.2)
"""Strains of loops and wires that a criterion of the user's own is asked about."""


def rehearse(case: Case) -> None:
    """Build and try what is the user's own in a case; raises BadInput for what fails."""
    if case.failure.file is None and not own_parts(case):
        return
    from loadcases.build import build

    built = build(case)
    _ask_once(built)
    if case.failure.file is not None and built.wires is not None:
        _judge_once(built)


def own_parts(case: Case) -> bool:
    """Tell whether the body or an effect of a case is the user's own."""
    if case.body is not None and case.body.type == "own":
        return True
    if not case.effects:
        return False
    from etextile.effects.registry import EFFECTS

    return any("file" in item.parameters or item.id not in EFFECTS for item in case.effects)


def _ask_once(built: Built) -> None:
    """Ask every part of the model for its energy and its forces where the motion begins."""
    model = built.model
    x, forces = model.prescribed(model.begins), np.zeros_like(model.points)
    for part in model.contributions:
        trial = part.respond(x, model.begins, part.initial_state())
        trial.energy()
        trial.add_gradient(forces)


def _judge_once(built: Built) -> None:
    """Let the criterion judge loops and wires at a few strains."""
    from loadcases.judging import judge_for

    wires = built.wires
    if wires is None:
        return
    sizes = {"span_strain": wires.layout.n_loops, "wire_strain": wires.layout.n_loops, "element_strain": wires.count}
    strains = {name: np.repeat(np.array(STRETCHED)[:, None], size, axis=1) for name, size in sizes.items()}
    travel = np.linspace(0.0, built.case.motion.reach, 1 + len(STRETCHED))[1:]
    judge_for(built.case).judge(wires.history(travel, strains))
