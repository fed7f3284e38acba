"""Intervals, failed runs as bounds, fragility and rank correlation against what is known of them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from etextile.ensemble.statistics import (
    bounds,
    crossing,
    difference,
    interval,
    mean_difference,
    mean_of,
    probability,
    rank_correlation,
)


def test_the_interval_of_counts_is_that_of_agresti_and_coull() -> None:
    counts = np.array([1.0] * 3 + [0.0] * 17)
    z2 = 1.959964**2
    centre = (3 + z2 / 2) / (20 + z2)
    half = np.sqrt(z2 * centre * (1 - centre) / (20 + z2))
    low, high = interval(counts)
    assert (low, high) == pytest.approx((centre - half, centre + half))


def test_the_interval_holds_the_truth_as_often_as_it_says() -> None:
    rng = np.random.default_rng(8)
    for truth in (0.02, 0.2, 0.5):
        low, high = interval((rng.random((60, 4000)) < truth).astype(float))
        assert np.mean((low <= truth) & (truth <= high)) > 0.935


def test_probabilities_within_samples_narrow_the_interval_but_never_to_nothing() -> None:
    narrow, wide = interval(np.full(100, 0.3)), interval(np.array([1.0] * 30 + [0.0] * 70))
    assert 0.0 < narrow[1] - narrow[0] < 0.3 * (wide[1] - wide[0])
    assert interval(np.zeros(50))[1] > 0.03


@pytest.mark.parametrize("values", [[0.0] * 4, [1.0] * 4, [0.1] * 9, [0.0, 1.0, 0.5]])
def test_the_interval_holds_the_mean(values: list[float]) -> None:
    low, high = interval(np.array(values))
    assert 0.0 <= low <= np.mean(values) <= high <= 1.0


def test_a_run_that_broke_off_is_known_up_to_there_and_open_beyond() -> None:
    low, high = bounds(np.array([[0.0, 0.2, np.nan, np.nan], [0.0, 0.1, 0.6, 1.0]]))
    assert low.tolist() == [[0.0, 0.2, 0.2, 0.2], [0.0, 0.1, 0.6, 1.0]]
    assert high.tolist() == [[0.0, 0.2, 1.0, 1.0], [0.0, 0.1, 0.6, 1.0]]


def test_failed_runs_widen_the_interval_and_are_not_dropped() -> None:
    values = np.full((40, 1), 0.5)
    whole = probability(values, values)
    broken = np.vstack([values, np.full((10, 1), np.nan)])[:, None, :]
    some = probability(*bounds(broken))
    assert some.value[0] == pytest.approx((0.8 * 0.5 + 0.8 * 0.5 + 0.2) / 2)
    assert some.low[0] < whole.low[0] - 0.05
    assert some.high[0] > whole.high[0] + 0.05


def test_nothing_is_known_when_every_run_failed() -> None:
    found = probability(*bounds(np.full((6, 3), np.nan)))
    assert found.value.tolist() == [0.5] * 3
    assert found.low.tolist() == [0.0] * 3
    assert found.high.tolist() == [1.0] * 3


def test_mirrored_wires_count_twice() -> None:
    values = np.array([[[0.1, 0.5]]])
    copies = np.array([1, 2])
    assert mean_of(values, copies)[0, 0] == pytest.approx((0.1 + 1.0) / 3)


def test_crossing_is_linear_between_steps() -> None:
    x = np.array([0.0, 10.0, 20.0])
    assert crossing(x, np.array([0.0, 0.25, 0.75])) == pytest.approx(15.0)
    assert crossing(x, np.array([0.0, 0.1, 0.2])) is None


def test_rank_correlation_is_spearmans_and_its_interval_covers_it() -> None:
    rng = np.random.default_rng(4)
    x = rng.normal(size=200)
    y = np.exp(x + rng.normal(size=200))
    found = rank_correlation(x, y)
    assert found is not None
    assert found.value == pytest.approx(stats.spearmanr(x, y).statistic)
    assert found.low < found.value < found.high
    assert found.high - found.low == pytest.approx(4 * np.sqrt((1 + found.value**2 / 2) / 197) * 0.5, rel=0.35)
    assert found.matters


def test_an_input_that_does_nothing_is_said_not_to_matter() -> None:
    rng = np.random.default_rng(5)
    found = [rank_correlation(rng.normal(size=80), rng.normal(size=80)) for _ in range(40)]
    assert np.mean([item is not None and item.matters for item in found]) < 0.15


def test_specimens_without_failure_are_ranked_last_and_constants_not_at_all() -> None:
    x = np.arange(20.0)
    found = rank_correlation(x, np.where(x < 10, x, np.inf))
    assert found is not None
    assert 0.9 < found.value < 1.0
    assert rank_correlation(x, np.ones(20)) is None
    assert rank_correlation(x[:5], x[:5]) is None


def test_paired_differences_have_students_interval() -> None:
    rng = np.random.default_rng(1)
    base = rng.random(30)
    a, b = base, base - 0.1 + 0.02 * rng.normal(size=30)
    found = mean_difference((a, a), (b, b))
    expected = stats.ttest_rel(b, a).confidence_interval(0.95)
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high))
    assert found.value == pytest.approx(np.mean(b - a))
    assert found.high < 0.0


def test_differences_of_events_allow_for_what_was_not_seen() -> None:
    same = np.ones(20)
    found = difference((same, same), (same, same))
    assert found.value == 0.0
    assert found.low == pytest.approx(-found.high)
    assert 0.05 < found.high < 0.3


def test_failed_runs_widen_a_difference_to_both_sides() -> None:
    a = np.full((20, 1), 0.5)
    unknown = (np.zeros((20, 1)), np.ones((20, 1)))
    found = mean_difference((a, a), unknown)
    assert (found.low[0], found.value[0], found.high[0]) == pytest.approx((-0.5, 0.0, 0.5))
