"""Normalised shear force of bias coupons: an energy balance written down independently, and two sizes on one curve."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.identify.shear_force import normalised_shear_force, shear_angle
from etextile.types import Array


def coupon(length: float, width: float, *, angles: Array) -> tuple[Array, Array]:
    """Return displacement and force of an ideal coupon with the shear moment M = 0.01 gamma + 0.2 gamma^3, N."""

    def energy(angle: Array) -> Array:
        return np.asarray(0.005 * angle**2 + 0.05 * angle**4)

    reach = length - width
    displacement = reach * (np.sqrt(2.0) * np.cos(np.pi / 4.0 - angles / 2.0) - 1.0)
    step = 1e-6
    middle, corner = 0.5 * (2.0 * length - 3.0 * width) * width, width**2

    def stored(angle: Array) -> Array:
        return np.asarray(middle * energy(angle) + corner * energy(angle / 2.0))

    rate = reach * (np.cos(angles / 2.0) - np.sin(angles / 2.0)) / 2.0
    return displacement, (stored(angles + step) - stored(angles - step)) / (2.0 * step) / rate


@pytest.mark.parametrize("size", [(200.0, 100.0), (150.0, 50.0)])
def test_the_moment_that_was_put_in_comes_back(size: tuple[float, float]) -> None:
    angles = np.radians(np.linspace(0.5, 50.0, 120))
    displacement, force = coupon(*size, angles=angles)
    angle, shear = normalised_shear_force(displacement, force, size)
    assert angle == pytest.approx(angles, abs=1e-9)
    assert shear * np.cos(angles) == pytest.approx(0.01 * angles + 0.2 * angles**3, rel=0.01, abs=2e-5)


def test_two_sizes_lie_on_one_curve_though_their_forces_differ_twofold() -> None:
    angles = np.radians(np.linspace(0.5, 45.0, 90))
    found = []
    for size in ((200.0, 100.0), (300.0, 100.0)):
        displacement, force = coupon(*size, angles=angles)
        found.append((force[-1], normalised_shear_force(displacement, force, size)[1]))
    assert abs(found[0][0] / found[1][0] - 1.0) > 0.15
    assert found[0][1] == pytest.approx(found[1][1], rel=0.01, abs=2e-5)


def test_a_closed_trellis_and_a_short_coupon_are_no_numbers() -> None:
    assert np.isnan(shear_angle(np.array([45.0]), (200.0, 100.0)))[0]
    with pytest.raises(ValueError, match="no middle"):
        normalised_shear_force(np.array([1.0]), np.array([1.0]), (140.0, 100.0))
