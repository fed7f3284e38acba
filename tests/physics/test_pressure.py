"""Pressure and own weight against closed forms, from flat and slack without any prestretch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.effects.bending_stiffness import BendingStiffness
from etextile.lattice.cut import cut_outline
from etextile.lattice.piece import Lattice, divide, weave_piece
from etextile.lattice.shape import Circle
from etextile.lattice.weave import DIAGONAL, WARP, WEFT, Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock
from etextile.motion.pressure import BAR, Pressure
from etextile.motion.weight import GRAVITY, Weight
from etextile.solve.newton import Settings
from etextile.solve.path import Increment, advance
from etextile.types import Array, BoolArray


SQUARE = Weave(1.0, 1.0, 0.1, 0.1, warp_density=1.0, weft_density=1.0)


def elastic(modulus: float) -> PowerLaw:
    """A law whose plastic strain is nothing: it would need a stress of a thousand moduli."""
    return PowerLaw(modulus, 1e3 * modulus, 1e6 * modulus, 1.0)


def model_of(lattice: Lattice, moduli: tuple[float, float, float], fixed: BoolArray, travel: Array) -> Model:
    trusses = TrussBlock.between_nodes(
        "lattice",
        lattice.trusses,
        length=lattice.rest_length,
        area=lattice.area,
        family=lattice.family,
        laws=tuple(elastic(modulus) for modulus in moduli),
    )
    for axis in (0, 1):
        if lattice.symmetry[axis]:
            fixed[lattice.points[:, axis] == 0.0, axis] = True
    return Model(
        lattice=lattice,
        points=lattice.points,
        fixed=fixed,
        carried=np.zeros(lattice.points.shape),
        contributions=(trusses,),
        travel=travel,
        direction=np.array([0.0, 0.0, 1.0]),
        force_factor=float(lattice.multiplicity),
    )


def last(model: Model, *, floor: float = 1e-4) -> Increment:
    *_, end = advance(model, Settings(tolerance=1e-9, force_floor=floor))
    return end


def hencky(poisson: float) -> float:
    """Return w / (a (p a / (E t))^(1/3)) of Hencky's series (1915, corrected: Fichter, NASA TP-3658, 1997)."""

    def b(b0: float) -> Array:
        factors = np.array([1.0, -1.0, -2 / 3, -13 / 18, -17 / 18, -37 / 27, -1205 / 567])
        return factors * b0 ** np.array([1.0, -2.0, -5.0, -8.0, -11.0, -14.0, -17.0])

    orders = np.arange(1.0, 14.0, 2.0) - poisson
    low, high = 1.2, 3.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if orders @ b(middle) > 0.0 else (middle, high)
    a = np.array([1.0, 1 / 2, 5 / 9, 55 / 72, 7 / 6, 205 / 108, 17051 / 5292])
    return float(a @ low ** -np.array([1.0, 4.0, 7.0, 10.0, 13.0, 16.0, 19.0]))


def test_the_series_is_the_known_one() -> None:
    assert hencky(0.3) == pytest.approx(0.6536, abs=2e-3)
    assert hencky(0.25) == pytest.approx(0.662, abs=5e-3)


@pytest.mark.parametrize("portion", ["quarter", "whole"])
def test_a_clamped_circle_rises_as_hencky_says(portion: str) -> None:
    """Equal stiffness per width of all four directions of a square lattice is isotropic in the plane with nu = 1/3."""
    radius, stretch = 20.0, 1e-4
    lattice = cut_outline(SQUARE, Circle(radius), coarsening=1.0 if portion == "quarter" else 2.0, warp_angle=0.0,
                          portion=portion)  # fmt: skip
    # stiffness per width D of every family: a diagonal's spacing is a cell over sqrt(2)
    moduli = (1000.0, 1000.0, 1000.0 / np.sqrt(2.0))
    stiffness = 4.0 / 3.0 * 1000.0 * SQUARE.truss_area / SQUARE.cell_weft
    pressure = stretch * stiffness / radius
    fixed = np.zeros(lattice.points.shape, dtype=bool)
    fixed[lattice.edges["outline"]] = True
    model = model_of(lattice, moduli, fixed, np.array([0.5, 1.0]) * pressure / BAR)
    end = last(model.with_contribution(Pressure.on(lattice)))
    height = float(end.positions[:, 2].max())
    expected = radius * stretch ** (1.0 / 3.0)
    assert height == pytest.approx(hencky(1.0 / 3.0) * expected, rel=0.01)
    assert height == pytest.approx(0.662 * expected, rel=0.04)
    assert end.punch_force_N == pytest.approx(pressure * np.pi * radius**2, rel=0.005)
    assert end.clamp_force_N == pytest.approx(end.punch_force_N, rel=1e-4)  # the floor of the residual is 1e-4 N


