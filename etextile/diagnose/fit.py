r"""Evidence of hypotheses: which effects, integrated over their whole physical range and everything unknown beside.

A hypothesis is a set of effects (none, one, a pair, three), with or without a free smooth discrepancy. Its prediction
is the superposition of tabulated changes. An effect is known up to its form: its change may be wrong by a smooth factor
with standard deviation `FORM`, since a real mechanism follows the library's law in sign, place and growth, not to the
digit. Parameters have a uniform prior over their physical range, so a wide range costs what it should (Occam).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from etextile.diagnose.gauss import Whitener, log_evidence, log_sum
from etextile.diagnose.table import Table
from etextile.types import Array


FORM = 0.10
# Mesh points per dimension, by the number of parameters.
MESH = {1: 41, 2: 15, 3: 9, 4: 6, 5: 5, 6: 4}
ROUNDS = 9
# Parameter values that are less likely than the best by this logarithm do not count.
DEPTH = 14.0


@dataclass(frozen=True)
class Sample:
    """The measurement under one sample of the specimen scatter: whitener, log weight + log p_0 of its evidence."""

    whiten: Whitener
    residual: Array
    log_weight: float


@dataclass(frozen=True)
class Evidence:
    """Judged hypothesis: effect ids, log evidence, posterior points (b, d) in coordinates with weights (b,).

    `best` (d,): the likeliest point; `log_best`: its log likelihood, prior left out.
    """

    ids: tuple[str, ...]
    log_evidence: float
    best: Array
    log_best: float
    points: Array
    weights: Array
    free: bool = False

    def interval(self, dimension: int, share: float = 0.95) -> tuple[float, float, float]:
        """Return posterior median and the central interval of one coordinate."""
        order = np.argsort(self.points[:, dimension])
        values = self.points[order, dimension]
        mass = np.cumsum(self.weights[order])
        mass = (mass - 0.5 * self.weights[order]) / mass[-1]
        low, middle, high = np.interp([0.5 - share / 2, 0.5, 0.5 + share / 2], mass, values)
        return float(middle), float(low), float(high)

    @property
    def mean(self) -> Array:
        """Posterior mean (d,)."""
        return np.asarray(self.weights @ self.points / self.weights.sum())


@dataclass(frozen=True)
class _Vectors:
    """Everything one hypothesis needs under one sample, reduced to the space it spans."""

    residual: Array
    bases: tuple[Array, ...]
    forms: tuple[Array, ...]
    extra: Array


def judge(
    samples: Sequence[Sample], tables: Sequence[Table], form: Array, *, extra: Array | None = None,
    offset: Array | None = None, box: Array | None = None,
) -> Evidence:  # fmt: skip
    """Return the evidence of a set of effects.

    `form` (n, m): smooth unit factors; `extra` (n, z): columns of a free discrepancy that is allowed beside;
    `offset` (n,): known further change, such as the interaction of effects; `box` (d, 2): where to integrate, when the
    likely region is known (the prior stays that of the whole range).
    """
    prepared = [_prepare(sample, tables, form * FORM, extra, offset) for sample in samples]
    ids = tuple(table.id for table in tables)
    free = extra is not None
    if not tables:
        value = float(log_sum(np.array([
            sample.log_weight + _evaluate(vectors, tables, np.zeros((1, 0)))[0]
            for sample, vectors in zip(samples, prepared, strict=True)
        ])))  # fmt: skip
        return Evidence(ids, value, np.zeros(0), value, np.zeros((1, 0)), np.ones(1), free)

    def log_likelihood(points: Array) -> Array:
        rows = [s.log_weight + _evaluate(v, tables, points) for s, v in zip(samples, prepared, strict=True)]
        return log_sum(np.stack(rows), axis=0)

    whole = np.concatenate([table.bounds for table in tables])
    return _integrate(log_likelihood, whole, ids, box=whole if box is None else box, free=free)


def _prepare(
    sample: Sample, tables: Sequence[Table], form: Array, extra: Array | None, offset: Array | None
) -> _Vectors:
    """Whiten all vectors of a hypothesis and rotate them into the space they span (an exact reduction)."""
    residual = sample.residual if offset is None else sample.residual - sample.whiten(offset)
    blocks = [residual[:, None]]
    for table in tables:
        basis = table.basis
        blocks.append(sample.whiten(basis))
        factors = (basis[:, None, :] * form[:, :, None]).reshape(len(basis), -1)
        blocks.append(sample.whiten(factors))
    blocks.append(sample.whiten(extra) if extra is not None else np.zeros((len(sample.residual), 0)))
    ends = np.cumsum([0, *(block.shape[1] for block in blocks)])
    stacked = np.concatenate(blocks, axis=1)
    if stacked.shape[1] < stacked.shape[0]:
        stacked = np.asarray(np.linalg.qr(stacked, mode="r"))
    parts = [stacked[:, a:b] for a, b in pairwise(ends)]
    modes = form.shape[1]
    forms = tuple(parts[2 + 2 * i].reshape(len(stacked), modes, table.basis.shape[1]) for i, table in enumerate(tables))
    return _Vectors(parts[0][:, 0], tuple(parts[1 + 2 * i] for i in range(len(tables))), forms, parts[-1])


def _evaluate(vectors: _Vectors, tables: Sequence[Table], points: Array) -> Array:
    """Return log p(r) - log p_0 (b,) at parameter points (b, d)."""
    count = len(points)
    left = np.broadcast_to(vectors.residual, (count, len(vectors.residual)))
    usable = np.ones(count, dtype=bool)
    columns = []
    start = 0
    for table, basis, forms in zip(tables, vectors.bases, vectors.forms, strict=True):
        size = len(table.grid.axes)
        amplitudes, valid = table.coefficients(points[:, start : start + size])
        start += size
        usable &= valid
        left = left - amplitudes @ basis.T
        columns.append(np.einsum("pmq,bq->bpm", forms, amplitudes, optimize=True))
    if vectors.extra.shape[1]:
        columns.append(np.broadcast_to(vectors.extra, (count, *vectors.extra.shape)))
    freedom = np.concatenate(columns, axis=2) if columns else np.zeros((count, len(vectors.residual), 0))
    value = log_evidence(
        np.einsum("bp,bp->b", left, left),
        np.einsum("bpm,bp->bm", freedom, left, optimize=True),
        np.matmul(freedom.transpose(0, 2, 1), freedom),
    )
    return np.where(usable, value, -np.inf)


def _integrate(log_likelihood, whole: Array, ids: tuple[str, ...], *, box: Array, free: bool) -> Evidence:  # type: ignore[no-untyped-def]
    """Integrate over a box that closes in on the likely region; prior uniform over `whole`."""
    dimensions = len(whole)
    per_side = MESH[dimensions]
    shares = (np.arange(per_side) + 0.5) / per_side
    for _ in range(ROUNDS):
        sides = box[:, :1] + shares[None, :] * (box[:, 1:] - box[:, :1])
        points = np.stack([axis.ravel() for axis in np.meshgrid(*sides, indexing="ij")], axis=1)
        values = log_likelihood(points)
        top = float(values.max())
        if not np.isfinite(top):
            return Evidence(
                ids, -np.inf, box.mean(axis=1), -np.inf, points, np.full(len(points), 1.0 / len(points)), free
            )
        likely = points[values > top - DEPTH]
        cell = (box[:, 1] - box[:, 0]) / per_side
        closer = np.stack([
            np.maximum(likely.min(axis=0) - cell, whole[:, 0]), np.minimum(likely.max(axis=0) + cell, whole[:, 1])
        ], axis=1)  # fmt: skip
        shrunk = np.prod((closer[:, 1] - closer[:, 0]) / (box[:, 1] - box[:, 0]))
        if shrunk > 0.6**dimensions:
            break
        box = closer
    volume = float(np.log(box[:, 1] - box[:, 0]).sum() - np.log(whole[:, 1] - whole[:, 0]).sum())
    total = float(log_sum(values)) - np.log(len(values)) + volume
    weights = np.exp(values - top)
    return Evidence(ids, total, points[int(np.argmax(values))], top, points, weights / weights.sum(), free)
