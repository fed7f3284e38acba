"""The search behind calibrate on models whose answer is known: estimate, coverage, and what is left open."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.stats import t

from etextile.identify.calibration import Data, Predict, Unknowns, calibrate
from etextile.types import Array


LOAD = np.linspace(0.1, 1.0, 24)
TRUTH = np.array([0.4, -0.3])


def unknowns(start: Array, *, spread: float = 3.0) -> Unknowns:
    size = len(start)
    return Unknowns(
        tuple("abcd"[:size]), start, np.full(size, 0.01), start, np.full(size, spread), start - 9.0, start + 9.0
    )


def curve(y: Array) -> Array:
    """A power law: exp(y0) load^exp(y1)."""
    return np.asarray(np.exp(y[0]) * LOAD ** np.exp(y[1]))


def misfit(value: Array) -> Predict:
    def of(points: Sequence[Array]) -> list[Array]:
        return [curve(y) - value for y in points]

    return of


def data(noise: float) -> Data:
    return Data(np.full(len(LOAD), noise), np.arange(len(LOAD)), np.zeros(len(LOAD), dtype=np.int64))


def test_without_noise_the_truth_is_found() -> None:
    found = calibrate(misfit(curve(TRUTH)), unknowns(np.zeros(2), spread=1e4), data(1e-3), most=40)
    assert found.y == pytest.approx(TRUTH, abs=1e-4)
    assert not found.open.any()
    assert found.scale < 0.05


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    generator = np.random.default_rng(1)
    inside = 0
    for _ in range(200):
        value = curve(TRUTH) + generator.normal(0.0, 0.02, len(LOAD))
        found = calibrate(misfit(value), unknowns(np.zeros(2)), data(0.02))
        inside += np.sum(np.abs(found.y - TRUTH) <= t.ppf(0.975, found.freedom) * found.std)
    assert 0.93 <= inside / 400 <= 0.995


def test_understated_and_correlated_noise_widens_the_interval() -> None:
    """A drift that the noise does not mention: independent points would promise an interval that misses the truth."""
    generator = np.random.default_rng(2)
    inside = naive = 0
    for _ in range(100):
        steps = generator.normal(0.0, 0.02, len(LOAD))
        drift = np.array([sum(0.5 ** (i - j) * steps[j] for j in range(i + 1)) for i in range(len(LOAD))])
        found = calibrate(misfit(curve(TRUTH) + drift), unknowns(np.zeros(2)), data(0.005))
        miss = np.abs(found.y - TRUTH)
        plain = np.sqrt(np.diag(np.linalg.inv(found.jacobian.T @ found.jacobian + np.eye(2) / 9.0)))
        inside += np.sum(miss <= t.ppf(0.975, found.freedom) * found.std)
        naive += np.sum(miss <= 1.96 * plain)
    assert naive / 200 < 0.8
    assert inside / 200 > 0.85


def test_two_unknowns_that_only_act_together_are_told_so() -> None:
    def of(points: Sequence[Array]) -> list[Array]:
        return [np.exp(y[0] + y[1]) * LOAD - 1.5 * LOAD for y in points]

    found = calibrate(of, unknowns(np.zeros(2)), data(0.01))
    assert found.open.all()
    assert found.pairs[0][:2] == (1, 0)
    assert found.pairs[0][2] == pytest.approx(-1.0, abs=1e-3)
    assert found.y.sum() == pytest.approx(np.log(1.5), abs=1e-4)


def test_what_has_no_effect_is_left_open_and_stays_where_it_was() -> None:
    def of(points: Sequence[Array]) -> list[Array]:
        return [curve(y[:2]) - curve(TRUTH) for y in points]

    found = calibrate(of, unknowns(np.array([0.0, 0.0, 0.7])), data(0.01))
    assert found.open.tolist() == [False, False, True]
    assert found.y[2] == pytest.approx(0.7)


def test_a_start_without_equilibrium_is_refused() -> None:
    with pytest.raises(ValueError, match="no equilibrium"):
        calibrate(lambda points: [np.full(len(LOAD), np.nan) for _ in points], unknowns(np.zeros(2)), data(0.01))
