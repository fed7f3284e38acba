r"""What the lattice leaves open in an effect itself.

The numerics gate settles the base; it says nothing of an effect whose own change depends on the lattice, such as one
that lets the fabric fold, slide or give way somewhere else on the next. So every effect is run once on a finer lattice,
and the best hypotheses, pairs as a whole, on both lattices of the gate. How far the change moves, d, goes into the
covariance as a smooth error of the local size of d,

    K_ij = d_i d_j rho_ij.

Where an effect leaves a quantity undetermined on any lattice, its card says by how much. Over places of a field an
effect is known up to its form, as it is over displacements (`fit`), with the same deviation.
No hypothesis is held to a fold that its own simulation does not settle. What K allows costs evidence by its
determinant. K does not shrink with the effect, so one of nearly no size could still take up the rest of another cause:
none is named whose own change noise could hide (`finalists`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from etextile.diagnose.data.noise import closeness
from etextile.diagnose.data.points import Points
from etextile.diagnose.infer.fit import FORM
from etextile.diagnose.infer.whitened import Workbench
from etextile.diagnose.predict.table import EffectTable
from etextile.effects.base import Card
from etextile.types import Array, IntArray
from etextile.vocabulary import CURVES


# Share of the correlation lengths over which the size of the lattice's change is averaged.
LOCAL = 0.5
# Widths of what a card leaves undetermined (folds may be broad or narrow), as shares of the correlation lengths.
WIDTHS = (1.0, 0.25)
# Share of the variance of a point below which a doubt is left out.
SMALL = 0.1


def facing(bench: Workbench, tables: Sequence[EffectTable], own: Array | None = None) -> Workbench:
    """Return the workbench as a hypothesis of these effects faces it: with the doubts about them.

    `own` (n, n): what its own runs leave open, in place of the sum over its effects.
    """
    doubt, loose = (
        [getattr(table, name) for table in tables if getattr(table, name) is not None] for name in ("doubt", "loose")
    )
    doubt = doubt if own is None else [own]
    if not doubt and not loose:
        return bench
    return replace(
        bench, doubt=np.sum(doubt, axis=0) if doubt else None, loose=np.sum(loose, axis=0) if loose else None
    )


def doubted(table: EffectTable, bench: Workbench, on_finer: Array) -> EffectTable:
    """Return the table with the doubt that the change (n,) on a finer lattice at its ordinary node casts on it.

    Where the finer lattice has no answer (NaN) the whole change is in doubt.
    """
    index = int(np.ravel_multi_index(table.grid.ordinary, table.grid.shape))
    curve = table.basis @ table.amplitudes[:, index]
    moved = np.where(np.isfinite(on_finer), on_finer - curve, curve)
    doubt = left_open(bench.points, moved, [table.grid.card], change=curve)
    small = np.all(np.diag(doubt) <= SMALL * np.diag(bench.mean_covariance))
    return replace(table, doubt=None if small else doubt, loose=undetermined(bench.points, table.grid.card))


def left_open(points: Points, moved: Array, cards: Sequence[Card], *, change: Array) -> Array:
    """Return the covariance (n, n) of what lattice and form leave open in effects that act together, for all specimens.

    `moved` (n,): how far their change moves from lattice to lattice; `change` (n,): the change, for its form over
    places. Quantities that a card calls undetermined are left to `undetermined`: the move is one instance of that.
    """
    found = np.zeros((len(points), len(points)))
    loose = {(item.channel, item.quantity) for card in cards for item in card.undetermined}
    for kind in {(item.channel, item.quantity) for item in points.series} - loose:
        own = _of_kind(points, kind)
        if not len(own):
            continue
        size = _local_size(points, own, moved[own])
        if kind[0] not in CURVES:
            size = np.hypot(size, FORM * _local_size(points, own, change[own]))
        size = points.side[own] * size
        found[np.ix_(own, own)] = size[:, None] * size[None, :] * closeness(points, own)
    return found


def undetermined(points: Points, card: Card) -> Array | None:
    """Return the covariance (n, n) of what the card calls undetermined, None when nothing of it was measured."""
    found = np.zeros((len(points), len(points)))
    for item in card.undetermined:
        own = _of_kind(points, (item.channel, item.quantity))
        if not len(own):
            continue
        found[np.ix_(own, own)] += item.size**2 * np.mean([closeness(points, own, share=w) for w in WIDTHS], axis=0)
    return found if found.any() else None


def _of_kind(points: Points, kind: tuple[str, str]) -> IntArray:
    """Return the numbers of the points of a channel and quantity."""
    numbers = [i for i, item in enumerate(points.series) if (item.channel, item.quantity) == kind]
    return np.flatnonzero(np.isin(points.owner, numbers))


def _local_size(points: Points, own: IntArray, difference: Array) -> Array:
    """Return the root mean square (k,) of a difference over the neighbourhood of every point."""
    near = closeness(points, own, share=LOCAL)
    return np.asarray(np.sqrt(near @ difference**2 / near.sum(axis=1)))
