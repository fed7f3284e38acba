"""Real runs of hypotheses at their likeliest parameters, on the gate lattices, with the fabric at hand."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import compress

import numpy as np

from etextile.diagnose.data.observe import Record, observe
from etextile.diagnose.decide.rank import Contender
from etextile.diagnose.infer.fit import Evidence
from etextile.diagnose.predict.run_tables import change, specs_at
from etextile.diagnose.predict.simulate import Runner
from etextile.diagnose.predict.table import EffectTable
from etextile.diagnose.setting import Prepared, Setting
from etextile.types import Array


ROUNDS = 4
"""Runs at parameters that move before they are taken as they are."""
STILL = 0.3
"""A likeliest point that moves by less than this share of its posterior deviation needs no further run."""


@dataclass(frozen=True)
class Refit:
    """What refitting needs: setting, tables and runs, the runner, form, columns of free rests, split.

    `visible`: effects that these channels can show; `likely`: those that come into question (`survivors`).
    """

    setting: Setting
    ready: Prepared
    runner: Runner
    form: Array
    rests: tuple[Array, ...]
    split: float
    seed: int
    visible: tuple[str, ...]
    likely: tuple[str, ...]

    @property
    def beyond(self) -> float:
        """What is missing from the finest lattice to the limit, as a share of how far a change moved to it."""
        coarse, fine = (run.cell**2 for run in (self.ready.runs.fine, self.ready.runs.finer))
        return float(fine / (coarse - fine))


def changes(
    context: Refit, contenders: Sequence[Contender], tables: Mapping[str, EffectTable], *, finest: bool = False
) -> list[Array]:
    """Return the change (n,) of every contender at its likeliest parameters on a gate lattice, by real runs."""
    ready, bench = context.ready, context.ready.bench
    reference = observe(ready.runs.finer if finest else ready.runs.fine, ready.points)
    return [
        bench.bins.average(change(ready.points, observe(run, ready.points), reference, ready.lattice.value))
        for run in simulated(context, contenders, tables, finest=finest)
    ]


def on_both(
    context: Refit, contenders: Sequence[Contender], tables: Mapping[str, EffectTable],
    *, wanted: Collection[tuple[str, ...]] = (),
) -> tuple[list[Array], list[Array]]:  # fmt: skip
    """Return the changes (n,) on both gate lattices; nan on the finest where there is none on the other.

    A run that was lost on one lattice takes longest on a finer one, where it would say nothing alone; `wanted` names
    hypotheses that are run there all the same.
    """
    fine = changes(context, contenders, tables)
    last = [
        item.ids in wanted or bool(np.all(np.isfinite(curve))) for item, curve in zip(contenders, fine, strict=True)
    ]
    runs = iter(changes(context, list(compress(contenders, last)), tables, finest=True))
    return fine, [next(runs) if ran else np.full_like(curve, np.nan) for ran, curve in zip(last, fine, strict=True)]


def simulated(
    context: Refit, contenders: Sequence[Contender], tables: Mapping[str, EffectTable], *, finest: bool = False
) -> list[Record]:
    """Return the run of every contender at its likeliest parameters, on a gate lattice with the fabric at hand.

    On the finest, where a verdict hangs on it, a run is not given up as early as those of the tables.
    """
    level = context.ready.levels.gate[1 if finest else 0]
    candidates, laws = context.setting.candidates, context.setting.base.laws
    requests = [
        context.ready.levels.request(
            laws, specs_at([tables[name] for name in item.ids], candidates, item.evidence.best), coarsening=level
        )
        for item in contenders
    ]
    found = context.runner(requests)
    lost = [i for i, run in enumerate(found) if finest and not run.completed]
    for i, run in zip(lost, context.runner([replace(requests[i], patient=True) for i in lost]), strict=True):
        found[i] = run
    return found


def moved(before: Evidence, after: Evidence) -> bool:
    """Tell whether the likeliest point moved by more than `STILL` of its posterior deviation in any coordinate."""
    spread = np.sqrt(np.maximum(after.weights @ (after.points - after.mean) ** 2, 1e-12))
    return bool(np.any(np.abs(after.best - before.best) > STILL * spread))
