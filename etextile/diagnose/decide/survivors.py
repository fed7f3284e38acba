"""The first look: which effects may play a part at all, so that no run is made which cannot change the verdict.

Every effect is first simulated at few of its parameters. Only those that come near the best alone, that show in what
one of the best leaves, or whose folds or lost runs make that a poor fit proves little, are simulated over their
whole grid, and on a finer lattice for what the lattice leaves open in them. All bounds are wide: what is left out here
is out by many orders of magnitude, and one that comes to the top later is still made up for.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from etextile.diagnose.decide.rank import VISIBLE, visible
from etextile.diagnose.infer.fit import FORM, Evidence, judge
from etextile.diagnose.infer.gauss import Whitener
from etextile.diagnose.infer.whitened import Workbench
from etextile.diagnose.predict.table import EffectTable
from etextile.types import Array


NEAR, FOLDING = 60.0, 300.0
"""Log evidence behind the best single effect up to which one survives, and one does that leaves folds undetermined or
could not be simulated at all its parameters."""
FEW = 140.0
"""How much farther behind one survives whose table stands on few nodes: more than twice what they were seen to miss."""
LEADERS, SHOWS = 3, 3.5
"""How many of the best single effects leave a rest in which another may show, by so many standard deviations."""


def survivors(
    bench: Workbench, tables: Mapping[str, EffectTable], form: Array, *, few: Collection[str] = ()
) -> tuple[str, ...]:
    """Return the effects that may play a part, in the order of the tables.

    `few`: those whose tables stand on few nodes; while there are any among the best, these alone are returned, since
    what they leave says little.
    """
    fits = _fits(bench, tables, form)
    leaders = _leaders(fits)
    rough = {name for name in leaders if name in few}
    if not leaders or rough:
        return tuple(name for name in tables if name in rough)
    best = fits[leaders[0]].log_evidence
    kept = {name for name, fit in fits.items() if fit.log_evidence >= best - _depth(tables[name], name in few)}
    for leader in leaders:
        change = tables[leader].curve(fits[leader].best)
        factors = FORM * form * change[:, None]
        whiten = Whitener.of(bench.mean_covariance + factors @ factors.T)
        own, rest = whiten(change), whiten(bench.residual - change)
        others = (name for name in fits if name not in kept)
        kept |= {name for name in others if _shows(whiten(tables[name].basis @ tables[name].amplitudes), own, rest)}
    return tuple(name for name in tables if name in kept)


def _fits(bench: Workbench, tables: Mapping[str, EffectTable], form: Array) -> dict[str, Evidence]:
    """Return the quick evidence of every effect that shows, by itself, the best first."""
    size = visible(tables, bench.mean_sample)
    seen = {name: table for name, table in tables.items() if size[name] >= VISIBLE}
    fits = {name: judge((bench.mean_sample,), (table,), form) for name, table in seen.items()}
    return dict(sorted(fits.items(), key=lambda item: -item[1].log_evidence))


def _leaders(fits: Mapping[str, Evidence]) -> list[str]:
    """Return the best single effects, from fits in falling order."""
    found = [name for name, fit in fits.items() if np.isfinite(fit.log_best)][:LEADERS]
    return [name for name in found if fits[name].log_evidence >= fits[found[0]].log_evidence - NEAR]


def _depth(table: EffectTable, few: bool) -> float:
    """Return how far behind the best an effect may be to survive."""
    proves_little = bool(table.grid.card.undetermined) or not np.all(table.valid)
    return (FOLDING if proves_little else NEAR) + (FEW if few else 0.0)


def _shows(curves: Array, own: Array, rest: Array) -> bool:
    """Tell whether one of an effect's changes (n, N) beside the leader's own (n,) answers to a rest (n,)."""
    unit = own / max(float(np.linalg.norm(own)), 1e-12)
    across = curves - unit[:, None] * (unit @ curves)
    norm = np.linalg.norm(across, axis=0)
    usable = norm > VISIBLE
    return bool(usable.any() and (across[:, usable].T @ rest / norm[usable]).max() > SHOWS)
