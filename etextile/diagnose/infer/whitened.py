"""The measurement against the base: predictions, covariance and difference, ready for every later stage.

The base is predicted on two finer lattices; the finest stands, and what an extrapolation in the square of the cell
size says is still missing goes into the covariance, as a direction (the fabric may stand between the limit and the
coarser of the two) and as a bumpy rest (contact of single nodes).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from etextile.diagnose.data.noise import (
    NoiseScatter,
    SignalShape,
    WeightedScatter,
    covariance,
    infer_scatter,
    instrument,
)
from etextile.diagnose.data.observe import Record, observe
from etextile.diagnose.data.points import Points, Thinning, thin, thinned
from etextile.diagnose.infer.fit import ScatterSample
from etextile.diagnose.infer.gauss import Whitener
from etextile.types import Array
from etextile.vocabulary import CURVES, EDGE


# Bumps of the lattice error that do not follow its trend, as a share of it.
BUMPS = 0.3
# Shares of what a card calls undetermined that are taken to be equally likely, and their root mean square.
LOOSE = (0.03, 0.1, 0.32, 1.0)
MEAN_LOOSE = float(np.sqrt(np.mean(np.square(LOOSE))))


@dataclass(frozen=True)
class LatticeDoubt:
    """Base prediction (n,) of the finest lattice, columns (n, k) of what it leaves open, and its bumps (n,)."""

    value: Array
    columns: Array
    bumps: Array

    @property
    def deviation(self) -> Array:
        """Standard deviation (n,) of the base prediction by the lattice."""
        return np.asarray(np.sqrt((self.columns**2).sum(axis=1) + self.bumps**2))


def lattice_error(predictions: Sequence[Array], cell_sizes: Sequence[float], half_step: Array) -> LatticeDoubt:
    """Return the base from predictions (n,) on lattices of falling cell size; `half_step` (n,): coarsest, half a step.

    The two finest say what is missing to the limit: rest = (m_f - m_c) h_f^2 / (h_c^2 - h_f^2), which is about as much
    as they differ. The finest is taken, +- rest is its standard deviation.
    """
    fine, finer = predictions[-2], predictions[-1]
    ratio = cell_sizes[-1] ** 2 / (cell_sizes[-2] ** 2 - cell_sizes[-1] ** 2)
    rest = (finer - fine) * ratio
    columns = np.stack([rest, half_step - predictions[0]], axis=1)
    return LatticeDoubt(finer, columns, BUMPS * np.abs(rest))


@dataclass(frozen=True)
class Workbench:
    """Everything the stages need about one measurement, on thinned points (n,).

    `base`: extrapolated prediction; `residual`: measured minus base; `white`: instrument noise; `scatters`: samples of
    the specimen scatter; `freedom` (n, k): columns of base parameters (scaled to their covariance) and lattice error;
    `doubt` (n, n): covariance of what the lattice leaves open in a hypothesis, nothing for the base; `loose` (n, n): of
    what it leaves undetermined on any lattice, at the largest; how much of it there is, is not known (`LOOSE`).
    `kept`: covariances of the base by scatter, shared by the workbenches of all hypotheses (`lattice_doubt.facing`).
    """

    raw: Points
    bins: Thinning
    points: Points
    base: Array
    residual: Array
    white: Array
    white_raw: Array
    shape: SignalShape
    scatters: tuple[WeightedScatter, ...]
    freedom: Array
    bumps: Array
    doubt: Array | None = None
    loose: Array | None = None
    kept: dict[NoiseScatter, Array] = field(default_factory=dict, repr=False, compare=False)

    def covariance(self, scatter: NoiseScatter, *, loose: float = MEAN_LOOSE) -> Array:
        """Return the covariance (n, n) of the difference to the base, or to the hypothesis that `doubt` is of.

        `loose`: share of the deviation of what is undetermined; by default the root mean square of all.
        """
        if scatter not in self.kept:
            noise = covariance(self.points, self.white, self.shape, scatter)
            self.kept[scatter] = noise + self.freedom @ self.freedom.T + np.diag(self.bumps**2)
        known = self.kept[scatter]
        known = known if self.doubt is None else known + self.doubt
        return np.asarray(known if self.loose is None else known + loose**2 * self.loose)

    @cached_property
    def samples(self) -> tuple[ScatterSample, ...]:
        """Return the whitened measurement under every sample of the scatter and of what is undetermined."""
        found = []
        shares = (MEAN_LOOSE,) if self.loose is None else LOOSE
        for item, share in itertools.product(self.scatters, shares):
            whiten = Whitener.of(self.covariance(item.scatter, loose=share))
            log_weight = np.log(item.weight / len(shares)) - 0.5 * whiten.log_determinant
            found.append(ScatterSample(whiten, whiten(self.residual), float(log_weight)))
        return tuple(found)

    @cached_property
    def mean_covariance(self) -> Array:
        """Return the covariance (n, n) averaged over the samples of the scatter."""
        return np.asarray(sum(item.weight * self.covariance(item.scatter) for item in self.scatters))

    @cached_property
    def mean_sample(self) -> ScatterSample:
        """Return the whitened measurement under the mean covariance, for quick comparisons among hypotheses."""
        whiten = Whitener.of(self.mean_covariance)
        return ScatterSample(whiten, whiten(self.residual), float(-0.5 * whiten.log_determinant))


def slopes(record: Record, points: Points) -> Array:
    """Return the derivative (n,) of the predictions over displacement."""
    step = 0.01 * record.reach
    up = np.minimum(points.displacement + step, record.reach)
    down = np.maximum(points.displacement - step, record.displacement[0])
    first, second = replace(points, displacement=up), replace(points, displacement=down)
    return np.asarray((observe(record, first) - observe(record, second)) / (up - down))


def motion(record: Record, points: Points, value: Array) -> Array:
    """Return values (n,) as change since rest: forces and strains themselves, coordinates less their flat ones."""
    found = value.copy()
    for i, item in enumerate(points.series):
        own = points.owner == i
        if item.channel == EDGE and item.quantity == "warp":
            found[own] -= points.warp0[own]
        elif item.channel == EDGE and item.quantity == "weft":
            found[own] -= np.where(points.weft0[own] > 0.0, record.y[-1], -record.y[-1])
    return found


def set_up(raw: Points, record: Record, lattice: LatticeDoubt, freedom: Array) -> Workbench:
    """Return the workbench of raw points (N,); `record` is the finest base run, `freedom` (N, k) of base parameters."""
    bins = thin(raw)
    points = thinned(raw, bins)
    residual = raw.value - lattice.value
    slope, moved = slopes(record, raw), motion(record, raw, lattice.value)
    white_raw = instrument(raw, residual, moved)
    white = np.sqrt(bins.average(white_raw**2) / bins.count)
    shape = SignalShape(bins.average(lattice.value), bins.average(slope), bins.average(moved))
    columns = np.concatenate([freedom, lattice.columns], axis=1)
    return Workbench(
        raw, bins, points, bins.average(lattice.value), bins.average(residual), white, white_raw, shape,
        infer_scatter(points, bins.average(residual), white, shape), bins.average(columns),
        bins.average(lattice.bumps),
    )  # fmt: skip


def scale(bench: Workbench) -> Array:
    """Return a size (n,) for relative changes: the motion or force, at least a twentieth of its largest.

    It has the sign that a change has which is alike on both free edges (`Points.side`).
    """
    found = np.zeros(len(bench.points))
    for i, item in enumerate(bench.points.series):
        own = bench.points.owner == i
        size = np.abs(bench.shape.motion[own])
        largest = float(size.max(initial=0.0))
        found[own] = np.maximum(size, 0.05 * largest) if item.channel in CURVES else np.maximum(size, 0.25 * largest)
    return found * bench.points.side
