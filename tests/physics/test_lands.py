"""Rigid lands against the closed form of a strip: what lies under a land does not stretch, the rest takes it all."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.lattice.piece import divide, weave_piece
from etextile.lattice.weave import WARP, Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock
from etextile.results.wire_layout import ALONG_WARP, LAID
from etextile.solve.path import Increment, advance
from etextile.types import Array
from wires.drawn import LoopSpec, PathSpec
from wires.embed import EmbeddedWires, bonded, with_strands
from wires.lands import STIFF, Lands, amplified, with_lands
from wires.parts import PartSpec
from wires.paths import lay_paths
from wires.strain import wire_strains


WEAVE = Weave(0.2849, 0.1603, 0.35, 0.0155, 11.0, 8.9)
FABRIC = PowerLaw(3000.0, 0.2, 9960.0, 1.5)
COPPER = PowerLaw(1e5, 79.0, 600.0, 0.5)
LENGTH, WIDTH = 100.0, 12.0


def strip(
    lands: Lands, *, coarsening: float, strain: float, specs: list[PathSpec] | None = None
) -> tuple[Model, EmbeddedWires, Increment]:
    """Pull a strip of 100 x 12 mm by `strain` of its length; all nodes keep their place across and out of plane."""
    lattice = weave_piece(WEAVE, divide(WEAVE, (LENGTH, WIDTH), coarsening, "whole"))
    trusses = TrussBlock.between_nodes(
        "lattice",
        lattice.trusses,
        length=lattice.rest_length,
        area=lattice.area,
        family=lattice.family,
        laws=(FABRIC, FABRIC, FABRIC),
    )
    fixed = np.ones(lattice.points.shape, dtype=bool)
    fixed[:, 0] = np.abs(lattice.points[:, 0]) > LENGTH / 2 - 1e-9
    carried = np.zeros_like(lattice.points)
    carried[:, 0] = strain * lattice.points[:, 0]
    direction = np.array([1.0, 0.0, 0.0])
    model = Model(lattice, lattice.points, fixed, carried, (trusses,), np.linspace(0.1, 1.0, 10), direction)
    layout, _ = lay_paths(specs or [], length_mm=LENGTH, width_mm=WIDTH)
    strands = [bonded(model, layout, np.arange(layout.n_wires), COPPER, area_mm2=1e-6, crimp=0.0, lands=lands)]
    model, wires = with_strands(model, layout, strands, lands=lands)
    model = with_lands(model, lands)
    *_, last = advance(model)
    return model, wires, last


def land(x: float, y: float, length: float, width: float) -> Lands:
    return Lands.of([PartSpec("land", (x, y), (length, width))])


NONE = Lands(np.zeros((0, 2)), np.zeros((0, 2)))


@pytest.mark.parametrize("strain", [0.003, 0.03])
@pytest.mark.parametrize("coarsening", [5.0, 20.0, 40.0, 90.0])
def test_a_strip_with_a_rigid_land_stretches_beside_it_alone(coarsening: float, strain: float) -> None:
    """The strain is u / (L - l) beside a land of length l over the full width, and a hundredth of it under the land.

    Where the land covers a part of a cell the strain e beside it is short by up to e of itself.
    """
    size = 17.0
    line = PathSpec("w", ALONG_WARP, ((-50.0, 1.3), (50.0, 1.3)), (LoopSpec(30.0, 4.0, 0.0), LoopSpec(12.0, 4.0, 0.0)))
    rigid = land(3.0, 0.0, size, WIDTH)
    model, wires, last = strip(rigid, coarsening=coarsening, strain=strain, specs=[line])
    found = wire_strains(wires, model, last)
    beside = strain * LENGTH / (LENGTH - (1.0 - STIFF) * size)
    under = np.abs(wires.element_along_mm - 3.0) < size / 2
    assert found["element_strain"][under] == pytest.approx(STIFF * beside, rel=0.03)
    assert found["element_strain"][~under] == pytest.approx(beside, rel=beside + 0.001)
    total = found["element_strain"] @ wires.element_length_mm + 4.0 * found["span_strain"].sum()
    assert total == pytest.approx(strain * LENGTH, rel=1e-6)
    half_on_land = (4.0 - (1.0 - STIFF) * 1.5) / 4.0 * beside  # the loop from 10 to 14 mm, land up to 11.5 mm
    assert found["span_strain"] == pytest.approx([half_on_land, beside], rel=beside + 0.001)


@pytest.mark.parametrize("coarsening", [20.0, 90.0])
def test_the_force_of_the_strip_is_that_of_the_shorter_one(coarsening: float) -> None:
    size, strain = 17.0, 0.03
    beside = strain * LENGTH / (LENGTH - (1.0 - STIFF) * size)
    *_, last = strip(land(3.0, 0.0, size, WIDTH), coarsening=coarsening, strain=strain)
    *_, even = strip(NONE, coarsening=coarsening, strain=beside)
    work = last.punch_force_N / strain, even.punch_force_N / beside  # both are per share of the clamps' way
    assert work[0] == pytest.approx(work[1], rel=0.01)


def test_yarns_beside_a_land_do_not_feel_it_when_the_cells_are_finer() -> None:
    """A land over half of the width: in the lattice the yarns that pass it are strained more, the others less."""
    rigid = land(0.0, 3.0, 20.0, 6.0)
    over, past = (PathSpec(str(y), ALONG_WARP, ((-50.0, y), (50.0, y))) for y in (3.0, -5.0))
    model, wires, last = strip(rigid, coarsening=8.0, strain=0.03, specs=[over, past])
    found = wire_strains(wires, model, last)["element_strain"]
    near = (np.abs(wires.element_along_mm) > 10.0) & (np.abs(wires.element_along_mm) < 12.0)
    under = (np.abs(wires.element_along_mm) < 10.0) & (wires.element_wire == 0)
    assert found[under].max() < 0.05 * 0.03
    assert found[near & (wires.element_wire == 0)].max() > 1.1 * found[near & (wires.element_wire == 1)].max()


def test_a_laid_wire_is_stiff_on_the_land_in_any_direction() -> None:
    line = PathSpec("d", LAID, ((-20.0, -5.0), (0.0, 0.0), (20.0, 5.0)))
    model, wires, last = strip(land(0.0, 0.0, 12.0, WIDTH), coarsening=30.0, strain=0.04, specs=[line])
    found = wire_strains(wires, model, last)["element_strain"]
    under = np.abs(wires.element_warp_mm) < 6.0
    assert under.any()
    assert found[under].max() < 0.03 * found[~under].max()


def test_the_amplified_law_is_the_law_at_the_amplified_strain() -> None:
    """A yarn with half of its length held: its stress at the strain e is that of a free one at 2 e, to first order."""
    strain: Array = np.array([1e-4, 1e-3, 5e-3, 0.02])
    once, twice = amplified(FABRIC, 2.0).loading_curve(strain), FABRIC.loading_curve(2.0 * strain)
    assert np.all(np.abs(once / twice - 1.0) < 2.0 * strain + 1e-9)


def test_without_lands_nothing_changes_to_the_last_digit() -> None:
    spec = PathSpec("w", ALONG_WARP, ((-50.0, 1.3), (50.0, 1.3)), (LoopSpec(30.0, 4.0, 0.0),))
    far = land(-40.0, -4.0, 2.0, 2.0)
    free = [strip(lands, coarsening=20.0, strain=0.02, specs=[spec]) for lands in (NONE, far)]
    for model, wires, last in free:
        assert (model.lattice_block.family == WARP).any()
        assert len(last.truss_strain) == len(model.lattice.trusses) + len(wires.element_wire) + 1
    assert (free[0][1].element_gain == 1.0).all()
    assert np.array_equal(free[0][2].truss_force, free[0][2].truss_force)
