"""The closed-form coupon: the same curve as the solver's law, exact derivatives, elastic unloading."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.identify.coupon import loading_curve, pull, true_stress, unloading_line
from etextile.laws.powerlaw import PowerLaw


LAWS = {
    "progressive": PowerLaw(3000.0, 0.2, 9960.0, 1.5),
    "linear": PowerLaw(4500.0, 0.2, 4230.0, 1.0),
    "degressive": PowerLaw(1500.0, 0.5, 300.0, 0.4),
}
STEP = 1e-6


@pytest.mark.parametrize("name", LAWS)
def test_loading_is_the_curve_of_the_solvers_law(name: str) -> None:
    strain = np.linspace(0.0, 0.3, 31)
    ours = loading_curve(LAWS[name], np.log1p(strain)).stress
    np.testing.assert_allclose(ours, LAWS[name].loading_curve(strain), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", LAWS)
def test_slopes_are_the_derivatives_of_loading_and_unloading(name: str) -> None:
    law, eps = LAWS[name], np.linspace(0.01, 0.2, 12)
    pairs = [
        (replace(law, E=law.E * np.exp(STEP)), replace(law, E=law.E * np.exp(-STEP)), 0.0),
        (replace(law, H=law.H * np.exp(STEP)), replace(law, H=law.H * np.exp(-STEP)), 0.0),
        (replace(law, n=law.n + STEP), replace(law, n=law.n - STEP), 0.0),
        (law, law, STEP),
    ]
    down = np.linspace(0.19, 0.2, 5)
    slopes, line_slopes = loading_curve(law, eps).slopes, unloading_line(law, down, from_hencky=0.2)[1]
    for column, (more, less, shift) in enumerate(pairs):
        rate = (loading_curve(more, eps + shift).stress - loading_curve(less, eps - shift).stress) / (2.0 * STEP)
        np.testing.assert_allclose(slopes[:, column], rate, rtol=1e-5, atol=1e-5 * abs(rate).max())
        up, low = (
            unloading_line(item, down + sign * shift, from_hencky=0.2 + sign * shift)[0]
            for item, sign in ((more, 1.0), (less, -1.0))
        )
        rate = (up - low) / (2.0 * STEP)
        np.testing.assert_allclose(line_slopes[:, column], rate, rtol=1e-5, atol=1e-5 * abs(rate).max())


def test_unloading_starts_on_the_loading_curve_and_ends_slack_at_the_plastic_strain() -> None:
    law, turning = LAWS["progressive"], 0.12
    top = loading_curve(law, np.array([turning]))
    p = float(top.plastic_strain[0])
    stress, _ = unloading_line(law, np.array([turning, p, 0.5 * p]), from_hencky=turning)
    np.testing.assert_allclose(stress, [top.stress[0], 0.0, 0.0], rtol=1e-12)


def test_a_pull_is_in_time_order_and_scaled_by_the_area_ratio() -> None:
    strain, stress = pull(LAWS["progressive"], 0.12, area_ratio=3.6, loading=60, unloading=20)
    assert strain.shape == (81,)
    assert np.all(np.diff(strain[:61]) > 0.0)
    assert np.all(np.diff(strain[60:]) < 0.0)
    np.testing.assert_allclose(3.6 * stress[:61], LAWS["progressive"].loading_curve(strain[:61]), rtol=1e-12)
    assert abs(stress[-1]) < 1e-9


def test_true_stress_of_a_measured_curve_is_that_of_the_law() -> None:
    law, eps = LAWS["progressive"], np.linspace(0.0, 0.15, 20)
    curve = loading_curve(law, eps)
    np.testing.assert_allclose(true_stress(eps, curve.stress, E=law.E), curve.true_stress, rtol=1e-10, atol=1e-12)


def test_the_estimated_fabric_carries_its_anchor_stress() -> None:
    """`estimated_mid`, warp: 40 MPa fabric stress at 12 % strain with A_n = 0.0561, A_0 = 0.0155 mm2."""
    _, stress = pull(LAWS["progressive"], 0.12, area_ratio=0.0561 / 0.0155)
    assert stress.max() == pytest.approx(40.0, abs=0.1)
