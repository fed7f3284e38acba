"""Tables of effects that let the fabric fold, made on a finer lattice.

Where the run that sizes an effect's doubt moves by more than noise hides and the card leaves folds undetermined, a
table of the case's own lattice misleads in more than size: coarse cells fold at other parameters, so the likeliest ones
come out far from those on the finer lattice (a ratio of 0.14 where 0.01 was hidden), and a refit that starts there does
not find its way back. Its doubt stays what it was until the refit knows better. Effects with two parameters keep their
tables: those would take dozens of long runs.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from etextile.diagnose.data.observe import observe
from etextile.diagnose.predict.run_tables import Candidate, change, table_requests
from etextile.diagnose.predict.simulate import Runner
from etextile.diagnose.predict.table import EffectTable, tabulate
from etextile.diagnose.setting import Prepared


def depends(table: EffectTable) -> bool:
    """Tell whether a table is to be made on a finer lattice: folds put it in doubt, and the runs are few."""
    return table.doubt is not None and bool(table.grid.card.undetermined) and len(table.grid.axes) == 1


def on_finer_lattice(ready: Prepared, candidate: Candidate, table: EffectTable, runner: Runner) -> EffectTable:
    """Return the table of one effect on the first lattice of the gate; nodes without equilibrium there stay."""
    level, grid = ready.levels.gate[0], table.grid
    wanted = [ready.levels.request(ready.anchor), *table_requests(ready.levels, candidate, grid, ready.anchor)]
    records = runner([replace(item, coarsening=level) for item in wanted])
    reference, *runs = (observe(record, ready.points) for record in records)
    curves = {}
    for (index, _), run in zip(grid.nodes(), runs, strict=True):
        curve = ready.bench.bins.average(change(ready.points, run, reference, ready.lattice.value))
        node = int(np.ravel_multi_index(index, grid.shape))
        if not np.all(np.isfinite(curve)) and table.valid[node]:
            curve = table.basis @ table.amplitudes[:, node]
        curves[index] = curve
    return replace(tabulate(grid, curves, ready.bench.white), doubt=table.doubt, loose=table.loose)
