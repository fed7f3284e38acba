"""Uncertainty from few specimens: correlated points, scatter that is integrated out, coverage with real scatter."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.identify.statistics import (
    autocorrelation_factor,
    pool,
    residual_variance,
    sample_covariance,
    with_deviations,
)


def correlated(count: int, factor: float, rng: np.random.Generator) -> np.ndarray:
    values = np.empty(count)
    values[0] = rng.normal()
    for i in range(1, count):
        values[i] = factor * values[i - 1] + np.sqrt(1.0 - factor**2) * rng.normal()
    return values


def test_independent_points_count_in_full_and_correlated_ones_less() -> None:
    """Tau = (1 + rho) / (1 - rho) for a first-order process."""
    rng = np.random.default_rng(0)
    white = [autocorrelation_factor(rng.normal(size=200)) for _ in range(100)]
    drift = [autocorrelation_factor(correlated(2000, 0.8, rng)) for _ in range(40)]
    assert np.mean(white) == pytest.approx(1.1, abs=0.15)
    assert np.mean(drift) == pytest.approx(9.0, rel=0.2)
    assert autocorrelation_factor(np.zeros(50)) == 1.0


def test_residuals_smaller_than_the_noise_do_not_shrink_the_variance() -> None:
    assert residual_variance(np.full(4, 1e-3) * [1, -1, 1, -1], parameters=2, floor=0.04) == pytest.approx(0.04)


def test_without_scatter_pooling_is_the_weighted_mean() -> None:
    pooled = pool([1.0, 2.0], [0.01, 0.04], scatter=0.0)
    assert pooled.mean == pytest.approx((1.0 * 100.0 + 2.0 * 25.0) / 125.0)
    assert pooled.std == pytest.approx(125.0**-0.5)
    assert pooled.between == 0.0


def test_one_specimen_gets_the_usual_scatter() -> None:
    pooled = pool([0.5], [1e-6], scatter=0.03)
    assert pooled.mean == pytest.approx(0.5)
    assert pooled.std == pytest.approx(0.03, rel=0.02)


def test_specimens_that_differ_by_more_than_their_noise_widen_the_interval() -> None:
    near, far = (pool([0.0, d], [1e-4, 1e-4], scatter=0.03) for d in (0.01, 0.08))
    assert far.std > 1.5 * near.std
    assert far.between > 2.0 * near.between


@pytest.mark.parametrize("scatter", [0.0, 0.01, 0.03])
@pytest.mark.parametrize("specimens", [2, 3, 6])
def test_intervals_hold_the_truth_with_few_specimens(scatter: float, specimens: int) -> None:
    rng = np.random.default_rng(7)
    held = 0
    for _ in range(400):
        values = rng.normal(0.0, scatter, specimens) + rng.normal(0.0, 0.01, specimens)
        pooled = pool(values.tolist(), [1e-4] * specimens, scatter=0.03)
        held += abs(pooled.mean) < 1.96 * pooled.std
    assert held / 400 >= 0.90


def test_deviations_are_replaced_and_correlations_kept() -> None:
    covariance = np.array([[4.0, 3.0], [3.0, 9.0]])
    changed = with_deviations(covariance, np.array([1.0, 2.0]))
    np.testing.assert_allclose(changed, [[1.0, 1.0], [1.0, 4.0]])
    assert sample_covariance(np.array([[1.0, 2.0]])).tolist() == [[0.0, 0.0], [0.0, 0.0]]
