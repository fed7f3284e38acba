"""Random numbers: from the seed alone, evenly spread, the same in larger ensembles."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.ensemble.inputs import COLUMNS
from etextile.ensemble.sample import METHODS, Method, local_normal, unit_rows


@pytest.mark.parametrize("method", METHODS)
def test_rows_depend_on_the_seed_alone(method: Method) -> None:
    rows = unit_rows(20, seed=5, method=method)
    assert rows.shape == (20, len(COLUMNS))
    assert np.array_equal(rows, unit_rows(20, seed=5, method=method))
    assert not np.array_equal(rows, unit_rows(20, seed=6, method=method))


@pytest.mark.parametrize("count", [1, 2, 7, 33])
def test_a_larger_sobol_ensemble_contains_the_smaller(count: int) -> None:
    assert np.array_equal(unit_rows(count, seed=1), unit_rows(100, seed=1)[:count])


@pytest.mark.parametrize("method", METHODS)
def test_every_input_is_spread_over_its_whole_range(method: Method) -> None:
    counts = [np.bincount((column * 32).astype(int), minlength=32) for column in unit_rows(32, seed=2, method=method).T]
    assert all((count == 1).all() for count in counts)


def test_means_converge_faster_than_those_of_random_numbers() -> None:
    error = [abs(np.prod(unit_rows(256, seed=seed)[:, :3], axis=1).mean() - 0.125) for seed in range(20)]
    random = [abs(np.prod(np.random.default_rng(seed).random((256, 3)), axis=1).mean() - 0.125) for seed in range(20)]
    assert np.mean(error) < 0.2 * np.mean(random)


def test_numbers_of_loops_belong_to_seed_sample_and_wire() -> None:
    five = local_normal(5, seed=1, sample=2, place=3, reach=3.0)
    assert np.array_equal(five, local_normal(9, seed=1, sample=2, place=3, reach=3.0)[:5])
    others = [local_normal(5, seed=a, sample=b, place=c, reach=3.0) for a, b, c in ((2, 2, 3), (1, 3, 3), (1, 2, 4))]
    assert all(not np.any(np.isclose(five, other)) for other in others)
    many = np.concatenate([local_normal(50, seed=1, sample=k, place=0, reach=3.0) for k in range(40)])
    assert np.std(many) == pytest.approx(1.0, abs=0.05)
    assert np.abs(many).max() <= 3.0
