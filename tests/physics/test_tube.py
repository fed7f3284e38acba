"""Sleeves as lattices: what is woven into them, how tight ones start, and half against whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.contact.contact import Contact
from etextile.contact.limb import Limb
from etextile.lattice.tube import Wrapped, Wrapping, wrap
from etextile.lattice.weave import WARP, WEFT, Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock
from etextile.motion.flexion import Cuffs, Flexion
from etextile.solve.path import Increment, advance


WEAVE = Weave(0.2849, 0.1603, 0.35, 0.0155, 11.0, 8.9)
LAWS = (PowerLaw(3000.0, 0.2, 9960.0, 1.5), PowerLaw(4500.0, 0.2, 4230.0, 1.1), PowerLaw(1500.0, 0.2, 1550.0, 2.2))
LIMB = Limb(40.0, (40.0, 160.0), (40.0, 160.0))
EASE = -0.1


def sleeve(limb: Limb, *, half: bool, coarsening: float = 52.0) -> Wrapped:
    stations = np.linspace(-120.0, 120.0, 49)
    radii = (1.0 + EASE) * limb.radius(stations)
    around = 2.0 * np.pi * float(np.interp(0.0, stations, radii))
    return wrap(WEAVE, Wrapping(240.0, around, stations, radii, closed=True), coarsening, half=half)


def bent(half: bool, angle: float) -> tuple[Wrapped, list[Increment], float]:
    """Put a tight sleeve on and bend its limb, ends held."""
    piece = sleeve(LIMB, half=half)
    lattice, places = piece.lattice, piece.places
    donning = -float(LIMB.distance(places).gap.min())
    motion = Flexion(LIMB, donning=donning)
    ends = np.flatnonzero(lattice.edges["x_min"] | lattice.edges["x_max"])
    fixed = np.zeros((len(places), 3), dtype=bool)
    fixed[piece.on_plane, 1] = True
    fixed[ends] = True
    grown = places[ends] * [1.0, 1.0 / (1.0 + EASE), 1.0 / (1.0 + EASE)]
    guide = Cuffs(motion, ends, places[ends], grown, motion.share(places[ends], 0.0))
    block = TrussBlock.between_nodes(
        "lattice", lattice.trusses, length=lattice.rest_length, area=lattice.area, family=lattice.family, laws=LAWS
    )
    travel = np.array([-0.5 * donning, 0.0, *np.arange(5.0, angle + 1.0, 5.0)])
    factor = 2.0 if half else 1.0
    model = Model(
        lattice,
        places,
        fixed,
        np.zeros_like(places),
        (block,),
        travel,
        np.zeros(3),
        force_factor=factor,
        begins=-donning,
    )
    nodes = np.flatnonzero(~fixed.all(axis=1))
    stiffness = 30.0 * model.typical_stiffness
    contact = Contact(nodes[:, None], lattice.share[nodes], LIMB, motion, 0.0, 0.02, stiffness)
    guided = replace(model, guide=guide, contributions=(block, contact))
    return piece, list(advance(guided)), donning


@pytest.fixture(scope="module")
def half_bent() -> tuple[Wrapped, list[Increment], float]:
    return bent(True, 30.0)


def test_a_tight_sleeve_on_a_straight_limb_is_stretched_around_it_alone(
    half_bent: tuple[Wrapped, list[Increment], float],
) -> None:
    piece, increments, _ = half_bent
    put_on = next(item for item in increments if item.displacement_mm == 0.0)
    around = put_on.truss_strain[piece.lattice.family == WEFT]
    angle = np.pi / piece.lattice.cells[1]
    expected = 1.0 / (1.0 + EASE) * np.sin(angle / 2) / (angle / 2) - 1.0
    assert around == pytest.approx(expected, abs=0.02 / 36.0)  # less the penetration that contact allows
    assert put_on.truss_strain[piece.lattice.family == WARP].max() < 1e-4


def test_the_growth_works_against_hoop_tension(half_bent: tuple[Wrapped, list[Increment], float]) -> None:
    piece, increments, _ = half_bent
    put_on = next(item for item in increments if item.displacement_mm == 0.0)
    lattice = piece.lattice
    ends = piece.places[lattice.trusses]
    middle = np.abs(ends[:, :, 0].mean(axis=1)) < 100.0
    # work of the growth per mm: sum over trusses of force x change of length; hoop trusses grow by their angle
    arc = np.abs(lattice.points[lattice.trusses[:, 1], 1] - lattice.points[lattice.trusses[:, 0], 1])
    angle = arc / float(np.interp(0.0, [0.0, 1.0], [36.0, 36.0]))
    chord = 2.0 * np.sin(0.5 * angle)
    length = np.hypot(np.ptp(ends[:, :, 0], axis=1), 40.0 * chord)
    grows = 40.0 * chord**2 / length
    power = float((put_on.truss_force * grows).sum()) * 2.0
    held = lattice.edges["x_min"] | lattice.edges["x_max"]
    assert middle.any()
    assert held.any()
    assert put_on.punch_force_N == pytest.approx(power, rel=5e-3)


def test_energy_is_balanced_through_donning_and_flexion(half_bent: tuple[Wrapped, list[Increment], float]) -> None:
    _, increments, _ = half_bent
    last = increments[-1].energy
    assert abs(last.external - last.stored - last.plastic - last.contact) < 0.02 * last.external + last.work_doubt


def test_a_whole_sleeve_is_twice_its_half(half_bent: tuple[Wrapped, list[Increment], float]) -> None:
    _, increments, _ = half_bent
    piece, whole, _ = bent(False, 30.0)
    area = [lattice.area[lattice.family == WARP].sum() for lattice in (piece.lattice, half_bent[0].lattice)]
    assert area[0] == pytest.approx(2.0 * area[1], rel=0.1)  # 27 cells around against twice 14
    assert whole[-1].punch_force_N == pytest.approx(increments[-1].punch_force_N, rel=2e-2)


def test_warp_yarns_of_a_tapered_sleeve_are_neither_taut_nor_slack_on_it() -> None:
    piece = sleeve(Limb(45.0, (60.0, 160.0), (36.0, 160.0)), half=True)
    lattice, ends = piece.lattice, piece.places[piece.lattice.trusses]
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    strain = (length / lattice.rest_length - 1.0)[lattice.family == WARP]
    assert np.median(np.abs(strain)) < 1e-9
    assert strain.max() < 1e-9
    assert strain.min() > -3e-3  # the chord of the cell that spans the kink at the hinge
    assert np.ptp(lattice.points[:, 0]) == pytest.approx(240.0)


def test_a_sleeve_that_follows_a_tapered_limb_has_rest_lengths_of_its_girth() -> None:
    limb = Limb(45.0, (52.0, 160.0), (36.0, 160.0))
    piece = sleeve(limb, half=True)
    lattice, axial = piece.lattice, float(piece.places[:, 0].min())
    weft = lattice.family == WEFT
    x = lattice.points[lattice.trusses[weft, 0], 0]
    first = np.isclose(x, x.min())
    assert 2.0 * lattice.rest_length[weft][first].sum() == pytest.approx(
        (1.0 + EASE) * float(limb.girth(np.array([axial]))[0]), rel=1e-6
    )


def test_pressure_of_a_tight_sleeve_is_tension_over_radius(
    half_bent: tuple[Wrapped, list[Increment], float],
) -> None:
    """P = T / R (Laplace), T the hoop tension per length of sleeve."""
    piece, increments, _ = half_bent
    put_on = next(item for item in increments if item.displacement_mm == 0.0)
    lattice = piece.lattice
    ring = (lattice.family == WEFT) & np.isclose(lattice.points[lattice.trusses[:, 0], 0], 0.0, atol=6.0)
    cell = float(np.ptp(lattice.points[:, 0])) / lattice.cells[0]
    rings = len(np.unique(lattice.points[lattice.trusses[ring, 0], 0].round(6)))
    tension = float(put_on.truss_force[ring].sum()) / (lattice.cells[1] * rings * cell)
    nodes = np.unique(lattice.trusses[ring])
    force = np.linalg.norm(put_on.contact_force[nodes], axis=1).sum()
    pressure = float(force) / (np.pi * 40.0 * rings * cell)
    assert pressure == pytest.approx(tension / 40.0, rel=0.01)
