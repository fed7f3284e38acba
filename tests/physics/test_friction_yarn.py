"""A yarn drawn taut over a sphere in the plane of a great circle: equal tension, capstan, convergence of both."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from etextile.contact.contact import Contact
from etextile.contact.pose import PlacedBody
from etextile.contact.sphere import Sphere
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.motion.straight import Straight
from etextile.solve.path import Increment, advance
from etextile.types import Array


YARN = PowerLaw(1e4, 1e9, 1e5, 1.0)  # elastic: its yield stress is out of reach
RADIUS = 10.0


def touching(nodes: Array, *, friction: float, direction: tuple[float, float, float]) -> Contact:
    """Contact of nodes with a sphere whose top is at z = 0 at the start, penetrated by 0.1 um at most."""
    centre = np.array([0.0, 0.0, -RADIUS])
    body = PlacedBody(Sphere(RADIUS), np.eye(3), centre)
    return Contact(nodes[:, None], np.ones(len(nodes)), body, Straight(np.array(direction)), friction, 1e-4, 1e5)


def lifted(yarns: Callable[..., Model], count: int) -> Increment:
    """Return a yarn of 60 mm clamped at its ends, a sphere pushed up by 12 mm under its middle without friction."""
    points = np.stack([np.linspace(-30.0, 30.0, count), np.zeros(count), np.zeros(count)], axis=1)
    free = np.zeros((count, 3), dtype=bool)
    free[1:-1, [0, 2]] = True
    contact = touching(np.arange(1, count - 1), friction=0.0, direction=(0.0, 0.0, 1.0))
    model = yarns(
        points, laws=(YARN,), free=free, carried=np.zeros((count, 3)), travel=(4.0, 8.0, 12.0),
        direction=(0.0, 0.0, 1.0), contact=contact,
    )  # fmt: skip
    *_, last = advance(model)
    return last


def wrapped_length() -> float:
    """Length of two tangents from the clamps to the sphere 12 mm up, and of the arc between them."""
    to_centre = np.array([30.0, RADIUS - 12.0])
    distance = float(np.linalg.norm(to_centre))
    arc = np.arctan2(to_centre[0], to_centre[1]) - np.arccos(RADIUS / distance)
    return float(2.0 * (np.sqrt(distance**2 - RADIUS**2) + RADIUS * arc))


def test_without_friction_the_tension_is_the_same_all_along_a_yarn_over_a_sphere(yarns: Callable[..., Model]) -> None:
    wanted = np.log(wrapped_length() / 60.0)
    errors = []
    for count in (41, 81):
        tension = lifted(yarns, count).truss_force
        assert np.ptp(tension) < 1e-3 * tension.mean()
        errors.append(abs(tension.mean() / (YARN.E * wanted) - 1.0))
    assert errors[0] < 0.003
    assert errors[1] < errors[0] / 3.0


def capstan(yarns: Callable[..., Model], arcs: int, friction: float) -> float:
    """Return the logarithm of pull over hold of a yarn wrapped half round a fixed sphere and drawn at one end."""
    angle = np.linspace(np.pi, 0.0, arcs + 1)
    arc = RADIUS * np.stack([np.cos(angle), np.zeros(arcs + 1), np.sin(angle)], axis=1)
    legs = np.array([[0.0, 0.0, -5.0 * k] for k in (2, 1)])
    points = np.concatenate([arc[0] + legs, arc, arc[-1] + legs[::-1]]) - np.array([0.0, 0.0, RADIUS])
    count = len(points)
    free = np.zeros((count, 3), dtype=bool)
    free[1:-1, [0, 2]] = True
    carried = np.zeros((count, 3))
    carried[-1, 2] = -1.0
    model = yarns(
        points, laws=(YARN,), free=free, carried=carried, travel=np.linspace(0.1, 1.0, 10), direction=(0.0, 0.0, -1.0),
        contact=touching(np.arange(1, count - 1), friction=friction, direction=(0.0, 0.0, 0.0)),
    )  # fmt: skip
    *_, last = advance(model)
    return float(np.log(last.truss_force[-1] / last.truss_force[0]))


@pytest.mark.parametrize("friction", [0.2, 0.6])
def test_a_yarn_that_slides_over_a_sphere_is_a_capstan(yarns: Callable[..., Model], friction: float) -> None:
    """Pull / hold = exp(mu theta) with theta = pi, but for the corners of the mesh."""
    wanted = friction * np.pi
    errors = [abs(capstan(yarns, arcs, friction) - wanted) for arcs in (8, 24)]
    assert errors[0] < 0.03 * wanted
    assert errors[1] < errors[0] / 4.0
