"""The plan of the next measurement against closed forms: two Gaussian predictions, and more specimens of one test."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from etextile.diagnose.decide.foretell import Foretold
from etextile.diagnose.decide.plan import gain, repeats
from etextile.diagnose.predict.simulate import Request
from etextile.studies.diagnose.setting import simulator_of
from loadcases.reader import load_case


def predictions(apart: float, *, size: int = 3) -> list[Foretold]:
    """Two equally likely predictions with unit noise, `apart` standard deviations from each other in all."""
    shift = np.full(size, apart / np.sqrt(size))
    return [Foretold(name, 0.5, m, np.eye(size)) for name, m in (("one", np.zeros(size)), ("other", shift))]


@pytest.mark.parametrize("apart", [0.5, 2.0, 4.0])
def test_the_expected_probability_of_the_leader_is_that_of_the_best_guess(apart: float) -> None:
    """The likelier of two Gaussians is the right one with probability Phi(d / 2)."""
    found = gain(predictions(apart), draws=4000)
    assert found.probability == pytest.approx(norm.cdf(apart / 2.0), abs=0.01)
    assert 0.0 < found.bits < 1.0
    assert found.decisive == pytest.approx(norm.cdf((0.5 * apart**2 - np.log(1000.0)) / apart), abs=0.02)


def test_a_measurement_that_all_foretell_alike_tells_nothing_and_one_far_apart_a_bit() -> None:
    assert gain(predictions(0.0)).bits == pytest.approx(0.0, abs=1e-9)
    far = gain(predictions(40.0))
    assert (far.bits, far.probability, far.decisive) == (pytest.approx(1.0), pytest.approx(1.0), 1.0)


def test_a_wider_prediction_is_told_from_a_narrow_one_of_the_same_mean() -> None:
    wide = Foretold("wide", 0.5, np.zeros(3), 25.0 * np.eye(3))
    assert gain([predictions(0.0)[0], wide]).bits > 0.3


def test_specimens_help_against_noise_and_not_against_what_they_share() -> None:
    """Log odds are N(d^2 / 2, d^2) with d^2 = n |m|^2 / sigma^2; Phi^-1(0.8) asks for d = 4.66."""
    difference, noise = np.full(4, 0.5), np.eye(4)
    found = repeats(difference, noise, 1e-12 * np.eye(4))
    wanted = (norm.ppf(0.8) + np.sqrt(norm.ppf(0.8) ** 2 + 2.0 * np.log(1000.0))) ** 2
    assert found.specimens == int(np.ceil(wanted))
    assert repeats(difference, noise, 0.25 * np.ones((4, 4))).specimens is None


@pytest.mark.slow
def test_the_way_back_is_softer_than_the_way_there_and_has_a_key_of_its_own() -> None:
    """What was stretched plastically carries less at the same displacement; both meet at the top."""
    simulator = simulator_of(load_case("punch").case, [])
    laws = ((560.0, 0.01, 9960.0, 1.6), (560.0, 0.01, 9960.0, 1.6), (100.0, 0.01, 500.0, 2.0))
    there = Request(laws, (), 78.0, 20.0, 8)
    back = Request(laws, (), 78.0, 20.0, 8, back=14.0)
    assert there.key("case") != back.key("case")
    up, down = simulator(there), simulator(back)
    assert (down.displacement[0], down.displacement[-1]) == (14.0, 20.0)
    assert down.force[-1] == pytest.approx(up.force[-1], rel=1e-3)
    assert np.all(np.diff(down.force) > 0.0)
    assert down.force[0] < 0.8 * np.interp(14.0, up.displacement, up.force)
