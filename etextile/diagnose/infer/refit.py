"""Refit: the best hypotheses simulated for themselves, on the finer lattice and for the fabric at hand.

Tables superpose effects, interpolate between parameters and come from the case's own lattice. For the best hypotheses
each of these shortcuts is replaced by runs at the likeliest parameters (a Gauss-Newton step with the table's
derivatives), until the likeliest parameters stay where they are, and what the lattice leaves open in them is settled
(`settle`). All others are judged again with the corrected tables; one that then comes to the top is refitted as well.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.diagnose.decide.classes import classes_of
from etextile.diagnose.decide.rank import VISIBLE, Contender, Kind, Ranking, rank_threes, rejudged, swapped
from etextile.diagnose.decide.residual_test import Settled, falsified, rest_p_value
from etextile.diagnose.decide.rivals import possible, widened
from etextile.diagnose.decide.survivors import NEAR
from etextile.diagnose.infer.full_table import tables_on, whole
from etextile.diagnose.infer.lattice_doubt import facing, left_open
from etextile.diagnose.infer.refit_pairs import HOPELESS, carried_over, settled_pairs
from etextile.diagnose.infer.refit_runs import ROUNDS, Refit, changes, moved, on_both
from etextile.diagnose.predict.table import EffectTable, each_with_its_own
from etextile.types import Array


# Singles and pairs that are refitted, and the log scores behind the best at which they still are. Tables are coarse
# about effects that set in sharply, so the best singles are refitted far behind the best, but not those that explain
# nothing by themselves: a table corrected at parameters that mean nothing misleads the pairs it takes part in.
SINGLES, ALWAYS, PAIRS, DEPTH, PAIR_DEPTH = 3, 2, 4, 8.0, 4.0
PASSES = 3


@dataclass(frozen=True)
class Refitted:
    """Hypotheses judged with tables that real runs have corrected, and the ranking of all with these tables."""

    tables: dict[str, EffectTable]
    settled: tuple[Settled, ...]
    ranking: Ranking


def refit(context: Refit, ranking: Ranking) -> Refitted:
    """Refit the best singles and pairs with real runs, and what comes to the top by that."""
    tables, done = dict(context.ready.tables), dict[tuple[str, ...], Settled]()
    corrected: set[str] = set()
    failed: set[tuple[str, ...]] = set()
    restless: set[tuple[str, ...]] = set()
    fresh = _leading(ranking, context.likely)
    for last in [*[False] * (PASSES - 1), True]:
        before = tables
        tables, fresh = _whole(context, tables, fresh)
        tables = _refined(context, tables, [item for item in fresh if not corrected & set(item.ids)])
        tables, singles = _singles(context, tables, [item for item in fresh if item.kind is Kind.ONE])
        tables, singles = _on_finest(context, tables, singles, failed)
        changed = {name for name, table in tables.items() if table is not before[name]}
        corrected |= {item.ids[0] for item in singles}
        again = [item.contender for ids, item in done.items() if len(ids) > 1 and changed & set(ids)]
        least = max((item.score for item in [*singles, *(item.contender for item in done.values())]), default=-np.inf)
        fresh = [item for item in fresh if item.kind is not Kind.ONE]
        kept = [carried_over(context, before, tables, item) for item in again if item.ids in restless]
        moving = [*(item for item in again if item.ids not in restless), *fresh]
        pairs = [*kept, *settled_pairs(context, tables, moving, failed, restless, least=least - HOPELESS)]
        done |= {item.ids: item for item in _checked(context, tables, [*singles, *pairs], failed)}
        others = [
            rejudged(item, context.ready.bench, tables, context.form, offset=None)
            for item in ranking.effects if item.ids not in done and changed & set(item.ids)
        ]  # fmt: skip
        ranking = ranking.replaced([*(item.contender for item in done.values()), *others])
        ranking = ranking.without(falsified(list(done.values())))
        if not last:
            ranking = ranking.replaced(_threes(context, tables, ranking))
        ranking, confused = _with_twins(context, tables, ranking)
        fresh = [item for item in possible(ranking, confused) if item.ids not in done][:PAIRS]
        if not fresh:
            break
    return Refitted(tables, tuple(done.values()), ranking)


def _with_twins(
    context: Refit, tables: Mapping[str, EffectTable], ranking: Ranking
) -> tuple[Ranking, dict[str, tuple[str, ...]]]:
    """Return the ranking with all rivals that these channels cannot tell from the leader, and what is confused."""
    confused = context.setting.confused
    if not ranking.effects or not set(ranking.effects[0].ids) <= set(context.visible):
        return ranking, confused
    leader, bench = ranking.effects[0], context.ready.bench
    seen = {name: tables[name] for name in context.visible}
    groups = classes_of(leader, bench, seen, context.form)
    known = {frozenset(item.ids) for item in ranking.effects}
    missing = [
        (own, *(other for other in others if frozenset({*leader.ids, other} - {own}) not in known))
        for own, *others in groups
    ]
    rivals = swapped(leader, missing, bench, seen, context.form)
    return ranking.replaced(rivals), widened(confused, groups)


def _threes(context: Refit, tables: Mapping[str, EffectTable], ranking: Ranking) -> list[Contender]:
    """Return sets of three around a pair that leads: evidence that grew with a second effect may grow with a third."""
    leader = ranking.effects[0] if ranking.effects else None
    if leader is None or leader.kind is not Kind.TWO or not set(leader.ids) <= set(context.visible):
        return []
    known = [set(item.ids) for item in ranking.effects]
    seen = {name: tables[name] for name in context.visible}
    found = rank_threes(context.ready.bench, leader.ids, seen, context.form, offset=leader.offset, doubt=leader.doubt)
    return [item for item in found if set(item.ids) not in known]


def _leading(ranking: Ranking, likely: Sequence[str]) -> list[Contender]:
    """Return the singles and pairs that are refitted first, all of effects that come into question."""
    usable = [item for item in ranking.effects if np.isfinite(item.score) and set(item.ids) <= set(likely)]
    top = usable[0].score if usable else 0.0
    singles = [item for item in usable if item.kind is Kind.ONE][:SINGLES]
    singles = [
        item for i, item in enumerate(singles)
        if item.score > top - DEPTH or (i < ALWAYS and item.score > singles[0].score - NEAR)
    ]  # fmt: skip
    return singles + [item for item in usable if item.kind is Kind.TWO and item.score > top - PAIR_DEPTH][:PAIRS]


def _whole(
    context: Refit, tables: dict[str, EffectTable], contenders: Sequence[Contender]
) -> tuple[dict[str, EffectTable], list[Contender]]:
    """Return whole tables for hypotheses that came up with tables on few nodes, and these judged with them."""
    ready = replace(context.ready, tables=tables)
    names = {name for item in contenders for name in item.ids} & ready.few
    if not names:
        return tables, list(contenders)
    tables = whole(ready, names, context.setting.candidates, context.runner).tables
    bench, form = ready.bench, context.form
    return tables, [rejudged(item, bench, tables, form, offset=item.offset) for item in contenders]


def _singles(
    context: Refit, tables: dict[str, EffectTable], contenders: Sequence[Contender]
) -> tuple[dict[str, EffectTable], list[Contender]]:
    """Correct the tables of single effects at their likeliest parameters until these stay."""
    fits = {item.ids[0]: item for item in contenders}
    moving = list(fits)
    for _ in range(ROUNDS):
        tables = _corrected(context, tables, {name: fits[name] for name in moving})
        before = dict(fits)
        fits |= {name: rejudged(fits[name], context.ready.bench, tables, context.form, offset=None) for name in moving}
        moving = [name for name in moving if moved(before[name].evidence, fits[name].evidence)]
    return tables, list(fits.values())


def _refined(
    context: Refit, tables: Mapping[str, EffectTable], contenders: Sequence[Contender]
) -> dict[str, EffectTable]:
    """Return tables with grid lines through the likeliest parameters of effects with two of them."""
    found = dict(tables)
    points: dict[str, Array] = {}
    for item in contenders:
        for table, own in each_with_its_own([tables[name] for name in item.ids], item.evidence.best):
            if len(own) > 1:
                points.setdefault(table.id, own)
    grids = {name: tables[name].grid.refined(at) for name, at in points.items()}
    refined = tables_on(context.ready, grids, context.setting.candidates, context.runner)
    for name, table in refined.items():
        found[name] = replace(table, doubt=tables[name].doubt, loose=tables[name].loose)
    return found


def _on_finest(
    context: Refit, tables: dict[str, EffectTable], singles: Sequence[Contender], failed: set[tuple[str, ...]]
) -> tuple[dict[str, EffectTable], list[Contender]]:
    """Return tables that give the change on the finest lattice, in doubt by how far it moved from the last.

    Hypotheses whose run there finds no equilibrium are added to `failed`.
    """
    ready, found = context.ready, dict(tables)
    for item, fine, finer in zip(singles, *on_both(context, singles, tables), strict=True):
        name = item.ids[0]
        if np.all(np.isfinite(finer - fine)):
            doubt = left_open(
                ready.bench.points, context.beyond * (finer - fine), [tables[name].grid.card], change=finer
            )
            found[name] = replace(_trusted(context, tables[name], item.evidence.best, finer), doubt=doubt)
        else:
            failed.add(item.ids)
    return found, [rejudged(item, ready.bench, found, context.form, offset=None) for item in singles]


def _checked(
    context: Refit, tables: Mapping[str, EffectTable], contenders: Sequence[Contender], failed: set[tuple[str, ...]]
) -> list[Settled]:
    """Return hypotheses with what they are judged by and whether noise explains what they leave."""
    found = []
    for item in contenders:
        chosen = [tables[name] for name in item.ids]
        bench = facing(context.ready.bench, chosen, item.doubt)
        p = rest_p_value(bench, item, chosen, context.form, seed=context.seed)
        found.append(Settled(item, bench, p, item.ids not in failed))
    return found


def _corrected(context: Refit, tables: dict[str, EffectTable], fits: Mapping[str, Contender]) -> dict[str, EffectTable]:
    """Return tables that give the simulated change at the likeliest parameters."""
    curves = changes(context, list(fits.values()), tables)
    found = dict(tables)
    for (name, item), curve in zip(fits.items(), curves, strict=True):
        if np.all(np.isfinite(curve)):
            found[name] = _trusted(context, tables[name], item.evidence.best, curve)
    return found


def _trusted(context: Refit, table: EffectTable, at: Array, curve: Array) -> EffectTable:
    """Return the table corrected at a point as far as the change there stands out of the noise.

    Elsewhere a correction grows in proportion to the effect, so that of a change within the noise is left out.
    """
    size = float(np.linalg.norm(context.ready.bench.mean_sample.whiten(curve))) / VISIBLE
    return table.corrected(at, curve, share=size**2 / (1.0 + size**2))
