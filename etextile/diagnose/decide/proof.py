r"""Proof of a diagnosis: gaps of the base, the base with re-tuned fabric, the base with the effect, and the floor.

Everything is judged on the raw measured points. What was inferred on thinned points (fabric parameters, the free
discrepancy) is carried to the raw points of each bin. With the prior covariance K of the difference r and columns F of
one of its parts the likeliest contribution of that part is F F_f^T K_ff^-1 r_f, f being the fitted points.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from etextile.diagnose.data.observe import Record, observe
from etextile.diagnose.decide.gap import Gap, gaps
from etextile.diagnose.infer.whitened import Workbench, motion
from etextile.diagnose.predict.parameters import NAMES
from etextile.types import Array, BoolArray
from etextile.vocabulary import CURVES


BASE, RETUNED, EFFECT, FLOOR = "base", "re-tuned", "with effect", "floor"
ROWS = (BASE, RETUNED, EFFECT, FLOOR)
"""Predictions that are compared: the base as it is, with fabric parameters moved within their covariance, with the
effect, and with a free smooth curve through everything (noise and scatter are left)."""


@dataclass(frozen=True)
class Proof:
    """Predictions (N,) at all raw points by the names of `ROWS`, which points (N,) are held out, and the gaps.

    `gaps`: base before, with the effect after (the base again where there is no effect). `rows`: gaps of every
    prediction against the measurement, after equal to before. `deviation` (N,): of the noise. `patched` (N,): with the
    effect as fitted to everything, which is what the patch holds; "with effect" differs from it beyond the split.
    """

    predictions: Mapping[str, Array]
    held_out: BoolArray
    deviation: Array
    gaps: tuple[Gap, ...]
    rows: Mapping[str, tuple[Gap, ...]]
    patched: Array | None = None


def prove(
    bench: Workbench, base: Array, record: Record, *, split: float, free_columns: Array | None,
    fitted_effect: Array | None = None, held_out_effect: Array | None = None,
) -> Proof:  # fmt: skip
    """Return the proof.

    `base` (N,): base prediction at the raw points; `record`: a base run; `fitted_effect`, `held_out_effect` (N,):
    changes by the effect with all points fitted, and fitted up to `split` (mm) only, which is what predicts the rest.
    """
    raw = bench.raw
    held_out = raw.displacement > split
    predictions = {BASE: base, RETUNED: base + to_raw(bench, retuned(bench, split))}
    if fitted_effect is not None:
        beyond = fitted_effect if held_out_effect is None else held_out_effect
        predictions[EFFECT] = base + np.where(held_out, beyond, fitted_effect)
    if free_columns is not None:
        predictions[FLOOR] = base + to_raw(bench, free_fit(bench, free_columns))
    deviation = raw_deviation(bench)
    rest = rest_values(bench, record)
    rows = {
        name: gaps(raw, values, values, deviation=deviation, rest=rest, held_out=held_out)
        for name, values in predictions.items()
    }
    after = predictions.get(EFFECT, base)
    found = gaps(raw, base, after, deviation=deviation, rest=rest, held_out=held_out)
    patched = None if fitted_effect is None else base + fitted_effect
    return Proof(predictions, held_out, deviation, found, rows, patched)


@dataclass(frozen=True)
class RunPair:
    """Two runs of one kind: without and with the effect."""

    without: Record
    added: Record


def change_by_runs(bench: Workbench, ordinary: RunPair, *, coarse: RunPair, finest: RunPair) -> Array:
    """Return the change (N,) by an effect at the raw points, from the ordinary command without and with it.

    `coarse`, `finest`: the same runs by the simulator of the diagnosis (without wires), on the ordinary run's lattice
    and on the finest. Each ordinary run is less its own lattice error: an effect that limits the force limits that too.
    """
    first, second, third = (
        observe(pair.added, bench.raw) - observe(pair.without, bench.raw) for pair in (ordinary, coarse, finest)
    )
    return np.asarray(first + third - second)


def base_gap(bench: Workbench, base: Array, record: Record) -> tuple[Gap, ...]:
    """Return the gap of the base over the whole measurement, per channel (before equal to after)."""
    nothing = np.zeros(len(bench.raw), dtype=bool)
    return gaps(
        bench.raw, base, base, deviation=raw_deviation(bench), rest=rest_values(bench, record), held_out=nothing
    )


def to_raw(bench: Workbench, values: Array) -> Array:
    """Return values (n,) of bins at the raw points (N,): of their bin, along dense force curves interpolated."""
    found = np.asarray(values[bench.bins.bin_of])
    for number, item in enumerate(bench.raw.series):
        if item.channel in CURVES:
            raw, own = bench.raw.owner == number, np.flatnonzero(bench.points.owner == number)
            order = own[np.argsort(bench.points.displacement[own], kind="stable")]
            found[raw] = np.interp(bench.raw.displacement[raw], bench.points.displacement[order], values[order])
    return found


def raw_deviation(bench: Workbench) -> Array:
    """Return the standard deviation (N,) of measured minus simulated at the raw points when nothing is missing.

    The instrument's noise of single readings in place of that of their averages, scatter and freedom of the bin.
    """
    smooth = np.maximum(np.diag(bench.mean_covariance) - bench.white**2, 0.0)
    return np.asarray(np.sqrt(to_raw(bench, smooth) + bench.white_raw**2))


def model_deviation(bench: Workbench) -> Array:
    """Return the standard deviation (n,) of the base prediction: fabric parameters and lattice."""
    return np.asarray(np.sqrt((bench.freedom**2).sum(axis=1) + bench.bumps**2))


def rest_values(bench: Workbench, record: Record) -> Array:
    """Return the values (N,) at rest: nothing for forces and strains, flat coordinates for the edge."""
    return np.asarray(bench.raw.value - motion(record, bench.raw, bench.raw.value))


def retuned(bench: Workbench, split: float) -> Array:
    """Return the likeliest change (n,) by the fabric parameters alone, from the points up to `split`."""
    fitted = bench.points.displacement <= split
    return _likeliest(bench, bench.freedom[:, : len(NAMES)], fitted, extra=None)


def free_fit(bench: Workbench, columns: Array) -> Array:
    """Return the likeliest smooth discrepancy (n,) with prior columns (n, k), fabric re-tuned, from all points."""
    everything = np.ones(len(bench.points), dtype=bool)
    return _likeliest(bench, np.concatenate([bench.freedom, columns], axis=1), everything, extra=columns)


def _likeliest(bench: Workbench, columns: Array, fitted: BoolArray, *, extra: Array | None) -> Array:
    if not fitted.any():
        return np.zeros(len(columns))
    covariance = bench.mean_covariance
    if extra is not None:
        covariance = covariance + extra @ extra.T
    inside = covariance[np.ix_(fitted, fitted)]
    weights = np.linalg.solve(inside, bench.residual[fitted])
    return np.asarray(columns @ (columns[fitted].T @ weights))
