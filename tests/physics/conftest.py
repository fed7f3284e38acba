"""Builders of small models for the physics tests, without case files: lattice, supports, body, contact."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from etextile.contact.body import Body
from etextile.contact.contact import Contact
from etextile.contact.pose import place
from etextile.contact.sphere import Sphere
from etextile.lattice.piece import Lattice, divide, weave_piece
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock
from etextile.motion.straight import Straight
from etextile.types import Array, BoolArray, IntArray


WEAVE = Weave(0.2849, 0.1603, 0.35, 0.0155, 11.0, 8.9)
MID = (PowerLaw(3000.0, 0.2, 9960.0, 1.5), PowerLaw(4500.0, 0.2, 4230.0, 1.1), PowerLaw(1500.0, 0.2, 1550.0, 2.2))


def punch_model(
    *,
    coarsening: float = 19.5,
    travel: tuple[float, ...] = (2.5, 5.0),
    friction: float = 0.0,
    portion: str = "quarter",
    size: tuple[float, float] = (100.0, 100.0),
    body: Body | None = None,
    laws: tuple[PowerLaw, ...] = MID,
) -> Model:
    """Return a sphere (30 mm, or `body`) under a piece clamped at its warp ends."""
    lattice = weave_piece(WEAVE, divide(WEAVE, size, coarsening, portion))
    trusses = TrussBlock.between_nodes(
        "lattice",
        lattice.trusses,
        length=lattice.rest_length,
        area=lattice.area,
        family=lattice.family,
        laws=laws,
    )
    fixed = np.zeros((len(lattice.points), 3), dtype=bool)
    fixed[lattice.edges["x_max"] | lattice.edges["x_min"]] = True
    for axis in (0, 1):
        if lattice.symmetry[axis]:
            fixed[lattice.points[:, axis] == 0.0, axis] = True
    model = Model(
        lattice,
        lattice.points,
        fixed,
        np.zeros_like(lattice.points),
        (trusses,),
        np.array(travel),
        np.array([0.0, 0.0, 1.0]),
        force_factor=lattice.multiplicity,
    )
    nodes = np.flatnonzero(~fixed.all(axis=1))[:, None]
    contact = Contact(
        nodes,
        lattice.share[nodes[:, 0]],
        place(body or Sphere(15.0)),
        Straight(model.direction),
        friction,
        0.02,
        30.0 * model.typical_stiffness,
    )
    return model.with_contribution(contact)


@pytest.fixture
def punch() -> Callable[..., Model]:
    """The builder of punch models."""
    return punch_model


def yarn_model(
    points: Array,
    *,
    laws: tuple[PowerLaw, ...],
    free: BoolArray,
    carried: Array,
    travel: Sequence[float],
    direction: tuple[float, float, float] = (1.0, 0.0, 0.0),
    trusses: IntArray | None = None,
    law: IntArray | None = None,
    contact: Contact | None = None,
) -> Model:
    """Return trusses of 1 mm2 between points (N, 3) with free and carried components; a chain unless told otherwise."""
    count = len(points)
    if trusses is None:
        trusses = np.stack([np.arange(count - 1), np.arange(1, count)], axis=1)
    family = np.zeros(len(trusses), dtype=np.int64) if law is None else law
    length = np.linalg.norm(points[trusses[:, 1]] - points[trusses[:, 0]], axis=1)
    lattice = Lattice(
        points=points,
        trusses=trusses,
        family=family,
        rest_length=length,
        area=np.ones(len(trusses)),
        quads=np.zeros((0, 4), dtype=np.int64),
        edges={},
        share=np.ones(count),
        symmetry=(False, False),
        cells=(1, 1),
        coarsening=(1.0, 1.0),
    )
    block = TrussBlock.between_nodes("yarn", trusses, length=length, area=lattice.area, family=family, laws=laws)
    model = Model(lattice, points, ~free, carried, (block,), np.array(travel), np.array(direction))
    return model if contact is None else model.with_contribution(contact)


@pytest.fixture
def yarns() -> Callable[..., Model]:
    """The builder of a few trusses between given points."""
    return yarn_model
