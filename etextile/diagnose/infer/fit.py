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

from etextile.diagnose.infer.gauss import Whitener, log_evidence, log_sum
from etextile.diagnose.infer.integrate import integrate
from etextile.diagnose.predict.table import EffectTable, each_with_its_own
from etextile.types import Array, BoolArray


FORM = 0.10
# Points judged at once: as many as stay in the processor's cache.
AT_ONCE = 64


@dataclass(frozen=True)
class ScatterSample:
    """The measurement under one sample of the specimen scatter: whitener, log weight + log p_0 of its evidence."""

    whiten: Whitener
    residual: Array
    log_weight: float


@dataclass(frozen=True)
class Evidence:
    """Judged hypothesis: effect ids, log evidence, posterior points (b, d) in coordinates with weights (b,).

    `best` (d,): the likeliest point; `log_best`: its log likelihood, prior left out; `log_likelihood` (b,): of all.
    """

    ids: tuple[str, ...]
    log_evidence: float
    best: Array
    log_best: float
    points: Array
    weights: Array
    free: bool = False
    log_likelihood: Array | None = None

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
    """Everything one hypothesis needs under one sample, reduced to the space (p) it spans, whitened.

    `residual` (p,); of every table `bases` (p, q) and `forms` (q, m p), its basis times every smooth factor;
    `log_weight`: log p_0 and the sample's weight.
    """

    residual: Array
    bases: tuple[Array, ...]
    forms: tuple[Array, ...]
    log_weight: float


def judge(
    samples: Sequence[ScatterSample], tables: Sequence[EffectTable], form: Array, *, extra: Array | None = None,
    offset: Array | None = None,
) -> Evidence:  # fmt: skip
    """Return the evidence of a set of effects.

    `form` (n, m): smooth unit factors; `extra` (n, z): columns of a free discrepancy that is allowed beside;
    `offset` (n,): known further change, such as the interaction of effects.
    """
    prepared = [_prepare(sample, tables, form * FORM, extra, offset) for sample in samples]
    ids = tuple(table.id for table in tables)
    free = extra is not None
    if not tables:
        value = float(log_sum(np.array([_evaluate(vectors, [], 1)[0] for vectors in prepared])))
        return Evidence(ids, value, np.zeros(0), value, np.zeros((1, 0)), np.ones(1), free)

    def log_likelihood(points: Array) -> Array:
        changes = _changes(tables, points)
        return log_sum(np.stack([_evaluate(vectors, changes, len(points)) for vectors in prepared]), axis=0)

    likeliest = prepared[max(range(len(samples)), key=lambda i: samples[i].log_weight)]
    whole = np.concatenate([table.bounds for table in tables])
    found = integrate(
        log_likelihood, whole, guide=lambda points: _evaluate(likeliest, _changes(tables, points), len(points))
    )
    if found is None:
        centre = whole.mean(axis=1)
        return Evidence(ids, -np.inf, centre, -np.inf, centre[None, :], np.ones(1), free)
    return Evidence(
        ids, found.log_mean, found.best, found.log_best, found.points, found.weights, free, found.log_likelihood
    )


def bound(sample: ScatterSample, tables: Sequence[EffectTable], form: Array) -> float:
    """Return what the log evidence of a set of effects under one sample cannot pass, whatever their parameters.

    Changes and their smooth factors lie in a space of their own; what of the residual lies outside of it no size and
    no form takes up, and determinants of freedoms only cost.
    """
    factors = [table.basis[:, :, None] * form[:, None, :] for table in tables]
    columns = [*(table.basis for table in tables), *(item.reshape(len(form), -1) for item in factors)]
    space = np.linalg.qr(sample.whiten(np.concatenate(columns, axis=1)))[0]
    outside = sample.residual - space @ (space.T @ sample.residual)
    return float(sample.log_weight - 0.5 * outside @ outside)


def _prepare(
    sample: ScatterSample, tables: Sequence[EffectTable], form: Array, extra: Array | None, offset: Array | None
) -> _Vectors:
    """Whiten all vectors of a hypothesis and rotate them into the space they span (an exact reduction).

    A free discrepancy is the same Gaussian whatever the parameters, so it goes into the covariance once.
    """
    residual = sample.residual if offset is None else sample.residual - sample.whiten(offset)
    blocks, log_weight = [residual[:, None]], sample.log_weight
    for table in tables:
        basis = table.basis
        blocks.append(sample.whiten(basis))
        factors = (basis[:, :, None] * form[:, None, :]).reshape(len(basis), -1)
        blocks.append(sample.whiten(factors))
    ends = np.cumsum([0, *(block.shape[1] for block in blocks)])
    stacked = np.concatenate(blocks, axis=1)
    if extra is not None:
        columns = sample.whiten(extra)
        rest = Whitener.of(np.eye(len(columns)) + columns @ columns.T)
        stacked, log_weight = rest(stacked), log_weight - 0.5 * rest.log_determinant
    if stacked.shape[1] < stacked.shape[0]:
        stacked = np.asarray(np.linalg.qr(stacked, mode="r"))
    parts = [stacked[:, a:b] for a, b in pairwise(ends)]
    forms = tuple(parts[2 + 2 * i].T.reshape(table.basis.shape[1], -1) for i, table in enumerate(tables))
    return _Vectors(parts[0][:, 0], tuple(parts[1 + 2 * i] for i in range(len(tables))), forms, log_weight)


def _changes(tables: Sequence[EffectTable], points: Array) -> list[tuple[Array, BoolArray]]:
    """Return amplitudes (b, q) of every table at parameter points (b, d), and whether runs behind them are valid."""
    return [table.coefficients(own) for table, own in each_with_its_own(tables, points)]


def _evaluate(vectors: _Vectors, changes: Sequence[tuple[Array, BoolArray]], count: int) -> Array:
    """Return log p(r) and the sample's log weight (count,) at the points whose amplitudes `changes` holds."""
    size = len(vectors.residual)
    modes = [forms.shape[1] // size for forms in vectors.forms]
    found = np.full(count, vectors.log_weight)
    for some in (slice(i, i + AT_ONCE) for i in range(0, count, AT_ONCE)):
        columns = np.empty((len(found[some]), sum(modes) + 1, size))
        left, start = columns[:, -1], 0
        left[:] = vectors.residual
        for (amplitudes, _), basis, forms, m in zip(changes, vectors.bases, vectors.forms, modes, strict=True):
            left -= amplitudes[some] @ basis.T
            columns[:, start : start + m] = (amplitudes[some] @ forms).reshape(-1, m, size)
            start += m
        found[some] += log_evidence(columns)
    for _, valid in changes:
        found[~valid] = -np.inf
    return found
