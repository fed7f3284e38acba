"""Noise that nobody stated: of three specimens the odd one counts for less, of two nothing tells which one is odd."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.diagnose.data.measured import Measurements
from etextile.studies.calibrate.observed import Observed
from etextile.studies.calibrate.study import _noise


SHAPE = np.linspace(1.0, 4.0, 8)
FACTORS = (0.85, 1.0, 1.02)
"""Heights of three specimens over a common shape; the first is the odd one."""


@pytest.fixture
def observed() -> Observed:
    value = np.concatenate([factor * SHAPE for factor in FACTORS])
    number = np.repeat(np.arange(3), len(SHAPE))
    empty = Measurements.__new__(Measurements)
    channel = np.ones(len(value), dtype=np.int64)
    return Observed(empty, value, np.tile(SHAPE, 3), number, channel, np.full(len(value), np.nan), ("a", "b", "c"))


def settled(observed: Observed, mask: np.ndarray) -> float:
    """Return the factor that weighted least squares come to rest at, noise taken anew from the residuals each time."""
    shape, noise = np.tile(SHAPE, 3), _noise(observed, None, mask)
    factor = 1.0
    for _ in range(4):
        weight = (mask / noise**2) * shape
        factor = float(weight @ observed.value / (weight @ shape))
        noise = _noise(observed, factor * shape, mask)
    return factor


def test_the_odd_one_of_three_hardly_moves_the_fit(observed: Observed) -> None:
    everything = np.ones(len(observed.value), dtype=bool)
    assert settled(observed, everything) > 0.99
    assert np.mean(FACTORS) < 0.96


def test_of_two_the_fit_lies_between(observed: Observed) -> None:
    """What is left out has no say, however far it lies off."""
    mask = observed.specimen != 1
    assert settled(observed, mask) == pytest.approx(0.5 * (FACTORS[0] + FACTORS[2]), rel=1e-9)
