"""Finalists: the refitted hypotheses put to the tests that the verdict asks for.

Besides whether noise explains what they leave (`adequacy`): do they predict what they were not fitted to, do their
parameters stay inside of their physical range?
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from etextile.diagnose.adequacy import Settled, falsified
from etextile.diagnose.fit import Evidence
from etextile.diagnose.heldout import HeldOut, hold_out
from etextile.diagnose.rank import Contender, Ranking, with_rest
from etextile.diagnose.refit import Refit, Refitted
from etextile.diagnose.table import Table
from etextile.diagnose.verdict import Finalist
from etextile.types import BoolArray


# A parameter sits at its bound when the likelihood still rises there by this much beyond it.
RISE = 3.0


def finalists_of(
    context: Refit, ranking: Ranking, refitted: Refitted
) -> tuple[Ranking, dict[str, Table], tuple[Finalist, ...]]:
    """Return the final ranking, the tables behind it and the finalists with everything the verdict asks for."""
    coarse = ranking
    by_score = sorted(refitted.settled, key=lambda s: -s.contender.score)
    tables = {item.contender.ids: [refitted.tables[name] for name in item.contender.ids] for item in by_score}
    ruled_out = falsified(refitted.settled)
    rests = [
        with_rest(item.contender, item.bench, refitted.tables, context.form, context.free_columns)
        for item in [item for item in by_score if item.contender.ids not in ruled_out][:2]
    ]
    ranking = refitted.ranking.replaced(rests)
    found = []
    for settled in by_score:
        item = settled.contender
        chosen = tables[item.ids]
        found.append(Finalist(
            item, ranking.including(*item.ids), settled.rest_p, _held_out(context, settled, chosen),
            _at_bound(item, chosen), coarse.support(item.ids), ranking.support(item.ids), settled.simulated,
        ))  # fmt: skip
    return ranking, refitted.tables, tuple(sorted(found, key=lambda f: -f.alone))


def _held_out(context: Refit, settled: Settled, tables: Sequence[Table]) -> tuple[HeldOut, ...]:
    """Return the scores on displacements beyond the split and on every channel left out that has a gap."""
    item, bench = settled.contender, settled.bench
    beyond = bench.points.displacement > context.split
    parts: list[tuple[str, BoolArray]] = [(f"displacements beyond {context.split:.0f} mm", beyond)]
    channels = bench.points.channels
    if len(channels) > 1:
        parts += [(f"channel {channel}", bench.points.of(channel)) for channel in channels]
    deviation = np.sqrt(np.diag(context.ready.bench.mean_covariance))
    found = []
    for what, test in parts:
        if test.all() or not test.any():
            continue
        chi = float(np.sqrt(np.mean((bench.residual[test] / deviation[test]) ** 2)))
        if what.startswith("displacements") or chi > 2.0:
            found.append(hold_out(bench, tables, context.form, test, what=what, offset=item.offset))
    return tuple(found)


def _at_bound(item: Contender, tables: Sequence[Table]) -> tuple[str, ...]:
    """Return parameters whose likeliest value lies at the end of their range and would go beyond it if it could."""
    found, start = [], 0
    for table in tables:
        for k, axis in enumerate(table.grid.axes):
            low, high = axis.bounds
            value = item.evidence.best[start + k]
            if axis.neutral is not None and abs(value - axis.nodes[axis.neutral]) < 0.02 * (high - low):
                continue
            if value - low < 0.02 * (high - low) or high - value < 0.02 * (high - low):
                found.append((axis.parameter.name, start + k, low if value - low < high - value else high))
        start += len(table.grid.axes)
    return tuple(name for name, k, end in found if _rises(item.evidence, k, end))


def _rises(evidence: Evidence, dimension: int, end: float) -> bool:
    """Tell whether the likelihood, continued as a parabola beyond the end, would rise by more than `RISE`."""
    values = np.unique(np.round(evidence.points[:, dimension], 12))
    if len(values) < 3:
        return False
    profile = np.array([
        evidence.weights[np.isclose(evidence.points[:, dimension], value)].max(initial=0.0) for value in values
    ])  # fmt: skip
    near = np.argsort(np.abs(values - end))[:3]
    t, y = values[near] - end, np.log(np.maximum(profile[near], 1e-300))
    curvature, slope, _ = np.polyfit(t, y, 2)
    outward = slope if end >= values.max() - 1e-9 or end > values.mean() else -slope
    if outward <= 0.0:
        return False
    return bool(curvature >= 0.0 or outward**2 / (-4.0 * curvature) > RISE)
