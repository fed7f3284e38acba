"""Why a path found no equilibrium: where it stopped, the likely cause in the fabric, and what helps."""

from __future__ import annotations

import numpy as np

from etextile.mechanics.model import Model
from etextile.solve.newton import NewtonOutcome


SETTINGS = "more motion.steps or a larger solver.max_iterations"


def no_equilibrium(model: Model, outcome: NewtonOutcome, *, last: float, cut_backs: int) -> str:
    """Return the sentence for an increment without equilibrium; `last`: the last travel reached."""
    trial = outcome.trial
    worst = int(np.argmax(np.abs(trial.residual).max(axis=1)))
    place = ", ".join(f"{value:.1f}" for value in trial.x[worst])
    cause, remedy = _cause(model, outcome, last)
    return (
        f"no equilibrium at {trial.travel:.4g} {model.unit} after {cut_backs} cut-backs ({outcome.reason}, "
        f"residual {outcome.residual:.3g} N against {outcome.tolerance:.3g} N, worst at node {worst} at ({place}) mm); "
        f"the last converged increment is at {last:.4g} {model.unit}. {cause}Try {remedy}"
    )


def _cause(model: Model, outcome: NewtonOutcome, last: float) -> tuple[str, str]:
    """Return the likely cause as a sentence ('' when none is seen) and the remedy."""
    trial = outcome.trial
    giving = [response.giving_way for response in trial.responses if response.giving_way]
    rubs = any(getattr(part, "friction", 0.0) > 0.0 for part in model.contributions)
    friction = ", or a lower contact.friction" if rubs else ""
    if giving:
        said = f"Likely cause: {' and '.join(giving)}, so the test is unstable there. "
        return said, f"a shorter motion.total, or {SETTINGS}{friction}"
    if last == 0.0 and any(response.load is not None for response in trial.responses):
        said = "Likely cause: nothing holds the flat piece against the load, which falls to another place at once. "
        return said, "to hold opposite edges (supports.clamped), or effects: bending_stiffness"
    if trial.travel < last:
        said = "Likely cause: on the way back the fabric goes slack, and slack fabric can lie in many ways. "
        return said, f"to end the motion before it turns back, or {SETTINGS}{friction}"
    return "", SETTINGS + friction
