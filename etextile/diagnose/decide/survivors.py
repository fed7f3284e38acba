"""The first look: which effects may play a part at all, so that no run is made which cannot change the verdict.

What the lattice leaves open in an effect takes a run on a finer lattice each, half of all processor time when every
effect gets one. Only those get it that come near the best alone, that show in what one of the best leaves, or whose
fold the lattice moves so much that a poor fit proves little. All bounds are wide: what is left out here is out by many
orders of magnitude.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from etextile.diagnose.decide.rank import VISIBLE, visible
from etextile.diagnose.infer.fit import FORM, judge
from etextile.diagnose.infer.gauss import Whitener
from etextile.diagnose.infer.whitened import Workbench
from etextile.diagnose.predict.table import EffectTable
from etextile.types import Array


NEAR, FOLDING = 60.0, 300.0
"""Log evidence behind the best single effect up to which one survives, and one that leaves folds undetermined does."""
LEADERS, SHOWS = 3, 3.5
"""How many of the best single effects leave a rest in which another may show, by so many standard deviations."""


def survivors(bench: Workbench, tables: Mapping[str, EffectTable], form: Array) -> tuple[str, ...]:
    """Return the effects that may play a part, in the order of the tables."""
    size = visible(tables, bench.mean_sample)
    seen = {name: table for name, table in tables.items() if size[name] >= VISIBLE}
    fits = {name: judge((bench.mean_sample,), (table,), form) for name, table in seen.items()}
    order = sorted(fits, key=lambda name: -fits[name].log_evidence)
    if not order:
        return ()
    best = fits[order[0]].log_evidence
    kept = {
        name for name, fit in fits.items()
        if fit.log_evidence >= best - (FOLDING if seen[name].grid.card.undetermined else NEAR)
    }  # fmt: skip
    for leader in (name for name in order[:LEADERS] if fits[name].log_evidence >= best - NEAR):
        if not np.isfinite(fits[leader].log_best):
            continue
        change = seen[leader].curve(fits[leader].best)
        factors = FORM * form * change[:, None]
        whiten = Whitener.of(bench.mean_covariance + factors @ factors.T)
        own, rest = whiten(change), whiten(bench.residual - change)
        others = (name for name in seen if name not in kept)
        kept |= {name for name in others if _shows(whiten(seen[name].basis @ seen[name].amplitudes), own, rest)}
    return tuple(name for name in tables if name in kept)


def _shows(curves: Array, own: Array, rest: Array) -> bool:
    """Tell whether one of an effect's changes (n, N) beside the leader's own (n,) answers to a rest (n,)."""
    unit = own / max(float(np.linalg.norm(own)), 1e-12)
    across = curves - unit[:, None] * (unit @ curves)
    norm = np.linalg.norm(across, axis=0)
    usable = norm > VISIBLE
    return bool(usable.any() and (across[:, usable].T @ rest / norm[usable]).max() > SHOWS)
