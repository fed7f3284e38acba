"""The scan finds what is there and nothing where there is only noise; the hinge says from when on, with coverage."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from etextile.diagnose.data.points import Points, Series
from etextile.diagnose.decide.localise import onset, scan
from etextile.diagnose.infer.gauss import Whitener
from etextile.types import Array
from etextile.vocabulary import FORCE


def curve(count: int = 30, specimens: int = 3) -> Points:
    series = tuple(Series(FORCE, "force", "N", i, f"punch_{i}") for i in range(specimens))
    displacement = np.tile(np.linspace(1.0, 40.0, count), specimens)
    nowhere = np.full(count * specimens, np.nan)
    return Points(
        series,
        np.repeat(np.arange(specimens), count),
        displacement,
        nowhere,
        nowhere,
        np.zeros(count * specimens),
        nowhere,
    )


def noise(points: Points) -> np.ndarray:
    """Covariance of correlated specimen scatter and white noise."""
    same = points.owner[:, None] == points.owner[None, :]
    apart = (points.displacement[:, None] - points.displacement[None, :]) / 10.0
    return np.where(same, 4.0 * np.exp(-0.5 * apart**2), 0.0) + np.eye(len(points))


@pytest.mark.slow
def test_false_alarms_of_the_scan_come_at_the_stated_rate() -> None:
    """5 % over all windows and specimens together: 300 draws of correlated noise."""
    points = curve(12, 2)
    covariance = noise(points)
    factor, whiten = np.linalg.cholesky(covariance), [Whitener.of(covariance)]
    rng = np.random.default_rng(0)
    size = np.maximum(points.displacement, 2.0)
    found = [
        scan(points, factor @ rng.normal(size=len(points)), whiten, np.ones(1), size=size, draws=200, seed=i).detected
        for i in range(300)
    ]
    assert 0.02 < np.mean(found) < 0.085


def test_a_gap_of_three_deviations_is_found_where_it_is() -> None:
    points = curve()
    covariance = noise(points)
    rng = np.random.default_rng(1)
    residual = np.linalg.cholesky(covariance) @ rng.normal(size=len(points))
    residual += np.where(points.displacement > 25.0, 12.0, 0.0)
    found = scan(points, residual, [Whitener.of(covariance)], np.ones(1), size=np.ones(len(points)))
    assert found.detected
    window, z = max(found.best, key=lambda item: abs(item[1]))
    assert z > 4.0
    assert window.low == pytest.approx(25.0, abs=5.0)
    assert window.high == pytest.approx(40.0)


@pytest.mark.slow
def test_the_onset_of_a_hinge_lies_in_its_interval_as_often_as_stated() -> None:
    """95 % intervals of 200 hinges with slope 1 from 22 mm on in unit noise."""
    displacement = np.linspace(1.0, 40.0, 60)
    rng = np.random.default_rng(2)
    hinge = np.maximum(displacement - 22.0, 0.0)
    found = [onset(displacement, hinge + rng.normal(size=60), np.eye(60)) for _ in range(200)]
    covered = np.mean([item.low <= 22.0 <= item.high for item in found])
    assert 0.90 <= covered <= 0.99
    assert np.median([item.at for item in found]) == pytest.approx(22.0, abs=0.5)
    assert np.median([item.high - item.low for item in found]) < 8.0


@pytest.mark.parametrize(
    "shape",
    [
        lambda late: np.sqrt(late),
        lambda late: 1.0 - np.exp(-late / 5.0),
        lambda late: late,
        lambda late: late**2 / 10.0,
    ],
    ids=["root", "saturating", "linear", "smooth"],
)
def test_the_onset_does_not_hang_on_how_the_gap_grows(shape: Callable[[Array], Array]) -> None:
    displacement = np.linspace(1.0, 40.0, 80)
    force = displacement**2.5 / 5.0
    gap = -0.1 * force * shape(np.maximum(displacement - 22.0, 0.0))
    noise = np.random.default_rng(4).normal(size=80)
    found = onset(displacement, gap + noise, np.eye(80), scale=force)
    assert found.at == pytest.approx(22.0, abs=1.0)


def test_an_onset_in_pure_noise_may_be_anywhere() -> None:
    rng = np.random.default_rng(3)
    found = onset(np.linspace(1.0, 40.0, 60), 0.01 * rng.normal(size=60), np.eye(60))
    assert found.high - found.low > 25.0
