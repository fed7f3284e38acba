"""Finalists: the refitted hypotheses put to the tests that the verdict asks for.

Besides whether noise explains what they leave (`adequacy`): do they predict what they were not fitted to, do their
parameters stay inside of their physical range, do the effects move the force as their cards say?
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from etextile.diagnose.decide.heldout import HeldOut, beyond_words, hold_out, is_beyond
from etextile.diagnose.decide.rank import VISIBLE, Contender, Ranking, with_rest
from etextile.diagnose.decide.residual_test import Settled, falsified
from etextile.diagnose.decide.signature import undeclared
from etextile.diagnose.decide.verdict import Finalist
from etextile.diagnose.infer.fit import Evidence
from etextile.diagnose.infer.integrate import parabola
from etextile.diagnose.infer.refit import Refitted
from etextile.diagnose.infer.refit_runs import Refit
from etextile.diagnose.predict.table import EffectTable, ParameterAxis, each_with_its_own
from etextile.types import BoolArray


# A parameter sits at its bound when the likelihood still rises there by this much beyond it.
RISE = 3.0


def finalists_of(
    context: Refit, ranking: Ranking, refitted: Refitted, beside: Sequence[Contender] = ()
) -> tuple[Ranking, dict[str, EffectTable], tuple[Finalist, ...]]:
    """Return the final ranking, the tables behind it and the finalists with everything the verdict asks for.

    `beside`: hypotheses of no effect that compete, such as faults of the test.
    """
    coarse = ranking
    by_score = sorted(refitted.settled, key=lambda s: -s.contender.score)
    tables = {item.contender.ids: [refitted.tables[name] for name in item.contender.ids] for item in by_score}
    ruled_out = falsified(refitted.settled)
    rests = [
        with_rest(item.contender, item.bench, refitted.tables, context.form, context.rests)
        for item in [item for item in by_score if item.contender.ids not in ruled_out][:2]
    ]
    ranking = refitted.ranking.replaced([*rests, *beside])
    faint = {item.ids: _faint(context, item.contender, refitted.tables) for item in by_score}
    found = []
    for settled in by_score:
        item = settled.contender
        chosen = tables[item.ids]
        found.append(Finalist(
            item, ranking.including(*item.ids), settled.rest_p, _held_out(context, settled, chosen),
            tuple(axis.parameter.name for _, axis, _ in ends(item, refitted.tables)), coarse.support(item.ids),
            ranking.support(item.ids, faint), settled.simulated, faint[item.ids],
            _undeclared(context, item, refitted.tables),
        ))  # fmt: skip
    return ranking, refitted.tables, tuple(sorted(found, key=lambda f: -f.alone))


def _held_out(context: Refit, settled: Settled, tables: Sequence[EffectTable]) -> tuple[HeldOut, ...]:
    """Return the scores on displacements beyond the split and on every channel left out that has a gap."""
    item, bench = settled.contender, settled.bench
    beyond = bench.points.displacement > context.split
    parts: list[tuple[str, BoolArray]] = [(beyond_words(context.split, bench.points.unit), beyond)]
    channels = bench.points.channels
    if len(channels) > 1:
        parts += [(f"channel {channel}", bench.points.of(channel)) for channel in channels]
    deviation = np.sqrt(np.diag(context.ready.bench.mean_covariance))
    found = []
    for what, test in parts:
        if test.all() or not test.any():
            continue
        chi = float(np.sqrt(np.mean((bench.residual[test] / deviation[test]) ** 2)))
        if is_beyond(what) or chi > 2.0:
            found.append(hold_out(bench, tables, context.form, test, what=what, offset=item.offset))
    return tuple(found)


def _undeclared(context: Refit, item: Contender, tables: Mapping[str, EffectTable]) -> tuple[str, ...]:
    """Return the effects that, at the likeliest parameters, do not do to the force what their card declares."""
    return tuple(table.id for table, at in item.parts(tables) if undeclared(context.ready.bench, table, at))


def _faint(context: Refit, item: Contender, tables: Mapping[str, EffectTable]) -> tuple[str, ...]:
    """Return the effects whose own change, at the likeliest parameters, noise and fabric could hide."""
    whiten = context.ready.bench.mean_sample.whiten
    return tuple(table.id for table, at in item.parts(tables) if np.linalg.norm(whiten(table.curve(at))) < VISIBLE)


def ends(item: Contender, tables: Mapping[str, EffectTable]) -> Iterator[tuple[EffectTable, ParameterAxis, float]]:
    """Yield the axes whose likeliest value lies at the end of their range and would go beyond it if it could.

    With the table of the effect and that end as a value of the parameter. The ends of a form are the forms there are.
    """
    best = item.evidence.best
    for table, dimensions in each_with_its_own([tables[name] for name in item.ids], np.arange(len(best))):
        for axis, dimension in zip(table.grid.axes, dimensions, strict=True):
            low, high = axis.bounds
            value, close = best[dimension], 0.02 * (high - low)
            if axis.parameter.form or axis.parameter.choice:
                continue
            if axis.neutral is not None and abs(value - axis.nodes[axis.neutral]) < close:
                continue
            end = low if value - low < high - value else high
            if abs(value - end) < close and _rises(item.evidence, dimension, end):
                yield table, axis, float(axis.to_value(end))


def _rises(evidence: Evidence, dimension: int, end: float) -> bool:
    """Tell whether the likelihood, continued as a parabola beyond the end, would rise by more than `RISE`."""
    if evidence.log_likelihood is None:
        return False
    shape = parabola(evidence.points, evidence.log_likelihood)
    if shape is None:
        return True
    centre, hessian = shape
    beyond = centre[dimension] - end
    if np.sign(beyond) != np.sign(end - evidence.points[:, dimension].mean()):
        return False
    return bool(0.5 * beyond**2 / np.linalg.inv(-hessian)[dimension, dimension] > RISE)
