"""Motion of a joint: skin that turns with it, cuffs, and the moment as the derivative of what contact stores."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.contact.contact import Contact
from etextile.contact.limb import Limb
from etextile.motion.flexion import Cuffs, Flexion
from etextile.types import Array


LIMB = Limb(40.0, (48.0, 150.0), (34.0, 150.0))
STEP = 1e-4


@pytest.fixture
def motion() -> Flexion:
    return Flexion(LIMB, donning=6.0)


def on_the_skin(motion: Flexion, travel: float, count: int = 60) -> Array:
    """Points on the outer side of the limb at a travel."""
    points = np.random.default_rng(3).uniform([-110.0, -30.0, -30.0], [110.0, 30.0, 60.0], (count, 3))
    for _ in range(30):
        found = motion.posed(LIMB, travel).distance(points)
        points = points - found.gap[:, None] * found.normal
    return points


def test_skin_far_from_the_joint_turns_with_its_segment(motion: Flexion) -> None:
    ends = np.array([[-130.0, 0.0, 45.0], [130.0, 0.0, 35.0]])
    assert motion.share(ends, 0.0) == pytest.approx([-0.5, 0.5])


def test_skin_carried_there_and_back_is_where_it_was(motion: Flexion) -> None:
    points = on_the_skin(motion, 60.0)
    there = motion.carried(points, 60.0, 120.0)
    assert motion.carried(there, 120.0, 60.0) == pytest.approx(points, abs=1e-9)
    assert np.abs(there - points).max() > 10.0


def test_skin_on_a_limb_of_constant_radius_stays_on_it_and_is_stretched_as_stated() -> None:
    limb = Limb(40.0, (40.0, 200.0), (40.0, 200.0))
    motion = Flexion(limb)
    line = np.stack([np.linspace(-2.0, 2.0, 3), np.zeros(3), np.full(3, 40.0)], axis=1)
    bent = motion.carried(line, 0.0, 120.0)
    length = float(np.linalg.norm(np.diff(bent, axis=0), axis=1).sum())
    assert length / 4.0 - 1.0 == pytest.approx(40.0 * np.radians(120.0) / 200.0, rel=2e-3)


@pytest.mark.parametrize("friction", [0.0, 1e9], ids=["frictionless", "held"])
@pytest.mark.parametrize("travel", [-3.0, 60.0], ids=["growing", "bending"])
def test_moment_is_the_derivative_of_the_contact_energy(motion: Flexion, friction: float, travel: float) -> None:
    x = on_the_skin(motion, travel) * [1.0, 0.99, 0.995]
    nodes = np.arange(len(x))[:, None]
    contact = Contact(nodes, np.ones(len(x)), LIMB, motion, friction, 0.02, 30.0)
    before = contact.respond(x, travel - 0.05, contact.initial_state()).state
    response = contact.respond(x, travel, before)

    def stored(at: float) -> float:
        energy = contact.respond(x, at, before).energy()
        return energy.contact + energy.friction

    slope = (stored(travel + STEP) - stored(travel - STEP)) / (2 * STEP)
    assert response.penetration > 0.01
    assert response.driving_force == pytest.approx(slope, rel=1e-3)  # the tangent plane turns too: second order


def test_cuffs_follow_their_rate() -> None:
    motion = Flexion(LIMB, donning=4.0)
    start = np.array([[-120.0, 10.0, 30.0], [120.0, 0.0, 33.0]])
    cuffs = Cuffs(motion, np.array([0, 1]), start, 1.1 * start, np.array([-0.5, 0.5]))
    for travel in (-2.0, 50.0):
        slope = (cuffs.positions(travel + STEP) - cuffs.positions(travel - STEP)) / (2 * STEP)
        assert cuffs.rate(travel) == pytest.approx(slope, abs=1e-6)
    grown = np.linalg.norm(1.1 * start, axis=1)
    assert np.linalg.norm(cuffs.positions(100.0), axis=1) == pytest.approx(grown)


def test_friction_in_the_crook_is_mu_of_what_presses_and_lies_in_the_skin(motion: Flexion) -> None:
    """Where the segments are blended the gradient of the distance is shorter than one: 0.7 to 0.8 in the crook."""
    crook = np.array([[0.0, 0.0, -60.0], [1.0, 8.0, -60.0], [-3.0, -15.0, -60.0]])
    for _ in range(60):
        found = motion.posed(LIMB, 90.0).distance(crook)
        crook = crook - (found.gap + 0.01)[:, None] * found.normal / (found.normal**2).sum(axis=1)[:, None]
    contact = Contact(np.arange(3)[:, None], np.ones(3), LIMB, motion, 0.3, 0.02, 30.0)
    aside = contact.respond(crook + np.array([3.0, 2.0, 0.0]), 90.0, contact.initial_state())
    state = replace(aside.state, anchor=crook + np.array([3.0, 2.0, 1.0]), anchored=np.ones(3, dtype=bool), travel=90.0)
    response = contact.respond(crook, 90.0, state)
    steep = np.linalg.norm(response.found.normal, axis=1)
    assert steep.max() < 0.9
    outward = response.found.normal / steep[:, None]
    pushes = np.einsum("ij,ij->i", response.forces, outward)
    drags = np.linalg.norm(response.forces - pushes[:, None] * outward, axis=1)
    assert pushes == pytest.approx(steep * response.pressure, rel=1e-9)
    assert drags == pytest.approx(0.3 * pushes, rel=1e-9)
