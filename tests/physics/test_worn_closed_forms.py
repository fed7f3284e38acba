"""A yarn over a bending joint by closed forms: strain, moment, friction, cycle, moving frame; the sleeve's pressure.

A limb of constant radius r whose hinge lies on its axis bends by theta; a yarn runs along its outer side between ends
held at distances a and b from the hinge. Cells of 11 mm are those of the shipped sleeves.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from etextile.contact.body import Body, Distance
from etextile.contact.contact import Contact
from etextile.contact.limb import Limb
from etextile.contact.pose import PlacedBody, rotation_matrix
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.motion.flexion import Cuffs, Flexion
from etextile.motion.protocol import STILL, BodyMotion, Touch
from etextile.solve.newton import Settings
from etextile.solve.path import Increment, advance
from etextile.types import Array, IntArray


ELASTIC = PowerLaw(1e4, 1e9, 1e5, 1.0)  # its yield stress is out of reach
PLASTIC = PowerLaw(3000.0, 0.2, 400.0, 0.8)
RADIUS, A, B = 40.0, 121.0, 121.0
SHIPPED = 22
"""Elements of 11 mm."""

Yarns = Callable[..., Model]


def bent(
    yarns: Yarns,
    angles: tuple[float, ...],
    *,
    elements: int = SHIPPED,
    friction: float = 0.0,
    law: PowerLaw = ELASTIC,
    lower_share: float = 0.5,
    skin: float = 100.0,
    slack: float = 0.0,
    moved: tuple[Array, Array] | None = None,
    settings: Settings | None = None,
) -> list[Increment]:
    """Bend the joint by way of `angles` (deg) under a yarn held at its ends, longer than its way by `slack`.

    moved: rotation (3, 3) and shift (3,) mm of the whole case in space.
    """
    limb = Limb(RADIUS, (RADIUS, 200.0), (RADIUS, 200.0), lower_share=lower_share, skin_length=2.0 * skin)
    motion = Flexion(limb)
    count = elements + 1
    points = np.stack([np.linspace(-A, B, count), np.zeros(count), np.full(count, RADIUS)], axis=1)
    free = np.zeros((count, 3), dtype=bool)
    free[1:-1, [0, 2]] = True
    inner = np.arange(1, count - 1)
    contact = Contact(inner[:, None], np.ones(count - 2), limb, motion, friction, 1e-3, 1e4)
    model = yarns(
        points, laws=(law,), free=free, carried=np.zeros((count, 3)), travel=angles, direction=(0.0, 0.0, 0.0),
        contact=contact,
    )  # fmt: skip
    ends = np.array([0, count - 1])
    guide = Cuffs(motion, ends, points[ends], points[ends], np.array([lower_share - 1.0, lower_share]))
    block = model.truss_blocks[0]
    own = (1.0 + slack) * block.rest_length
    block = replace(block, rest_length=own, span=own)
    model = replace(model, guide=guide, contributions=(block, contact))
    return list(advance(model if moved is None else elsewhere(model, contact, *moved), settings))


def elsewhere(model: Model, contact: Contact, rotation: Array, shift: Array) -> Model:
    """Return the case turned and shifted: yarn, limb, hinge and cuffs; all components of the yarn are free."""
    flexion = contact.motion
    assert isinstance(flexion, Flexion)
    assert isinstance(model.guide, Cuffs)
    motion = MovedFlexion(flexion, rotation, shift)
    touching = replace(contact, motion=motion, body=PlacedBody(contact.body, rotation, shift))
    held = model.fixed.any(axis=1) & ~model.fixed[:, [0, 2]].any(axis=1)  # only y was held, which nothing moves
    return replace(
        model,
        points=motion.there(model.points),
        fixed=np.where(held[:, None], False, model.fixed),
        guide=MovedCuffs(model.guide, motion),
        contributions=(model.contributions[0], touching),
    )


@dataclass(frozen=True)
class MovedFlexion(BodyMotion):
    """A flexion whose hinge stands somewhere else."""

    own: Flexion
    rotation: Array
    shift: Array
    direction: Array = field(default_factory=STILL.copy)

    def there(self, points: Array) -> Array:
        return points @ self.rotation.T + self.shift

    def back(self, points: Array) -> Array:
        return (points - self.shift) @ self.rotation

    def place(self, x: Array, travel: float) -> Array:
        return x

    def posed(self, body: Body, travel: float) -> Body:
        assert isinstance(body, PlacedBody)
        return PlacedBody(self.own.posed(body.body, travel), self.rotation, self.shift)

    def carried(self, anchor: Array, before: float, travel: float) -> Array:
        return self.there(self.own.carried(self.back(anchor), before, travel))

    def driving_force(self, body: Body, travel: float, touch: Touch, *, onward: bool = False) -> float:
        assert isinstance(body, PlacedBody)
        turned = (touch.found.normal @ self.rotation, self.rotation.T @ touch.found.hessian @ self.rotation)
        own = Touch(
            self.back(touch.place), Distance(touch.found.gap, *turned), touch.pressure, self.back(touch.anchor),
            touch.traction @ self.rotation,
        )  # fmt: skip
        return self.own.driving_force(body.body, travel, own, onward=onward)

    def longest_step(self, body: Body) -> float:
        assert isinstance(body, PlacedBody)
        return self.own.longest_step(body.body)

    def surroundings(self, body: Body) -> Array:
        assert isinstance(body, PlacedBody)
        reach = float(np.abs(self.own.surroundings(body.body)).max()) * np.sqrt(3.0)
        return np.stack([self.shift - reach, self.shift + reach])


@dataclass(frozen=True)
class MovedCuffs:
    """The cuffs that go with a moved flexion."""

    own: Cuffs
    motion: MovedFlexion

    @property
    def nodes(self) -> IntArray:
        return self.own.nodes

    def positions(self, travel: float) -> Array:
        return self.motion.there(self.own.positions(travel))

    def rate(self, travel: float, *, onward: bool = False) -> Array:
        return self.own.rate(travel, onward=onward) @ self.motion.rotation.T


def outputs(increments: list[Increment]) -> list[Increment]:
    return [item for item in increments if item.output]


@pytest.mark.parametrize("angle", [60.0, 120.0])
def test_without_friction_strain_is_the_same_all_along_and_moment_is_radius_times_tension(
    yarns: Yarns, angle: float
) -> None:
    """Strain = r theta / (a + b), M = r T."""
    errors, moments, spread = [], [], []
    for elements in (SHIPPED, 2 * SHIPPED):
        last = bent(yarns, (angle,), elements=elements)[-1]
        strain = last.truss_strain
        spread.append(float(np.ptp(strain) / strain.mean()))
        errors.append(abs(float(strain.mean()) * (A + B) / (RADIUS * np.radians(angle)) - 1.0))
        moments.append(abs(np.degrees(last.punch_force_N) / (RADIUS * float(last.truss_force.mean())) - 1.0))
    assert spread[0] < 0.015
    assert spread[1] < 0.6 * spread[0] + 1e-6
    assert errors[0] < 0.01
    assert moments[0] < 0.012
    assert errors[1] < 0.4 * errors[0]
    assert moments[1] < 0.5 * moments[0] + 1e-4


def test_with_friction_tension_falls_from_the_middle_of_the_arc_to_its_ends(yarns: Yarns) -> None:
    """T(middle) / T(end) = exp(mu theta / 2); where the skin is straight the tension is constant.

    One element lies across the middle, so that whole turns lie between it and the ends. The skin stretches by 0.35
    there, more than the yarn does anywhere, so that it slides all along the arc.
    """
    mu, angle = 0.3, 60.0
    for elements, allowed in ((SHIPPED - 1, 0.02), (4 * SHIPPED + 1, 0.005)):
        force = bent(yarns, tuple(np.arange(10.0, angle + 1.0, 10.0)), elements=elements, friction=mu, skin=60.0)[
            -1
        ].truss_force
        for end in (force[:2], force[-2:]):
            assert np.ptp(end) < 2e-3 * end.mean()
            assert float(force.max() / end.mean()) == pytest.approx(np.exp(mu * np.radians(angle) / 2.0), rel=allowed)


def test_a_second_flexion_follows_the_unloading_line(yarns: Yarns) -> None:
    increments = outputs(bent(yarns, (30.0, 60.0, 45.0, 30.0, 45.0, 60.0), law=PLASTIC))
    force = np.array([item.punch_force_N for item in increments])
    assert force[3] < 0.5 * force[0]  # plastic flow: less force at the same angle
    assert force[4] == pytest.approx(force[2], rel=1e-4)
    assert force[5] == pytest.approx(force[1], rel=1e-3)
    plastic = np.array([item.energy.plastic for item in increments])
    assert plastic[5] == pytest.approx(plastic[1], rel=1e-6)
    assert increments[-1].energy.external - increments[1].energy.external == pytest.approx(
        0.0, abs=2e-2 * plastic[1] + increments[-1].energy.work_doubt
    )


@pytest.mark.parametrize("friction", [0.0, pytest.param(0.3, marks=pytest.mark.slow)])
def test_it_does_not_matter_which_segment_moves(yarns: Yarns, friction: float) -> None:
    """Flexing the lower, the upper or both segments differs by a turn in space."""
    fine = Settings(tolerance=1e-13, force_floor=1e-7)
    angles = (15.0,)
    both, upper, lower = (
        bent(yarns, angles, friction=friction, lower_share=share, settings=fine)[-1] for share in (0.5, 0.0, 1.0)
    )
    for other in (upper, lower):
        assert other.truss_strain == pytest.approx(both.truss_strain, abs=1e-9)
        assert other.punch_force_N == pytest.approx(both.punch_force_N, rel=1e-7)


@pytest.mark.slow
def test_the_case_turned_and_shifted_in_space_gives_the_same(yarns: Yarns) -> None:
    fine = Settings(tolerance=1e-13, force_floor=1e-7)
    moved = (rotation_matrix((25.0, -40.0, 70.0)), np.array([310.0, -45.0, 120.0]))
    here = bent(yarns, (15.0,), friction=0.3, settings=fine)[-1]
    there = bent(yarns, (15.0,), friction=0.3, moved=moved, settings=fine)[-1]
    assert here.truss_strain.max() > 0.04
    assert there.truss_strain == pytest.approx(here.truss_strain, abs=1e-9)
    assert there.punch_force_N == pytest.approx(here.punch_force_N, rel=1e-7)


def test_a_loose_yarn_carries_nothing_until_the_way_over_the_joint_needs_it(yarns: Yarns) -> None:
    """With the slack s it bears from r theta = s (a + b), 34.7 degrees: strain (r theta / (a + b) - s) / (1 + s)."""
    slack, span, errors = 0.1, A + B, []
    for elements in (SHIPPED, 2 * SHIPPED):
        early, late = outputs(bent(yarns, (30.0, 60.0), elements=elements, slack=slack))
        assert early.truss_force.max() < 1e-6 * late.truss_force.max()
        assert abs(early.punch_force_N) < 1e-6 * late.punch_force_N
        strain = (RADIUS * np.radians(60.0) - slack * span) / ((1.0 + slack) * span)
        errors.append(abs(float(late.truss_strain.mean()) / strain - 1.0))
    assert errors[0] < 0.01
    assert errors[1] < 0.4 * errors[0]