def test_a_strip_becomes_an_arc_whose_tension_is_pressure_times_radius() -> None:
    lattice = weave_piece(SQUARE, divide(SQUARE, (40.0, 4.0), 1.0, "half"))
    fixed = np.zeros(lattice.points.shape, dtype=bool)
    fixed[:, 1] = True
    fixed[lattice.edges["x_max"]] = True
    pressure = 0.02
    model = model_of(lattice, (1000.0, 1000.0, 1e-6), fixed, np.array([0.3, 1.0]) * pressure / BAR)
    end = last(model.with_contribution(Pressure.on(lattice)))
    line = np.flatnonzero(lattice.points[:, 1] == 0.0)
    x, z = end.positions[line][:, [0, 2]].T
    centre = (z[-1] ** 2 - z[0] ** 2 + x[-1] ** 2) / (2.0 * (z[-1] - z[0]))
    radius = np.hypot(x, z - centre)
    assert np.ptp(radius) < 2e-3 * radius.mean()
    rows = int(np.sum(lattice.points[:, 0] == 0.0))
    warp = (lattice.family == WARP) & (lattice.area == lattice.area[lattice.family == WARP].max())
    tension = end.truss_force[warp] / SQUARE.cell_weft
    assert rows > 3
    assert np.ptp(tension) < 1e-6 * tension.mean()
    assert tension.mean() == pytest.approx(pressure * radius.mean(), rel=2e-3)
    # the arc of that strain over that span: 2 half = 2 R sin(s), s = half (1 + e) / R
    strain = end.truss_strain[warp].mean()
    angle = 20.0 * (1.0 + strain) / radius.mean()
    assert radius.mean() * np.sin(angle) == pytest.approx(20.0, rel=1e-3)


def test_forces_and_tangent_of_the_gas_are_derivatives_of_its_energy() -> None:
    lattice = cut_outline(SQUARE, Circle(6.0), coarsening=1.3, warp_angle=17.0, portion="whole")
    part = Pressure.on(lattice)
    generator = np.random.default_rng(5)
    inner = ~lattice.edges["outline"]
    x = lattice.points + inner[:, None] * generator.normal(0.0, 0.3, lattice.points.shape)
    step = inner[:, None] * generator.normal(0.0, 1.0, x.shape)

    def gradient(places: Array) -> Array:
        found = np.zeros_like(x)
        part.respond(places, 1.7, None).add_gradient(found)
        return found

    for width, limit in ((1e-3, 1e-5), (1e-4, 1e-7)):
        rise = part.respond(x + width * step, 1.7, None).energy()
        fall = part.respond(x - width * step, 1.7, None).energy()
        slope = (rise.stored - fall.stored) / (2.0 * width)
        assert slope == pytest.approx(float(np.vdot(gradient(x), step)), rel=limit)
    # volume: that of the divergence theorem with another origin is the same, for the rim is held
    corners = x[part.nodes] - np.array([3.0, -7.0, 0.0])
    cone = np.einsum("tc,tc->t", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert part.volume(x) == pytest.approx(float(part.weights @ cone), rel=1e-9)


def test_pressure_does_work() -> None:
    """What the gas does is stored in the trusses: the error of the energy is within the doubt of the quadrature."""
    lattice = cut_outline(SQUARE, Circle(10.0), coarsening=1.0, warp_angle=0.0, portion="quarter")
    fixed = np.zeros(lattice.points.shape, dtype=bool)
    fixed[lattice.edges["outline"]] = True
    model = model_of(lattice, (1000.0, 1000.0, 700.0), fixed, np.linspace(0.05, 1.0, 20))
    end = last(model.with_contribution(Pressure.on(lattice)))
    assert end.energy.error < 2e-3
    assert abs(end.energy.work_doubt / end.energy.external) < 0.02


def test_a_strip_under_its_own_weight_drops_as_a_beam() -> None:
    """Small drop: w L^4 / (8 D) of a beam built in at one end, within what a lattice of 24 cells leaves."""
    length, stiffness, mass = 24.0, 5.0, 10.0
    lattice = weave_piece(SQUARE, divide(SQUARE, (length, 4.0), 1.0, "whole"))
    fixed = np.zeros(lattice.points.shape, dtype=bool)
    fixed[lattice.edges["x_min"]] = True
    model = model_of(lattice, (1000.0, 1000.0, 500.0), fixed, np.array([mass]))
    nodes = np.arange(len(lattice.points))
    model = replace(model, direction=np.array([0.0, 0.0, -1.0]))
    model = model.with_contribution(Weight(nodes[:, None], lattice.share * lattice.cell_area))
    end = last(BendingStiffness(D=stiffness).transform(model), floor=1e-11)
    drop = -float(end.positions[lattice.edges["x_max"], 2].mean())
    assert drop == pytest.approx(GRAVITY * mass * length**4 / (8.0 * stiffness), rel=0.01)
    assert end.clamp_force_N == pytest.approx(GRAVITY * mass * length * 4.0, rel=1e-6)
    assert {WARP, WEFT, DIAGONAL} == set(lattice.family.tolist())
