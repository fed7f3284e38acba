"""The limb's distance: derivatives against differences, exact sizes where they are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.contact.limb import Limb


LIMB = Limb(45.0, (52.0, 150.0), (38.0, 200.0), tip=(15.0, 36.0, 5.0), flexion=1.7)
STEP = 1e-5


@pytest.fixture
def places() -> np.ndarray:
    points = np.random.default_rng(5).uniform(-120.0, 120.0, (600, 3))
    return points[LIMB.distance(points).gap > -12.0]


def difference(shape, points: np.ndarray) -> np.ndarray:
    moved = [(shape(points + STEP * axis) - shape(points - STEP * axis)) / (2 * STEP) for axis in np.eye(3)]
    return np.stack(moved, axis=1)


def test_normal_and_hessian_are_the_derivatives_of_the_gap(places: np.ndarray) -> None:
    found = LIMB.distance(places)
    assert found.normal == pytest.approx(difference(lambda x: LIMB.distance(x).gap, places), abs=1e-7)
    hessian = difference(lambda x: LIMB.distance(x).normal, places)
    assert found.hessian == pytest.approx(hessian, abs=1e-7)


def test_rate_is_the_derivative_by_the_flexion(places: np.ndarray) -> None:
    further, less = (replace(LIMB, flexion=1.7 + step) for step in (STEP, -STEP))
    rate = (further.distance(places).gap - less.distance(places).gap) / (2 * STEP)
    assert LIMB.rate(places) == pytest.approx(rate, abs=1e-6)


def test_outside_and_away_from_the_crook_the_gap_grows_as_the_distance(places: np.ndarray) -> None:
    outer = places[places[:, 2] > 60.0]
    assert len(outer) > 50
    smooth = replace(LIMB, tip=None)
    assert np.linalg.norm(smooth.distance(outer).normal, axis=1) == pytest.approx(1.0, abs=1e-12)


def test_the_outer_side_of_a_bent_limb_of_constant_radius_is_an_arc() -> None:
    limb = Limb(40.0, (40.0, 150.0), (40.0, 150.0), flexion=np.radians(120.0))
    angle = np.linspace(-np.radians(60.0), np.radians(60.0), 9)
    arc = 40.0 * np.stack([np.sin(angle), np.zeros(9), np.cos(angle)], axis=1)
    assert limb.distance(arc).gap == pytest.approx(0.0, abs=1e-12)


def test_radius_of_the_straight_limb_is_where_the_gap_is_zero() -> None:
    limb = replace(LIMB, flexion=0.0, tip=None)
    along = np.linspace(-120.0, 120.0, 25)
    side = np.stack([along, limb.radius(along), np.zeros(25)], axis=1)
    assert limb.distance(side).gap == pytest.approx(0.0, abs=1e-12)


def test_which_segment_turns_is_a_matter_of_the_frame() -> None:
    moving = replace(LIMB, lower_share=1.0)
    other = replace(LIMB, lower_share=0.0)
    angle = LIMB.flexion
    turn = np.array([[np.cos(angle), 0.0, np.sin(angle)], [0.0, 1.0, 0.0], [-np.sin(angle), 0.0, np.cos(angle)]])
    points = np.random.default_rng(1).uniform(-90.0, 90.0, (200, 3))
    assert moving.distance(points @ turn.T).gap == pytest.approx(other.distance(points).gap, abs=1e-9)


def test_a_deflated_limb_stands_inside_of_its_surface() -> None:
    points = np.random.default_rng(2).uniform(-90.0, 90.0, (50, 3))
    thin = replace(LIMB, deflated=3.0)
    assert thin.distance(points).gap == pytest.approx(LIMB.distance(points).gap + 3.0, abs=1e-12)


def test_the_drawn_surface_lies_on_the_limb() -> None:
    vertices, faces = LIMB.surface()
    assert np.abs(LIMB.distance(vertices).gap).max() < 1e-6
    assert len(faces) > 1000


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_girth_round_the_bend_is_that_of_two_cylinders_cut_at_half_the_angle(share: float) -> None:
    """Outer half: the joint's sphere; inner half: a cylinder cut at an angle, an ellipse but for the blend."""
    radius = 40.0
    limb = Limb(radius, (radius, 160.0), (radius, 160.0), crook=0.01, lower_share=share)
    for degrees in (0.0, 60.0, 90.0, 120.0):
        along = np.linspace(0.0, np.pi, 20001)
        half = np.hypot(np.cos(along), np.sin(along) / np.cos(np.radians(degrees / 2.0)))
        inner = radius * np.trapezoid(half, along)
        found = limb.bend_girth(np.radians(degrees))
        assert found == pytest.approx(np.pi * radius + inner, rel=2e-3)
