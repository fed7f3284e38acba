"""Tables of effects on grids of one's choice, and whole ones for effects that come into question.

A table on few nodes tells an effect that is far from the measurement from one that is near it; the parameters and the
evidence of one that is near take all nodes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from etextile.diagnose.data.observe import observe
from etextile.diagnose.predict.run_tables import Candidate, make_table, table_requests
from etextile.diagnose.predict.simulate import Request, Runner
from etextile.diagnose.predict.table import EffectTable, ParameterGrid
from etextile.diagnose.setting import Prepared


def requests_on(
    ready: Prepared, grids: Mapping[str, ParameterGrid], candidates: Sequence[Candidate]
) -> list[Request]:  # fmt: skip
    """Return the runs behind tables of effects on these grids, effect by effect."""
    return [request for group in _requests(ready, grids, candidates).values() for request in group]


def tables_on(
    ready: Prepared, grids: Mapping[str, ParameterGrid], candidates: Sequence[Candidate], runner: Runner
) -> dict[str, EffectTable]:
    """Return tables of effects on these grids, by name; nothing is said yet of what the lattice leaves open."""
    requests = _requests(ready, grids, candidates)
    runner([request for group in requests.values() for request in group])
    anchor = observe(ready.runs.anchor, ready.points)
    return {
        name: make_table(
            grid, runner(requests[name]), ready.points, anchor=anchor, base=ready.lattice.value,
            thin=ready.bench.bins, tolerance=ready.bench.white,
        )
        for name, grid in grids.items()
    }  # fmt: skip


def whole(ready: Prepared, names: Iterable[str], candidates: Sequence[Candidate], runner: Runner) -> Prepared:
    """Return the prepared tables with those of the named effects on all nodes of their grids."""
    grids = {name: ready.plans[name] for name in names if name in ready.few}
    return replace(ready, tables=ready.tables | tables_on(ready, grids, candidates, runner))


def _requests(
    ready: Prepared, grids: Mapping[str, ParameterGrid], candidates: Sequence[Candidate]
) -> dict[str, list[Request]]:  # fmt: skip
    known = {item.card.id: item for item in candidates}
    return {name: table_requests(ready.levels, known[name], grid, ready.anchor) for name, grid in grids.items()}
