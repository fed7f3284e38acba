"""Held-out score: fit on one part of the measurement, predict the rest, and say how much of the gap there closes.

The parts are the displacements up to a split and those beyond it, and every channel left out in turn. What decides is
the prediction from the fitted part alone; base parameters and noise of the held-out part get no chance to adapt.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.diagnose.infer.fit import Evidence, ScatterSample, judge
from etextile.diagnose.infer.gauss import Whitener
from etextile.diagnose.infer.whitened import Workbench
from etextile.diagnose.predict.table import EffectTable, each_with_its_own
from etextile.types import Array, BoolArray
from etextile.units import load_text


# Where the fitted part ends between onset and end of the measurement, and the share of it that is held out at least.
SPLIT, LEAST = 0.6, 0.15
NORMAL_95 = 1.959964
BEYOND = " beyond "
LOADS = {"mm": "displacements", "bar": "pressures", "deg": "angles", "1/m": "curvatures"}
"""What the part beyond the split is called."""


@dataclass(frozen=True)
class HeldOut:
    """Share of the held-out gap (mean square in standard deviations of each point) that closes, with 95 % interval.

    `what` names the part; `before`, `after`: root mean square differences in standard deviations.
    """

    what: str
    closed: float
    low: float
    high: float
    before: float
    after: float
    fit: Evidence

    @property
    def shrinks(self) -> bool:
        """Whether the interval of the closure excludes zero."""
        return self.low > 0.0

    @property
    def grows(self) -> bool:
        """Whether the prediction makes the held-out gap larger, beyond doubt."""
        return self.high < 0.0


def beyond_words(split: float, unit: str) -> str:
    """Return what the part beyond the split is called."""
    return f"{LOADS[unit]}{BEYOND}{load_text(split, unit, whole=True)} {unit}"


def is_beyond(what: str) -> bool:
    """Tell whether a held-out part is the one beyond the split."""
    return BEYOND in what


def split_at(onset: float, end: float) -> float:
    """Return the displacement (or other load) at which the fitted part ends.

    `onset`: where the gap begins at the latest, so that the fitted part holds some of it.
    """
    return min(onset + SPLIT * (end - onset), (1.0 - LEAST) * end)


def hold_out(
    bench: Workbench,
    tables: Sequence[EffectTable],
    form: Array,
    test: BoolArray,
    *,
    what: str,
    offset: Array | None = None,
) -> HeldOut:
    """Fit on the points outside of `test` (n,) and predict those inside."""
    fitted = ~test
    samples = part_of(bench, fitted)
    fit = judge(samples, [restricted(table, fitted) for table in tables], form[fitted], offset=_cut(offset, fitted))
    change = prediction(fit, tables) + (0.0 if offset is None else offset[:, None])
    return _score(bench, fit, change, test, what)


def _score(bench: Workbench, fit: Evidence, change: Array, test: BoolArray, what: str) -> HeldOut:
    """Compare squared differences before and after on the held-out points.

    before^2 - after^2 = sum w (2 r d - d^2): its noise has the variance 4 (w d)^T C (w d) with the covariance C of the
    held-out points given the fitted ones (what is wrong in both alike is seen there), its parameters their posterior.
    """
    whole = bench.mean_covariance
    weight = 1.0 / np.diag(whole)[test]
    inside = _given(whole, test)
    residual, moved = bench.residual[test], change[test]
    before = float(weight @ residual**2)
    gains = (weight[:, None] * (2.0 * residual[:, None] * moved - moved**2)).sum(axis=0)
    mean = float(fit.weights @ gains)
    expected = moved @ fit.weights
    noise = 2.0 * np.sqrt(float((weight * expected) @ inside @ (weight * expected)))
    spread = float(np.hypot(np.sqrt(max(float(fit.weights @ (gains - mean) ** 2), 0.0)), noise))
    after = max(before - float((weight * (2.0 * residual * expected - expected**2)).sum()), 0.0)
    scale = max(before, 1e-12)
    count = int(test.sum())
    return HeldOut(
        what, 1.0 - after / scale, (mean - NORMAL_95 * spread) / scale, (mean + NORMAL_95 * spread) / scale,
        float(np.sqrt(before / count)), float(np.sqrt(after / count)), fit,
    )  # fmt: skip


def _given(covariance: Array, test: BoolArray) -> Array:
    """Return the covariance of the points in `test` given the others: C_tt - C_tf C_ff^-1 C_ft."""
    whiten = Whitener.of(covariance[np.ix_(~test, ~test)])
    known = whiten(covariance[np.ix_(~test, test)])
    return np.asarray(covariance[np.ix_(test, test)] - known.T @ known)


def prediction(fit: Evidence, tables: Sequence[EffectTable]) -> Array:
    """Return the changes (n, b) at all posterior points of a fit."""
    changes = [table.basis @ table.coefficients(own)[0].T for table, own in each_with_its_own(tables, fit.points)]
    return np.asarray(sum(changes)) if changes else np.zeros((1, 1))


def part_of(bench: Workbench, mask: BoolArray) -> tuple[ScatterSample, ...]:
    """Return the samples of a part of the points."""
    found = []
    for item in bench.scatters:
        whiten = Whitener.of(bench.covariance(item.scatter)[np.ix_(mask, mask)])
        log_weight = float(np.log(item.weight) - 0.5 * whiten.log_determinant)
        found.append(ScatterSample(whiten, whiten(bench.residual[mask]), log_weight))
    return tuple(found)


def restricted(table: EffectTable, mask: BoolArray) -> EffectTable:
    """Return a table on a part of the points."""
    return replace(table, basis=table.basis[mask], doubt=None, loose=None)


def _cut(offset: Array | None, mask: BoolArray) -> Array | None:
    return None if offset is None else offset[mask]
