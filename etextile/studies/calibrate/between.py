"""How specimens of a calibration differ in stiffness, and what that says of a further one: scatter in place of a guess.

All specimens have the laws that were fitted, each with a factor of its own on the hardening that was freed (thickness,
weave and coating act like that). What a further specimen shows is the scatter of these factors and what they leave of
any of the specimens.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from etextile.identify.between import Population, population
from etextile.identify.calibration import scores_covariance
from etextile.studies.calibrate.observed import UNITS, Models, Observed, percent, sum_of_mean_absolute
from etextile.studies.calibrate.parameters import Space
from etextile.types import Array, BoolArray, IntArray
from etextile.vocabulary import FIELD


NODES = (-1.2, -0.6, -0.3, 0.0, 0.3, 0.6, 1.2)
"""Logarithms of the factor at which every test is run."""
DRAWN = 20
"""Further specimens that are drawn from the population, at equal shares, for each one that was measured."""
ENDS = (0.025, 0.5, 0.975)


@dataclass(frozen=True)
class Between:
    """Readings (K, n) at factors nodes (K,), log factors own (s,) of specimens numbers (s,), and their population."""

    observed: Observed
    nodes: Array
    table: Array
    numbers: IntArray
    own: Array
    deviation: Array
    population: Population

    def predicted(self, factor: float) -> Array:
        """Return the readings (n,) with a log factor; beyond the outermost run they stay."""
        from scipy.interpolate import CubicSpline

        return np.asarray(CubicSpline(self.nodes, self.table, axis=0)(np.clip(factor, *self.nodes[[0, -1]])))

    def foretold(self, channel: str) -> tuple[float, float, float]:
        """Return the error that the fit should have on a further specimen: 2.5 %, mean and 97.5 %.

        mm, the mean of |dx| + |dy| + |dz|, of a field; per cent of a curve.
        """
        shares = (np.arange(DRAWN) + 0.5) / DRAWN
        fit, found = self.predicted(0.0), []
        drawn = [self.predicted(factor) for factor in self.population.further(shares)]
        for number, factor in zip(self.numbers, self.own, strict=True):
            rows = (self.observed.specimen == number) & self.observed.of(channel)
            if rows.any():
                rest = (self.observed.value - self.predicted(float(factor)))[rows]
                found += [_error(fit[rows], other[rows] + rest, channel) for other in drawn]
        low, high = np.quantile(found, [ENDS[0], ENDS[-1]])
        return float(low), float(np.mean(found)), float(high)


def between(space: Space, model: Models, y: Array, noise: Array, mask: BoolArray) -> Between | None:
    """Return the scatter about the estimate y (p,) of the specimens in a mask (n,), found with noise (n,).

    None for one specimen, for a fit without the hardening of a law, and where a stiffer or softer fabric finds no
    equilibrium.
    """
    observed = model.observed
    numbers = np.unique(observed.specimen[mask])
    along = np.array([float(item.kind == "law" and item.name == "H") for item in space.free])
    if len(numbers) < 2 or not along.any():
        return None
    runs = model.predict([space.change(y + factor * along) for factor in NODES])
    valid = np.array([bool(np.all(np.isfinite(run))) for run in runs])
    nodes, table = np.array(NODES)[valid], np.array(runs)[valid]
    if not valid[2:5].all():
        return None
    found = [_factor(observed, nodes, table, noise, observed.specimen == number) for number in numbers]
    own, variance = np.array(found).T
    return Between(observed, nodes, table, numbers, own, np.sqrt(variance), population(own, variance))


def _factor(observed: Observed, nodes: Array, table: Array, noise: Array, rows: BoolArray) -> tuple[float, float]:
    """Return the log factor of a specimen by least squares, and its variance (misfits hang together)."""
    from scipy.interpolate import CubicSpline
    from scipy.optimize import minimize_scalar

    curve = CubicSpline(nodes, table[:, rows], axis=0)
    value, size = observed.value[rows], noise[rows]

    def cost(factor: float) -> float:
        return float(np.sum(((curve(factor) - value) / size) ** 2))

    at = float(minimize_scalar(cost, bounds=(float(nodes[0]), float(nodes[-1])), method="bounded").x)
    slope, misfit = np.asarray(curve(at, 1)) / size, (curve(at) - value) / size
    meat, _ = scores_covariance(slope[:, None], misfit, observed.data(noise, rows))
    weight = float(slope @ slope)
    return at, max(float(meat[0, 0]) / weight**2, 1.0 / weight)


def between_data(item: Between) -> dict[str, Any]:
    """Return the scatter in JSON types: factors of the specimens, of a further one, and what it should show."""
    observed, spread = item.observed, item.population.scatter(ENDS)
    low, middle, high = item.population.further(ENDS)
    return {
        "of": "a factor on the hardening that was freed",
        "specimens": [
            {
                "specimen": Path(observed.names[int(number)]).name,
                "factor": float(np.exp(own)),
                "low": float(np.exp(own - 1.96 * std)),
                "high": float(np.exp(own + 1.96 * std)),
            }
            for number, own, std in zip(item.numbers, item.own, item.deviation, strict=True)
        ],
        "std_of_log": {"low": float(spread[0]), "value": float(spread[1]), "high": float(spread[2])},
        "further_specimen": {
            "factor": {"low": float(np.exp(low)), "value": float(np.exp(middle)), "high": float(np.exp(high))},
            "readings": [_reading(item, name, (low, middle, high)) for name in observed.present],
            "error": [foretold_row(item, name) for name in observed.present],
        },
    }


def foretold_row(item: Between, channel: str) -> dict[str, Any]:
    """Return the error that the fit should have on a further specimen, in mm of a field and per cent of a curve."""
    low, value, high = item.foretold(channel)
    measure = "sum_of_mean_absolute_mm" if channel == FIELD else "percent"
    return {"channel": channel, "measure": measure, "low": low, "value": value, "high": high}


def _reading(item: Between, channel: str, factors: Sequence[float]) -> dict[str, Any]:
    """Return the largest reading of a channel at the last load with the factors of a further specimen."""
    rows = item.observed.of(channel)
    rows &= item.observed.load >= item.observed.load[rows].max()
    found = sorted(float(item.predicted(factor)[rows].max()) for factor in factors)
    return {
        "channel": channel, "at": float(item.observed.load[rows][0]), "unit": UNITS[channel], "low": found[0],
        "value": found[1], "high": found[2],
    }  # fmt: skip


def _error(fit: Array, other: Array, channel: str) -> float:
    """Return the error that is told of a channel: mm of a field, per cent of a curve."""
    return sum_of_mean_absolute(fit - other) if channel == FIELD else percent(fit - other, other)
