"""Finalists: the best hypotheses simulated for themselves, on the finer lattice and for the fabric at hand.

Tables superpose effects, interpolate between parameters and come from the case's own lattice. For the finalists each of
these shortcuts is replaced by runs at the likeliest parameters (a Gauss-Newton step with the table's derivatives),
until the likeliest parameters stay where they are. Then every finalist is put to the tests that the verdict asks for.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from etextile.diagnose.fit import Evidence, Sample
from etextile.diagnose.gauss import Whitener
from etextile.diagnose.heldout import HeldOut, hold_out
from etextile.diagnose.library import Candidate, change, make_table, table_requests
from etextile.diagnose.localise import scan
from etextile.diagnose.observe import Record, observe
from etextile.diagnose.rank import Contender, Ranking, rejudged, with_rest
from etextile.diagnose.simulate import Runner
from etextile.diagnose.table import Table
from etextile.diagnose.verdict import Finalist
from etextile.diagnose.workbench import scale
from etextile.types import Array, BoolArray


if TYPE_CHECKING:
    from etextile.diagnose.workflow import Prepared, Setting

# Singles and pairs that are refitted, and the log scores behind the best at which they still are. Tables are coarse
# about effects that set in sharply, so the best singles are refitted whatever their score.
SINGLES, ALWAYS, PAIRS, DEPTH, PAIR_DEPTH = 3, 2, 2, 8.0, 4.0
ROUNDS = 2
# A likeliest point that moves by less than this share of its posterior deviation needs no further run.
STILL = 0.3
# A parameter sits at its bound when the likelihood still rises there by this much beyond it.
RISE = 3.0


@dataclass(frozen=True)
class Refit:
    """What refitting needs: setting, tables and runs, the runner, samples, form, columns of the free rest, split."""

    setting: Setting
    ready: Prepared
    runner: Runner
    samples: tuple[Sample, ...]
    form: Array
    free_columns: Array
    split: float
    seed: int

    def candidate(self, name: str) -> Candidate:
        """Return the candidate of that name."""
        return {item.card.id: item for item in self.setting.candidates}[name]


@dataclass(frozen=True)
class Refitted:
    """Contenders judged with tables that real runs have corrected."""

    tables: dict[str, Table]
    contenders: tuple[Contender, ...]


def refit(context: Refit, ranking: Ranking) -> Refitted:
    """Refit the best singles and pairs with real runs."""
    top = ranking.effects[0].score if ranking.effects else 0.0
    usable = [item for item in ranking.effects if np.isfinite(item.score)]
    singles = [item for item in usable if item.kind == "one"][:SINGLES]
    singles = [item for i, item in enumerate(singles) if i < ALWAYS or item.score > top - DEPTH]
    pairs = [item for item in usable if item.kind == "two" and item.score > top - PAIR_DEPTH][:PAIRS]
    tables = _refined(context, [*singles, *pairs], ranking)
    fits = {item.ids[0]: item for item in ranking.effects if item.kind == "one"}
    names = [item.ids[0] for item in singles]
    moving = names
    for _ in range(ROUNDS):
        tables = _corrected(context, tables, {name: fits[name] for name in moving})
        before = dict(fits)
        fits |= {name: rejudged(fits[name], context.samples, tables, context.form, offset=None) for name in moving}
        moving = [name for name in moving if _moved(before[name].evidence, fits[name].evidence)]
    moving_pairs, still = pairs, []
    for _ in range(ROUNDS):
        after = _with_interaction(context, tables, moving_pairs)
        changed = [_moved(a.evidence, b.evidence) for a, b in zip(moving_pairs, after, strict=True)]
        still += [item for item, moved in zip(after, changed, strict=True) if not moved]
        moving_pairs = [item for item, moved in zip(after, changed, strict=True) if moved]
    return Refitted(tables, (*(fits[name] for name in names), *still, *moving_pairs))


def _moved(before: Evidence, after: Evidence) -> bool:
    """Tell whether the likeliest point moved by more than `STILL` of its posterior deviation in any coordinate."""
    spread = np.sqrt(np.maximum(after.weights @ (after.points - after.mean) ** 2, 1e-12))
    return bool(np.any(np.abs(after.best - before.best) > STILL * spread))


def _refined(context: Refit, contenders: Sequence[Contender], ranking: Ranking) -> dict[str, Table]:
    """Return the tables with grid lines through the likeliest parameters of effects with two of them."""
    tables = dict(context.ready.tables)
    points: dict[str, list[Array]] = {}
    for item in contenders:
        start = 0
        for name in item.ids:
            size = len(tables[name].grid.axes)
            if size > 1:
                points.setdefault(name, []).append(item.evidence.best[start : start + size])
            start += size
    grids = {name: tables[name].grid.refined(at[0]) for name, at in points.items()}
    ready = context.ready
    requests = {
        name: table_requests(ready.levels, context.candidate(name), grid, ready.anchor) for name, grid in grids.items()
    }
    context.runner([request for group in requests.values() for request in group])
    for name, grid in grids.items():
        runs = context.runner(requests[name])
        tables[name] = make_table(
            grid, runs, ready.points, anchor=observe(ready.runs.anchor, ready.points), base=ready.lattice.value,
            thin=ready.bench.bins, tolerance=ready.bench.white,
        )  # fmt: skip
    return tables


def _simulated(context: Refit, contenders: Sequence[Contender], tables: Mapping[str, Table]) -> list[Array]:
    """Return the change (n,) of every contender at its likeliest parameters, on the finer lattice, by real runs."""
    ready, bench = context.ready, context.ready.bench
    reference = observe(ready.runs.fine, ready.points)
    return [
        bench.bins.average(change(ready.points, observe(run, ready.points), reference, ready.lattice.value))
        for run in simulated(context, contenders, tables)
    ]


def simulated(context: Refit, contenders: Sequence[Contender], tables: Mapping[str, Table]) -> list[Record]:
    """Return the run of every contender at its likeliest parameters, on the finer lattice with the fabric at hand."""
    ready = context.ready
    requests = []
    for item in contenders:
        specs, start = [], 0
        for name in item.ids:
            grid = tables[name].grid
            size = len(grid.axes)
            specs.append(context.candidate(name).spec(grid.parameters(item.evidence.best[start : start + size])))
            start += size
        requests.append(ready.levels.request(context.setting.base.laws, specs, coarsening=ready.levels.gate[0]))
    return context.runner(requests)


def _corrected(context: Refit, tables: dict[str, Table], fits: Mapping[str, Contender]) -> dict[str, Table]:
    """Return tables that give the simulated change at the likeliest parameters."""
    curves = _simulated(context, list(fits.values()), tables)
    found = dict(tables)
    for (name, item), curve in zip(fits.items(), curves, strict=True):
        if np.all(np.isfinite(curve)):
            found[name] = tables[name].corrected(item.evidence.best, curve)
    return found


def _with_interaction(context: Refit, tables: Mapping[str, Table], pairs: Sequence[Contender]) -> list[Contender]:
    """Return pairs judged with what their simulation has beyond the superposition of the tables."""
    pairs = [rejudged(item, context.samples, tables, context.form, offset=item.offset) for item in pairs]
    found = []
    for item, curve in zip(pairs, _simulated(context, pairs, tables), strict=True):
        offset = curve - superposed(item.evidence, [tables[name] for name in item.ids])
        usable = bool(np.all(np.isfinite(offset)))
        found.append(rejudged(item, context.samples, tables, context.form, offset=offset) if usable else item)
    return found


def superposed(evidence: Evidence, tables: Sequence[Table]) -> Array:
    """Return the superposed change (n,) at the likeliest parameters."""
    total, start = np.zeros(len(tables[0].basis)), 0
    for table in tables:
        size = len(table.grid.axes)
        total = total + table.curve(evidence.best[start : start + size])
        start += size
    return total


def finalists_of(
    context: Refit, ranking: Ranking, refitted: Refitted
) -> tuple[Ranking, dict[str, Table], tuple[Finalist, ...]]:
    """Return the final ranking, the tables behind it and the finalists with everything the verdict asks for."""
    coarse = ranking
    rests = [
        with_rest(item, context.samples, refitted.tables, context.form, context.free_columns)
        for item in sorted(refitted.contenders, key=lambda c: -c.score)[:2]
    ]
    ranking = ranking.replaced([*refitted.contenders, *rests])
    found = []
    for item in refitted.contenders:
        chosen = [refitted.tables[name] for name in item.ids]
        found.append(Finalist(
            item, ranking.including(*item.ids), _rest_p(context, item, chosen), _held_out(context, item, chosen),
            _at_bound(item, chosen), coarse.support(item.ids), ranking.support(item.ids),
        ))  # fmt: skip
    return ranking, refitted.tables, tuple(sorted(found, key=lambda f: -f.alone))


def _rest_p(context: Refit, item: Contender, tables: Sequence[Table]) -> float:
    """Return the chance that noise alone leaves what the hypothesis leaves, by the same scan as for the gap."""
    bench = context.ready.bench
    mean = superposed(item.evidence, tables) + (0.0 if item.offset is None else item.offset)
    columns = [_tangents(item.evidence, tables)]
    start = 0
    for table in tables:
        size = len(table.grid.axes)
        curve = table.curve(item.evidence.best[start : start + size])
        columns.append(0.10 * curve[:, None] * context.form)
        start += size
    freedom = np.concatenate(columns, axis=1)
    spread = freedom @ freedom.T
    whiteners = [Whitener.of(bench.covariance(s.scatter) + spread) for s in bench.scatters]
    weights = np.array([s.weight for s in bench.scatters])
    return scan(bench.points, bench.residual - mean, whiteners, weights, size=scale(bench), seed=context.seed).p_value


def _tangents(evidence: Evidence, tables: Sequence[Table]) -> Array:
    """Return the posterior's principal changes (n, d): what the parameters may still take up."""
    centre = evidence.mean
    spread = (evidence.points - centre) * np.sqrt(evidence.weights)[:, None]
    values, vectors = np.linalg.eigh(spread.T @ spread)
    columns = []
    base = _curve_at(tables, centre)
    for value, vector in zip(values, vectors.T, strict=True):
        step = np.sqrt(max(value, 0.0)) * vector
        columns.append(2.0 * (_curve_at(tables, centre + step) - base))
    return np.stack(columns, axis=1)


def _curve_at(tables: Sequence[Table], coordinates: Array) -> Array:
    total, start = np.zeros(len(tables[0].basis)), 0
    for table in tables:
        size = len(table.grid.axes)
        total = total + table.curve(coordinates[start : start + size])
        start += size
    return total


def _held_out(context: Refit, item: Contender, tables: Sequence[Table]) -> tuple[HeldOut, ...]:
    """Return the scores on displacements beyond the split and on every channel left out that has a gap."""
    bench = context.ready.bench
    beyond = bench.points.displacement > context.split
    parts: list[tuple[str, BoolArray]] = [(f"displacements beyond {context.split:.0f} mm", beyond)]
    channels = bench.points.channels
    if len(channels) > 1:
        parts += [(f"channel {channel}", bench.points.of(channel)) for channel in channels]
    deviation = np.sqrt(np.diag(bench.mean_covariance()))
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
