"""Pairs of effects simulated together: what their runs have beyond the superposition of the tables.

Where fabric folds, the change jumps from run to run and likeliest parameters do not stay: such a pair is judged by the
mean and scatter of its runs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from etextile.diagnose.decide.rank import Contender, rejudged
from etextile.diagnose.infer.lattice_doubt import left_open
from etextile.diagnose.infer.refit_runs import ROUNDS, Refit, changes, moved, on_both
from etextile.diagnose.predict.table import EffectTable, superposed
from etextile.types import Array


# Log score behind the best at which the runs on the finest lattice are left out. More than `residual_test.BEHIND`, so
# that whatever can be named or can rule out a leader has been there.
HOPELESS = 14.0


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
        changed = [moved(a.evidence, b.evidence) for a, b in zip(moving, after, strict=True)]
        still += [item for item, apart in zip(after, changed, strict=True) if not apart]
        moving = [item for item, apart in zip(after, changed, strict=True) if apart]
    jumping = {item.ids: runs[item.ids] for item in moving if len(runs[item.ids]) > 1}
    restless |= set(jumping)
    found = [*still, *(averaged(context, tables, item, jumping.get(item.ids, ())) for item in moving)]
    least = max([least, *(item.score - HOPELESS for item in found)])
    near = [item for item in found if item.score > least]
    return [
        *(item for item in found if item.score <= least),
        *_pairs_on_finest(context, tables, near, failed, jumping),
    ]


def carried_over(
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


def _with_interaction(
    context: Refit, tables: Mapping[str, EffectTable], pairs: Sequence[Contender]
) -> list[Contender]:  # fmt: skip
    """Return pairs judged with what their simulation has beyond the superposition of the tables."""
    pairs = [rejudged(item, context.ready.bench, tables, context.form, offset=item.offset) for item in pairs]
    curves = changes(context, pairs, tables)
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
    curves = on_both(context, pairs, tables, wanted=set(jumping))
    for item, fine, finer in zip(pairs, *curves, strict=True):
        usable = bool(np.all(np.isfinite(finer)))
        (failed.discard if usable else failed.add)(item.ids)
        offset = finer - superposed([tables[name] for name in item.ids], item.evidence.best)
        if usable and item.ids in jumping:
            found.append(averaged(context, tables, item, [*jumping[item.ids], offset]))
        else:
            found.append(_in_doubt(context, tables, item, offset, context.beyond * (finer - fine)) if usable else item)
    return found
