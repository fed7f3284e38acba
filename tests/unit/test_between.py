"""Scatter between specimens: its interval holds a further one, wide where few were seen, narrow where many were."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.identify.between import population


@pytest.mark.parametrize(("count", "tau"), [(2, 0.1), (5, 0.2)])
def test_the_interval_holds_a_further_specimen_as_often_as_it_says(count: int, tau: float) -> None:
    rng = np.random.default_rng(count)
    inside = 0
    for _ in range(100):
        own = rng.normal(0.3, tau, count) + rng.normal(0.0, 0.02, count)
        low, high = population(own, np.full(count, 0.02**2)).further((0.025, 0.975))
        inside += bool(low < rng.normal(0.3, tau) < high)
    assert inside >= 88  # 95 expected, standard deviation 2.2


def test_many_specimens_give_what_a_student_distribution_gives() -> None:
    """With many specimens the prior is forgotten: mean +- t s sqrt(1 + 1 / n)."""
    from scipy.stats import t

    own = np.random.default_rng(2).normal(0.0, 0.2, 40)
    low, middle, high = population(own, np.full(40, 1e-8)).further((0.025, 0.5, 0.975))
    reach = t.ppf(0.975, 39) * own.std(ddof=1) * np.sqrt(1.0 + 1.0 / 40.0)
    assert middle == pytest.approx(own.mean(), abs=1e-3)
    assert 0.5 * (high - low) == pytest.approx(reach, rel=0.02)


def test_one_specimen_says_nothing_of_others_and_a_noisy_one_little() -> None:
    with pytest.raises(ValueError, match="two specimens"):
        population(np.array([0.1]), np.array([0.01]))
    sharp = population(np.array([0.0, 0.0, 1.0]), np.array([1e-4, 1e-4, 1e-4])).mean((0.5,))
    noisy = population(np.array([0.0, 0.0, 1.0]), np.array([1e-4, 1e-4, 4.0])).mean((0.5,))
    assert sharp[0] > 0.2 > 0.05 > noisy[0]
