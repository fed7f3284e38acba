r"""What the lattice leaves open in an effect itself.

The numerics gate settles the base; it says nothing of an effect whose own change depends on the lattice, such as one
that lets the fabric fold, slide or give way somewhere else on the next. So every effect is run once on a finer lattice,
and the best hypotheses on both lattices of the gate. How far the change moves, d, goes into the covariance as a smooth
error of the local size of d,

    K_ij = d_i d_j rho_ij.

Where an effect leaves a quantity undetermined on any lattice, its card says by how much. Over places of a field an
effect is known up to its form, as it is over displacements (`fit`), with the same deviation.
No hypothesis is held to a fold that its own simulation does not settle, and none gains by it: what K allows costs
evidence by its determinant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from etextile.diagnose.fit import FORM
from etextile.diagnose.noise import closeness
from etextile.diagnose.points import FORCE, Points
from etextile.diagnose.table import Table
from etextile.diagnose.workbench import Workbench
from etextile.effects.base import Card
from etextile.types import Array, IntArray


# Share of the correlation lengths over which the size of the lattice's change is averaged.
LOCAL = 0.5
# Widths of what a card leaves undetermined (folds may be broad or narrow), as shares of the correlation lengths.
WIDTHS = (1.0, 0.25)
# Share of the variance of a point below which a doubt is left out.
SMALL = 0.1


def facing(bench: Workbench, tables: Sequence[Table]) -> Workbench:
    """Return the workbench as a hypothesis of these effects faces it: with the doubts about them."""
    doubts = [table.doubt for table in tables if table.doubt is not None]
    return bench if not doubts else replace(bench, doubt=np.sum(doubts, axis=0))


def doubted(table: Table, bench: Workbench, on_finer: Array) -> Table:
    """Return the table with the doubt that the change (n,) on a finer lattice at its ordinary node casts on it."""
    index = int(np.ravel_multi_index(table.grid.ordinary, table.grid.shape))
    moved = on_finer - table.basis @ table.amplitudes[:, index]
    if not table.valid[index] or not np.all(np.isfinite(moved)):
        moved = np.zeros(len(moved))
    found = doubt(bench.points, moved, (table.grid.card,))
    return replace(table, doubt=found) if np.any(np.diag(found) > SMALL * np.diag(bench.mean_covariance)) else table


def doubt(points: Points, moved: Array, cards: Sequence[Card], *, change: Array | None = None) -> Array:
    """Return the covariance (n, n) of what is left open in effects, alike for all specimens.

    `moved` (n,): how far their change moves from lattice to lattice. A quantity that a card calls undetermined has the
    error that the card says, of which the move is one instance. `change` (n,): the change itself, for its form.
    """
    sizes: dict[tuple[str, str], float] = {}
    for item in (item for card in cards for item in card.undetermined):
        known = sizes.get((item.channel, item.quantity), 0.0)
        sizes[item.channel, item.quantity] = float(np.hypot(known, item.size))
    found = np.zeros((len(points), len(points)))
    for kind in {(item.channel, item.quantity) for item in points.series}:
        numbers = [i for i, item in enumerate(points.series) if (item.channel, item.quantity) == kind]
        own = np.flatnonzero(np.isin(points.owner, numbers))
        if kind in sizes:
            block = sizes[kind] ** 2 * np.mean([closeness(points, own, share=width) for width in WIDTHS], axis=0)
        else:
            size = _local_size(points, own, moved[own])
            if change is not None and kind[0] != FORCE:
                size = np.hypot(size, FORM * _local_size(points, own, change[own]))
            block = size[:, None] * size[None, :] * closeness(points, own)
        found[np.ix_(own, own)] = block
    return found


def _local_size(points: Points, own: IntArray, difference: Array) -> Array:
    """Return the root mean square (k,) of a difference over the neighbourhood of every point."""
    near = closeness(points, own, share=LOCAL)
    return np.asarray(np.sqrt(near @ difference**2 / near.sum(axis=1)))
