"""Builders of small models for the physics tests, without case files: lattice, supports, body, contact."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from etextile.contact.body import Body
from etextile.contact.contact import Contact
from etextile.contact.pose import place
from etextile.contact.sphere import Sphere
from etextile.lattice.piece import divide, weave_piece
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock


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
        model.direction,
        friction,
        0.02,
        30.0 * model.typical_stiffness,
    )
    return model.with_contribution(contact)


@pytest.fixture
def punch() -> Callable[..., Model]:
    """The builder of punch models."""
    return punch_model
