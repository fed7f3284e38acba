"""Integrals over the parameters of a hypothesis, against Gaussians and a bent ridge with known integrals."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import erf

from etextile.diagnose.infer.integrate import integrate, parabola
from etextile.types import Array


def ridge(centre: Array, covariance: Array):  # type: ignore[no-untyped-def]
    precise = np.linalg.inv(covariance)
    return lambda x: -0.5 * np.einsum("bi,ij,bj->b", x - centre, precise, x - centre)


@pytest.mark.parametrize("d", [1, 2, 3, 4, 6])
@pytest.mark.parametrize("width", [0.004, 0.03])
def test_a_narrow_correlated_ridge_is_found_and_integrated(d: int, width: float) -> None:
    """Correlation 0.98 between the first and the last parameter; the mean over the unit box is known."""
    correlation = np.eye(d)
    if d > 1:
        correlation[0, -1] = correlation[-1, 0] = -0.98
    covariance = width**2 * correlation
    centre = np.linspace(0.62, 0.41, d)
    found = integrate(ridge(centre, covariance), np.tile([0.0, 1.0], (d, 1)))
    assert found is not None
    assert found.log_mean == pytest.approx(0.5 * np.linalg.slogdet(2.0 * np.pi * covariance)[1], abs=0.2)
    assert found.log_best == pytest.approx(0.0, abs=0.05)
    assert found.best == pytest.approx(centre, abs=0.5 * width)
    spread = np.sqrt(found.weights @ (found.points - found.weights @ found.points) ** 2)
    assert spread == pytest.approx(np.full(d, width), rel=0.25)


def test_a_bent_ridge_has_its_exact_integral() -> None:
    """Log L = -(y - x^2)^2 / 2 s^2: over x in (0, 1), y in (-1, 2) the mean is s sqrt(2 pi) / 3."""
    s = 0.01
    found = integrate(lambda p: -0.5 * ((p[:, 1] - p[:, 0] ** 2) / s) ** 2, np.array([[0.0, 1.0], [-1.0, 2.0]]))
    assert found is not None
    assert found.log_mean == pytest.approx(np.log(s * np.sqrt(2.0 * np.pi) / 3.0), abs=0.2)


def test_a_maximum_at_the_end_of_the_range_counts_by_what_is_inside() -> None:
    covariance = np.diag([0.02, 0.05]) ** 2
    found = integrate(ridge(np.array([1.01, 0.5]), covariance), np.tile([0.0, 1.0], (2, 1)))
    assert found is not None
    inside = 0.5 * (1.0 + erf(-0.5 / np.sqrt(2.0)))
    expected = np.log(inside) + 0.5 * np.linalg.slogdet(2.0 * np.pi * covariance)[1]
    assert found.log_mean == pytest.approx(expected, abs=0.15)
    assert found.points.max() <= 1.0


def test_a_wrong_guide_costs_points_but_no_accuracy() -> None:
    covariance = np.diag([0.02, 0.03, 0.02]) ** 2
    exact, aside = (ridge(np.full(3, 0.5) + shift, covariance) for shift in (0.0, 0.05))
    found = integrate(exact, np.tile([0.0, 1.0], (3, 1)), guide=aside)
    assert found is not None
    assert found.log_mean == pytest.approx(0.5 * np.linalg.slogdet(2.0 * np.pi * covariance)[1], abs=0.25)


def test_an_impossible_box_has_no_integral() -> None:
    for d in (1, 2):
        assert integrate(lambda x: np.full(len(x), -np.inf), np.tile([0.0, 1.0], (d, 1))) is None


def test_the_parabola_through_gaussian_points_is_the_gaussian() -> None:
    rng = np.random.default_rng(2)
    covariance = np.array([[0.04, 0.018], [0.018, 0.01]])
    points = rng.multivariate_normal([0.2, 0.8], covariance, 400)
    shape = parabola(points, ridge(np.array([0.2, 0.8]), covariance)(points))
    assert shape is not None
    centre, hessian = shape
    assert centre == pytest.approx([0.2, 0.8], abs=1e-6)
    np.testing.assert_allclose(np.linalg.inv(-hessian), covariance, rtol=1e-6)
    assert parabola(points, -ridge(np.array([0.2, 0.8]), covariance)(points)) is None
