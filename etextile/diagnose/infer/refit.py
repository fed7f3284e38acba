"""Refit: the best hypotheses simulated for themselves, on the finer lattice and for the fabric at hand.

Tables superpose effects, interpolate between parameters and come from the case's own lattice. For the best hypotheses
each of these shortcuts is replaced by runs at the likeliest parameters (a Gauss-Newton step with the table's
derivatives), until the likeliest parameters stay where they are, and what the lattice leaves open in them is settled
(`settle`). All others are judged again with the corrected tables; one that then comes to the top is refitted as well.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import compress

import numpy as np

from etextile.diagnose.data.observe import Record, observe
from etextile.diagnose.decide.classes import classes_of
from etextile.diagnose.decide.rank import VISIBLE, Contender, Kind, Ranking, rank_threes, rejudged, swapped
from etextile.diagnose.decide.residual_test import Settled, falsified, rest_p_value
from etextile.diagnose.decide.rivals import possible, widened
from etextile.diagnose.decide.survivors import NEAR
from etextile.diagnose.infer.fit import Evidence
from etextile.diagnose.infer.full_table import tables_on, whole
from etextile.diagnose.infer.lattice_doubt import facing, left_open
from etextile.diagnose.predict.run_tables import change, specs_at
from etextile.diagnose.predict.simulate import Runner
from etextile.diagnose.predict.table import EffectTable, each_with_its_own, superposed
from etextile.diagnose.setting import Prepared, Setting
from etextile.types import Array


# Singles and pairs that are refitted, and the log scores behind the best at which they still are. Tables are coarse
# about effects that set in sharply, so the best singles are refitted far behind the best, but not those that explain
# nothing by themselves: a table corrected at parameters that mean nothing misleads the pairs it takes part in.
SINGLES, ALWAYS, PAIRS, DEPTH, PAIR_DEPTH = 3, 2, 4, 8.0, 4.0
ROUNDS, PASSES = 4, 3
# Log score behind the best at which the runs on the finest lattice are left out. More than `adequacy.BEHIND`, so that
# whatever can be named or can rule out a leader has been there.
HOPELESS = 14.0
# A likeliest point that moves by less than this share of its posterior deviation needs no further run.
STILL = 0.3


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
        kept = [_carried_over(context, before, tables, item) for item in again if item.ids in restless]
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
        moving = [name for name in moving if _moved(before[name].evidence, fits[name].evidence)]
    return tables, list(fits.values())


def settled_pairs(
    context: Refit, tables: Mapping[str, EffectTable], pairs: Sequence[Contender], failed: set[tuple[str, ...]],
    restless: set[tuple[str, ...]], *, least: float,
) -> list[Contender]:  # fmt: skip
    """Judge pairs with their simulated interaction until their likeliest parameters stay.

    Those whose parameters do not are added to `restless`.

    At last on the finest lattice, but for those below the score `least` or far behind the best: a run is long there.
    """
    moving, still = list(pairs), []
    runs: dict[tuple[str, ...], list[Array]] = {item.ids: [] for item in pairs}
    for _ in range(ROUNDS):
        after = _with_interaction(context, tables, moving)
        for item, now in zip(moving, after, strict=True):
            runs[item.ids] += [now.offset] if now.offset is not None and now.offset is not item.offset else []
        changed = [_moved(a.evidence, b.evidence) for a, b in zip(moving, after, strict=True)]
        still += [item for item, moved in zip(after, changed, strict=True) if not moved]
        moving = [item for item, moved in zip(after, changed, strict=True) if moved]
    jumping = {item.ids: runs[item.ids] for item in moving if len(runs[item.ids]) > 1}
    restless |= set(jumping)
    found = [*still, *(averaged(context, tables, item, jumping.get(item.ids, ())) for item in moving)]
    least = max([least, *(item.score - HOPELESS for item in found)])
    near = [item for item in found if item.score > least]
    return [
        *(item for item in found if item.score <= least),
        *_pairs_on_finest(context, tables, near, failed, jumping),
    ]


def _carried_over(
    context: Refit, before: Mapping[str, EffectTable], tables: Mapping[str, EffectTable], item: Contender
) -> Contender:  # fmt: skip
    """Return a pair whose runs jump judged with other tables: further runs of it would say no more."""
    if item.offset is None:
        return item
    old, new = (superposed([of[name] for name in item.ids], item.evidence.best) for of in (before, tables))
    return rejudged(item, context.ready.bench, tables, context.form, offset=item.offset + old - new)


def averaged(
    context: Refit, tables: Mapping[str, EffectTable], item: Contender, offsets: Sequence[Array]
) -> Contender:  # fmt: skip
    """Return a pair judged by the mean of its runs, offsets (n,) beyond the tables, in doubt by their scatter.

    The change by fabric that folds jumps from run to run as it folds in another way, so that likeliest parameters do
    not stay: no single run says more than another.
    """
    if len(offsets) < 2:
        return item
    every = np.stack(offsets)
    return _in_doubt(context, tables, item, every.mean(axis=0), every.std(axis=0, ddof=1))


def _in_doubt(
    context: Refit, tables: Mapping[str, EffectTable], item: Contender, offset: Array, moved: Array
) -> Contender:  # fmt: skip
    """Return a pair judged with an offset (n,), in doubt as a whole by how far its change moves from run to run."""
    chosen = [tables[name] for name in item.ids]
    if np.all(np.isfinite(moved)):
        change = superposed(chosen, item.evidence.best) + offset
        cards = [table.grid.card for table in chosen]
        item = replace(item, doubt=left_open(context.ready.bench.points, moved, cards, change=change))
    return rejudged(item, context.ready.bench, tables, context.form, offset=offset)


def _moved(before: Evidence, after: Evidence) -> bool:
    """Tell whether the likeliest point moved by more than `STILL` of its posterior deviation in any coordinate."""
    spread = np.sqrt(np.maximum(after.weights @ (after.points - after.mean) ** 2, 1e-12))
    return bool(np.any(np.abs(after.best - before.best) > STILL * spread))


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
    for item, fine, finer in zip(singles, *_on_both(context, singles, tables), strict=True):
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


def _simulated(
    context: Refit, contenders: Sequence[Contender], tables: Mapping[str, EffectTable], *, finest: bool = False
) -> list[Array]:
    """Return the change (n,) of every contender at its likeliest parameters on a gate lattice, by real runs."""
    ready, bench = context.ready, context.ready.bench
    reference = observe(ready.runs.finer if finest else ready.runs.fine, ready.points)
    return [
        bench.bins.average(change(ready.points, observe(run, ready.points), reference, ready.lattice.value))
        for run in simulated(context, contenders, tables, finest=finest)
    ]


def _on_both(
    context: Refit, contenders: Sequence[Contender], tables: Mapping[str, EffectTable],
    *, wanted: Collection[tuple[str, ...]] = (),
) -> tuple[list[Array], list[Array]]:  # fmt: skip
    """Return the changes (n,) on both gate lattices; nan on the finest where there is none on the other.

    A run that was lost on one lattice takes longest on a finer one, where it would say nothing alone; `wanted` names
    hypotheses that are run there all the same.
    """
    fine = _simulated(context, contenders, tables)
    last = [
        item.ids in wanted or bool(np.all(np.isfinite(curve))) for item, curve in zip(contenders, fine, strict=True)
    ]
    runs = iter(_simulated(context, list(compress(contenders, last)), tables, finest=True))
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


def _corrected(context: Refit, tables: dict[str, EffectTable], fits: Mapping[str, Contender]) -> dict[str, EffectTable]:
    """Return tables that give the simulated change at the likeliest parameters."""
    curves = _simulated(context, list(fits.values()), tables)
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


def _with_interaction(
    context: Refit, tables: Mapping[str, EffectTable], pairs: Sequence[Contender]
) -> list[Contender]:  # fmt: skip
    """Return pairs judged with what their simulation has beyond the superposition of the tables."""
    pairs = [rejudged(item, context.ready.bench, tables, context.form, offset=item.offset) for item in pairs]
    curves = _simulated(context, pairs, tables)
    return [_offset_by(context, tables, item, curve) for item, curve in zip(pairs, curves, strict=True)]


def _offset_by(
    context: Refit, tables: Mapping[str, EffectTable], item: Contender, curve: Array
) -> Contender:  # fmt: skip
    """Return a pair judged with its simulated change (n,); as it is without one."""
    if not np.all(np.isfinite(curve)):
        return item
    offset = curve - superposed([tables[name] for name in item.ids], item.evidence.best)
    return rejudged(item, context.ready.bench, tables, context.form, offset=offset)


def _pairs_on_finest(
    context: Refit, tables: Mapping[str, EffectTable], pairs: Sequence[Contender], failed: set[tuple[str, ...]],
    jumping: Mapping[tuple[str, ...], Sequence[Array]],
) -> list[Contender]:  # fmt: skip
    """Return pairs judged with their change on the finest lattice, in doubt by how far it moved as a whole.

    `jumping`: offsets (n,) of those whose parameters did not stay, which are averaged. `failed` then holds those whose
    run on the finest lattice finds no equilibrium.
    """
    ready, found = context.ready, []
    pairs = [rejudged(item, ready.bench, tables, context.form, offset=item.offset) for item in pairs]
    curves = _on_both(context, pairs, tables, wanted=set(jumping))
    for item, fine, finer in zip(pairs, *curves, strict=True):
        usable = bool(np.all(np.isfinite(finer)))
        (failed.discard if usable else failed.add)(item.ids)
        offset = finer - superposed([tables[name] for name in item.ids], item.evidence.best)
        if usable and item.ids in jumping:
            found.append(averaged(context, tables, item, [*jumping[item.ids], offset]))
        else:
            found.append(_in_doubt(context, tables, item, offset, context.beyond * (finer - fine)) if usable else item)
    return found
