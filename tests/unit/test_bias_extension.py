"""A shear law from bias coupons of one size foretells another: against an energy balance written down independently."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.identify.bias_extension import BiasCoupon, diagonal_law, fit_law, foretold
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


def moment(angle: Array) -> Array:
    """Friction that builds up over a degree, a flat part, locking: a dry glass weave, N/mm."""
    return np.asarray(0.004 * (1.0 - np.exp(-angle / 0.015)) + 0.005 * angle + 0.09 * angle**4)


def coupon(name: str, length: float, width: float, *, noise: float = 0.0, seed: int = 0) -> BiasCoupon:
    """A coupon whose force is the change of the energy of its zones (by trapezes) over its displacement."""
    angle = np.radians(np.linspace(0.0, 48.0, 4001))
    step = np.diff(angle)

    def energy(values: Array) -> Array:
        fine = np.linspace(0.0, 0.9, 40001)
        stored = np.concatenate([[0.0], np.cumsum(0.5 * (moment(fine[1:]) + moment(fine[:-1])) * np.diff(fine))])
        return np.interp(values, fine, stored)

    total = 0.5 * (2.0 * length - 3.0 * width) * width * energy(angle) + width**2 * energy(0.5 * angle)
    travel = (length - width) * (np.cos(angle / 2.0) + np.sin(angle / 2.0) - 1.0)
    force = np.diff(total) / np.diff(travel)
    at = np.searchsorted(travel, np.linspace(0.0, travel[-2], 120)[1:])
    assert step.min() > 0.0
    scatter = noise * force[at].max() * np.random.default_rng(seed).standard_normal(len(at))
    return BiasCoupon(name, 0.5 * (travel[at] + travel[at - 1]), force[at - 1] + scatter, (length, width))


def test_the_law_of_one_size_foretells_the_other_within_half_a_per_cent_of_the_peak() -> None:
    small, large = coupon("small", 200.0, 100.0), coupon("large", 320.0, 150.0)
    found = {item.name: item for item in foretold([small, large])}
    assert max(item.largest for item in found.values()) < 0.005
    angle = np.radians([5.0, 20.0, 40.0])
    assert fit_law([small]).at(angle) == pytest.approx(moment(angle), rel=0.03)


def test_noise_of_two_per_cent_does_not_grow() -> None:
    small, large = (
        coupon(name, *size, noise=0.02, seed=i)
        for i, (name, size) in enumerate((("s", (200.0, 100.0)), ("l", (320.0, 150.0))))
    )
    assert max(item.mean for item in foretold([small, large])) < 0.02
    law = fit_law([small, large])
    assert np.all(np.diff(law.moment) >= 0.0)


def test_diagonals_in_a_trellis_do_the_work_of_the_law() -> None:
    """A law that diagonals of the form H p^n make is found again."""
    weave = Weave(0.3, 0.2, 0.4, 0.03, warp_density=5.0, weft_density=3.3)
    start = PowerLaw(1e5, 0.0, 80.0, 1.4)
    angle = np.radians(np.linspace(0.5, 45.0, 400))
    rest = np.hypot(0.3, 0.2)
    length = np.sqrt(rest**2 + 0.12 * np.sin(angle))
    strain = np.log(length / rest)
    tension = 80.0 * strain**1.4 * np.exp(-strain) * 0.03
    travel = 100.0 * (np.cos(angle / 2.0) + np.sin(angle / 2.0) - 1.0)
    # a coupon of twice its width whose half angle is told by the law itself
    half = np.sqrt(rest**2 + 0.12 * np.sin(angle / 2.0))
    tension_half = 80.0 * np.log(half / rest) ** 1.4 * (rest / half) * 0.03
    lever = np.cos(angle / 2.0) - np.sin(angle / 2.0)
    force = (100.0 * tension * np.cos(angle) / length + 100.0 * tension_half * np.cos(angle / 2.0) / half) / lever
    law = fit_law([BiasCoupon("a", travel, force, (200.0, 100.0))])
    found, missed = diagonal_law(law, weave, start)
    assert (found.H, found.n) == (pytest.approx(80.0, rel=0.03), pytest.approx(1.4, rel=0.02))
    assert missed < 0.01


def test_a_short_coupon_has_no_middle() -> None:
    with pytest.raises(ValueError, match="no middle"):
        BiasCoupon("a", np.arange(3.0), np.arange(3.0), (140.0, 100.0))
