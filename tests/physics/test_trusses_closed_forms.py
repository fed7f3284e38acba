"""Trusses against closed forms written down here once more, without the code of the law: bars, yarn, trellis."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.optimize import brentq

from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.solve.path import Increment, advance
from etextile.types import Array


WARP = PowerLaw(3000.0, 0.2, 9960.0, 1.5)
WEFT = PowerLaw(4500.0, 0.2, 4230.0, 1.1)


def plastic(law: PowerLaw, eps: float) -> float:
    """Plastic strain p with E (eps - p) = sigma_y0 p / (p + e0) + H p^n."""
    if eps <= 0.0:
        return 0.0
    return float(
        brentq(lambda p: law.E * (eps - p) - law.sigma_y0 * p / (p + law.e0) - law.H * p**law.n, 0.0, eps, xtol=1e-15)
    )


def force(law: PowerLaw, stretch: float, peak: float) -> float:
    """Force of a truss of 1 mm2 at l / l0 = `stretch` after it has seen the stretch `peak`: E (eps - p) exp(-p)."""
    p = plastic(law, np.log(max(stretch, peak)))
    return max(law.E * (np.log(stretch) - p), 0.0) * float(np.exp(-p))


def steps(model: Model) -> list[Increment]:
    return [step for step in advance(model) if step.output]


def test_a_two_bar_truss_loaded_and_unloaded(yarns: Callable[..., Model]) -> None:
    """Bars of two laws and lengths meet in a hinge lifted at z and free along x, where their pulls balance."""
    points = np.array([[-30.0, 0.0, 0.0], [20.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    free = np.zeros((3, 3), dtype=bool)
    free[2, 0] = True
    carried = np.zeros((3, 3))
    carried[2, 2] = 1.0
    travel = (2.0, 5.0, 10.0, 9.6, 9.2)
    trusses = np.array([[0, 2], [1, 2]])
    model = yarns(
        points, laws=(WARP, WEFT), free=free, carried=carried, travel=travel, direction=(0.0, 0.0, 1.0),
        trusses=trusses, law=np.array([0, 1]),
    )  # fmt: skip
    rest = np.linalg.norm(points[trusses[:, 1]] - points[trusses[:, 0]], axis=1)
    peak = np.ones(2)
    for step, height in zip(steps(model), np.array(travel) + 1.0, strict=True):

        def pulls(x: float, height: float = height, peak: Array = peak) -> tuple[Array, Array]:
            arms = np.array([x, 0.0, height]) - points[:2]
            length = np.linalg.norm(arms, axis=1)
            bars = [force(law, *pair) for law, *pair in zip((WARP, WEFT), length / rest, peak, strict=True)]
            return (np.array(bars) / length) @ arms, length / rest

        x = brentq(lambda x: pulls(x)[0][0], -5.0, 5.0, xtol=1e-13)
        wanted, stretch = pulls(x)
        assert step.positions[2, 0] == pytest.approx(x, abs=1e-5)
        assert step.punch_force_N == pytest.approx(wanted[2], rel=1e-6)
        peak = np.maximum(peak, stretch)
    assert wanted[2] > 0.0


def test_a_yarn_stretched_released_until_slack_and_stretched_again(yarns: Callable[..., Model]) -> None:
    count, length = 9, 40.0
    points = np.stack([np.linspace(0.0, length, count), np.zeros(count), np.zeros(count)], axis=1)
    free = np.ones((count, 3), dtype=bool)
    free[[0, -1]] = False
    carried = np.zeros((count, 3))
    carried[-1, 0] = 1.0
    peak = plastic(WARP, np.log(1.15))
    slack = length * (np.exp(peak) - 1.0)
    travel = (0.4, 2.0, 6.0, 5.9, 5.8, slack - 0.2, 5.9, 7.0)
    seen = 1.0
    for step in steps(yarns(points, laws=(WARP,), free=free, carried=carried, travel=travel)):
        stretch = 1.0 + step.displacement_mm / length
        assert step.punch_force_N == pytest.approx(force(WARP, stretch, seen), rel=1e-6, abs=1e-3)
        seen = max(seen, stretch)
        assert step.truss_plastic_strain == pytest.approx(plastic(WARP, np.log(seen)), rel=1e-4)


def test_a_sheared_trellis_is_held_by_its_long_diagonal(yarns: Callable[..., Model]) -> None:
    """Stiff sides a, b hinged at their ends; the far corner moves by u: L^2 = a^2 + b^2 + 2 a u, force F(L) a / L."""
    a, b = 5.0, 3.0
    points = np.array([[0.0, 0.0, 0.0], [a, 0.0, 0.0], [0.0, b, 0.0], [a, b, 0.0]])
    trusses = np.array([[0, 1], [2, 3], [0, 2], [1, 3], [0, 3], [1, 2]])
    stiff = PowerLaw(1e8, 0.0, 1e8, 1.0, compression_ratio=1.0)
    diagonal = PowerLaw(1500.0, 0.2, 1550.0, 2.2)
    free = np.zeros((4, 3), dtype=bool)
    free[2, :2] = True
    free[3, 1] = True
    carried = np.zeros((4, 3))
    carried[3, 0] = 1.0
    rest = float(np.hypot(a, b))
    model = yarns(
        points, laws=(stiff, diagonal), free=free, carried=carried, travel=(0.3, 0.8, 1.5), trusses=trusses,
        law=np.array([0, 0, 0, 0, 1, 1]),
    )  # fmt: skip
    for step in steps(model):
        u = step.displacement_mm
        long = np.sqrt(a**2 + b**2 + 2.0 * a * u)
        assert step.positions[3, 1] == pytest.approx(np.sqrt(b**2 - u**2), rel=1e-5)
        assert step.punch_force_N == pytest.approx(force(diagonal, long / rest, 1.0) * a / long, rel=1e-4)
        assert step.truss_force[5] == 0.0


def test_trusses_past_their_force_peak_are_counted(yarns: Callable[..., Model]) -> None:
    """Force = sigma A0 exp(-p) peaks near p = n: a yarn of n = 0.1 at 30 % is past it, one of n = 1.5 is not."""
    points = np.array([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0]])
    carried = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    free = np.zeros((2, 3), dtype=bool)
    for exponent, count in ((0.1, 1), (1.5, 0)):
        law = PowerLaw(3000.0, 0.2, 100.0, exponent)
        *_, last = steps(yarns(points, laws=(law,), free=free, carried=carried, travel=(1.0, 3.0)))
        assert last.softening == count
