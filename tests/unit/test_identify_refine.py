"""Refinement against a stand-in for the virtual coupon: families that help each other, and a turned diagonal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from etextile.identify.coupon import loading_curve
from etextile.identify.refine import TargetCurve, refine, target_of
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


TRUTH = {"warp": PowerLaw(3000.0, 0.2, 9960.0, 1.5), "diagonal": PowerLaw(1500.0, 0.2, 1550.0, 2.2)}
RATIO = {"warp": 3.62, "diagonal": 3.15}
TOP = {"warp": 0.12, "diagonal": 0.4}


def coupon(family: str, laws: Mapping[str, PowerLaw], strain: Array) -> Array:
    """A lattice in miniature: diagonals take part in warp tension, and lie off the bias direction."""
    hencky = np.log1p(strain)
    own = loading_curve(laws[family], hencky).stress / RATIO[family]
    if family == "warp":
        return own + 1.6 * loading_curve(laws["diagonal"], 0.76 * hencky).stress / RATIO["diagonal"]
    return own * (1.0 + 0.3 * strain)


def targets() -> dict[str, TargetCurve]:
    return {family: target_of(law, RATIO[family], TOP[family]) for family, law in TRUTH.items()}


def test_the_simulated_coupons_return_the_targets_after_refinement() -> None:
    goal = targets()
    refined = refine(TRUTH, goal, coupon)
    assert refined.converged
    assert refined.misfit < 0.01
    assert np.abs(refined.before["diagonal"]).max() == pytest.approx(0.12, abs=0.001)
    assert refined.before["warp"][-1] > 0.01
    for family in TRUTH:
        late = slice(len(refined.after[family]) // 3, None)
        assert np.abs(refined.after[family][late]).max() < 0.02
        assert refined.laws[family].E == TRUTH[family].E


def test_laws_that_are_right_already_stay() -> None:
    def single(family: str, laws: Mapping[str, PowerLaw], strain: Array) -> Array:
        return loading_curve(laws[family], np.log1p(strain)).stress / RATIO[family]

    refined = refine(TRUTH, targets(), single)
    assert refined.converged
    for family, law in TRUTH.items():
        assert pytest.approx(law.H, rel=1e-4) == refined.laws[family].H
        assert np.abs(refined.before[family]).max() < 1e-12


def test_rounds_that_run_out_are_said_and_the_best_laws_are_kept() -> None:
    def stubborn(family: str, laws: Mapping[str, PowerLaw], strain: Array) -> Array:
        return coupon(family, {**laws, "warp": replace(laws["warp"], H=4.0 * laws["warp"].H)}, strain)

    refined = refine(TRUTH, targets(), stubborn, rounds=1)
    assert not refined.converged
    assert refined.rounds == 1
