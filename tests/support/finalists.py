"""Made-up hypotheses and finalists, for tests of what a verdict asks for."""

from __future__ import annotations

import numpy as np

from etextile.diagnose.decide.heldout import HeldOut
from etextile.diagnose.decide.rank import Contender, Kind
from etextile.diagnose.decide.verdict import Finalist
from etextile.diagnose.infer.fit import Evidence


def contender(kind: str, *ids: str, probability: float) -> Contender:
    score = float(np.log(probability))
    at = np.zeros((1, len(ids)))
    return Contender(Kind(kind), Evidence(ids, score, at[0], score, at, np.ones(1), kind in ("free", "rest")), 0.0)


def held_out(low: float = 0.8, high: float = 1.0) -> HeldOut:
    return HeldOut(
        "displacements beyond 30 mm",
        0.9,
        low,
        high,
        5.0,
        1.0,
        Evidence((), 0.0, np.zeros(0), 0.0, np.zeros((1, 0)), np.ones(1)),
    )


def finalist(item: Contender, probability: float) -> Finalist:
    return Finalist(item, probability, 0.4, (held_out(),), (), probability, probability)


SURE = contender("one", "clamp_slip", probability=0.97)
OTHER = contender("one", "yarn_tail", probability=0.02)
NOTHING = contender("none", probability=0.01)
