"""Rigid lands against the closed form of a strip: what lies under a land does not stretch, the rest takes it all."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.effects.change import with_laws
from etextile.lattice.piece import divide, weave_piece
from etextile.lattice.weave import DIAGONAL, WARP, Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock
from etextile.results.wire_layout import ALONG_WARP, LAID
from etextile.solve.path import Increment, advance
from etextile.types import Array
from wires.drawn import LoopSpec, PathSpec
from wires.embed import EmbeddedWires, bonded, with_strands
from wires.embed_slip import WeaveHold, sliding
from wires.lands import STIFF, Lands, stiffened, with_lands
from wires.parts import PartSpec
from wires.paths import lay_paths
from wires.strain import wire_strains


WEAVE = Weave(0.2849, 0.1603, 0.35, 0.0155, 11.0, 8.9)
FABRIC = PowerLaw(3000.0, 0.2, 9960.0, 1.5)
COPPER = PowerLaw(1e5, 79.0, 600.0, 0.5)
LENGTH, WIDTH = 100.0, 12.0


def strip(
    lands: Lands,
    coarsening: float,
    strain: float,
    *,
    specs: list[PathSpec] | None = None,
    diagonals: bool = True,
    channel: WeaveHold | None = None,
) -> tuple[Model, EmbeddedWires, Increment]:
    """Pull a strip of 100 x 12 mm by `strain` of its length; all nodes keep their place across and out of plane."""
    lattice = weave_piece(WEAVE, divide(WEAVE, (LENGTH, WIDTH), coarsening, "whole"))
    trusses = TrussBlock.between_nodes(
        "lattice",
        lattice.trusses,
        length=lattice.rest_length,
        area=lattice.area * np.where(lattice.family == DIAGONAL, 1.0 if diagonals else 1e-6, 1.0),
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
    every = np.arange(layout.n_wires)
    if channel is None:
        strand = bonded(model, layout, every, COPPER, area_mm2=1e-6, crimp=0.0, lands=lands)
    else:
        model, strand = sliding(model, layout, every, COPPER, area_mm2=1e-6, crimp=0.0, channel=channel, lands=lands)
    model, wires = with_strands(model, layout, [strand], lands=lands)
    model = with_lands(model, lands)
    *_, last = advance(model)
    return model, wires, last


def land(x: float, y: float, length: float, width: float) -> Lands:
    return Lands.of([PartSpec("land", (x, y), (length, width))])


NONE = Lands(np.zeros((0, 2)), np.zeros((0, 2)))


SIZE = 17.0
LINE = PathSpec("w", ALONG_WARP, ((-50.0, 1.3), (50.0, 1.3)), (LoopSpec(30.0, 4.0, 0.0), LoopSpec(12.0, 4.0, 0.0)))


def beside(strain: float, size: float = SIZE) -> float:
    """Return the strain beside a land over the full width of a strip strained by `strain`."""
    return strain * LENGTH / (LENGTH - (1.0 - STIFF) * size)


@pytest.mark.parametrize("strain", [0.003, 0.2])
@pytest.mark.parametrize("coarsening", [20.0, 40.0, 70.0])
def test_yarns_wires_and_loops_beside_a_land_bear_its_closed_form(coarsening: float, strain: float) -> None:
    """The strain is u / (L - l) beside a land of length l over the full width, wherever it lies among the cells.

    Without diagonals, whose angle is not the same in cells that are covered partly. What lies under the land whole is
    stiff for small strains, so it takes STIFF of its length wrong by the size of the strain.
    """
    expected = beside(strain)
    model, wires, last = strip(land(3.0, 0.0, SIZE, WIDTH), coarsening, strain, specs=[LINE], diagonals=False)
    found = wire_strains(wires, model, last)
    under = np.abs(wires.element_along_mm - 3.0) < SIZE / 2
    assert found["element_strain"][~under] == pytest.approx(expected, rel=STIFF * expected + 1e-6)
    assert found["element_strain"][under] == pytest.approx(STIFF * expected, rel=expected + 1e-3)
    total = found["element_strain"] @ wires.element_length_mm + 4.0 * found["span_strain"].sum()
    assert total == pytest.approx(strain * LENGTH, rel=1e-9)
    half_on_land = (4.0 - (1.0 - STIFF) * 1.5) / 4.0 * expected  # the loop from 10 to 14 mm, land up to 11.5 mm
    assert found["span_strain"] == pytest.approx([half_on_land, expected], rel=STIFF * expected + 1e-6)
    warp = last.truss_strain[: len(model.lattice.trusses)][model.lattice.family == WARP]
    assert warp.max() == pytest.approx(expected, rel=STIFF * expected + 1e-6)


@pytest.mark.parametrize("coarsening", [20.0, 70.0])
def test_with_diagonals_a_land_is_right_to_a_fifth_of_the_strain(coarsening: float) -> None:
    expected = beside(0.03)
    model, wires, last = strip(land(3.0, 0.0, SIZE, WIDTH), coarsening, 0.03, specs=[LINE])
    found = wire_strains(wires, model, last)["element_strain"]
    under = np.abs(wires.element_along_mm - 3.0) < SIZE / 2
    assert found[~under] == pytest.approx(expected, rel=0.2 * expected)


@pytest.mark.parametrize("coarsening", [20.0, 70.0])
def test_force_and_work_of_the_strip_are_those_of_the_shorter_one(coarsening: float) -> None:
    expected = beside(0.03)
    *_, last = strip(land(3.0, 0.0, SIZE, WIDTH), coarsening, 0.03, diagonals=False)
    *_, even = strip(NONE, coarsening, expected, diagonals=False)
    # forces are those on the clamps' share of the way, so force / strain compares the pull
    assert last.punch_force_N / 0.03 == pytest.approx(even.punch_force_N / expected, rel=STIFF * expected + 1e-6)
    share = 0.03 / expected  # of the shorter strip's length in this one's
    assert last.energy.stored == pytest.approx(share * even.energy.stored, rel=2.0 * STIFF)


def test_lands_in_one_cell_add_up_along_a_yarn_and_not_across() -> None:
    """In a row their lengths add up; side by side each holds its own yarns (the edges are strips of their own)."""
    edges = [PathSpec(str(y), ALONG_WARP, ((-50.0, y), (50.0, y))) for y in (-6.0, 6.0)]

    def peaks(*parts: tuple[tuple[float, float], tuple[float, float]]) -> list[float]:
        lands = Lands.of([PartSpec(str(k), *part) for k, part in enumerate(parts)])
        model, wires, last = strip(lands, 70.0, 0.03, specs=edges, diagonals=False)
        found = wire_strains(wires, model, last)["element_strain"]
        return [float(found[wires.element_wire == wire].max()) for wire in (0, 1)]

    row = peaks(((-5.0, 0.0), (3.0, WIDTH)), ((4.0, 0.0), (4.0, WIDTH)))
    assert row == pytest.approx([beside(0.03, 7.0)] * 2, rel=1e-5)
    assert peaks(((-5.0, 3.0), (3.0, 6.0)), ((4.0, -3.0), (4.0, 6.0))) == pytest.approx(
        [beside(0.03, 4.0), beside(0.03, 3.0)], rel=1e-5
    )


@pytest.mark.slow
def test_the_strain_at_the_corner_of_a_land_settles_with_the_lattice() -> None:
    """A land over half of the width, shifted among the cells: force and the strain at its edge, finer and finer."""
    line = PathSpec("w", ALONG_WARP, ((-50.0, 2.7), (50.0, 2.7)))
    edge, force = [], []
    for coarsening in (20.0, 10.0, 5.0):
        model, wires, last = strip(land(1.9, 3.0, SIZE, 6.0), coarsening, 0.03, specs=[line])
        after = np.flatnonzero(wires.element_along_mm > 1.9 + SIZE / 2)[0]
        edge.append(wire_strains(wires, model, last)["element_strain"][after])
        force.append(last.punch_force_N)
    assert abs(edge[2] / edge[1] - 1.0) < 0.02 < abs(edge[0] / edge[2] - 1.0)
    assert abs(force[2] / force[1] - 1.0) < 0.05


def test_a_wire_that_could_slide_and_is_held_reads_the_same_strain_at_a_land() -> None:
    rigid = land(3.0, 0.0, SIZE, WIDTH)
    found = []
    for channel in (None, WeaveHold(held=True)):
        model, wires, last = strip(rigid, 40.0, 0.03, specs=[LINE], channel=channel)
        found.append(wire_strains(wires, model, last))
    for name, value in found[0].items():
        assert found[1][name] == pytest.approx(value, rel=1e-6)


def test_yarns_beside_a_land_do_not_feel_it_when_the_cells_are_finer() -> None:
    """A land over half of the width: in the lattice the yarns that pass it are strained more, the others less."""
    rigid = land(0.0, 3.0, 20.0, 6.0)
    over, past = (PathSpec(str(y), ALONG_WARP, ((-50.0, y), (50.0, y))) for y in (3.0, -5.0))
    model, wires, last = strip(rigid, 8.0, 0.03, specs=[over, past])
    found = wire_strains(wires, model, last)["element_strain"]
    near = (np.abs(wires.element_along_mm) > 10.0) & (np.abs(wires.element_along_mm) < 12.0)
    under = (np.abs(wires.element_along_mm) < 10.0) & (wires.element_wire == 0)
    assert found[under].max() < 0.05 * 0.03
    assert found[near & (wires.element_wire == 0)].max() > 1.1 * found[near & (wires.element_wire == 1)].max()


def test_a_laid_wire_is_stiff_on_the_land_in_any_direction() -> None:
    line = PathSpec("d", LAID, ((-20.0, -5.0), (0.0, 0.0), (20.0, 5.0)))
    model, wires, last = strip(land(0.0, 0.0, 12.0, WIDTH), 30.0, 0.04, specs=[line])
    found = wire_strains(wires, model, last)["element_strain"]
    under = np.abs(wires.element_warp_mm) < 6.0
    assert under.any()
    assert found[under].max() < 0.03 * found[~under].max()


def test_what_lies_under_a_land_whole_bears_the_same_at_a_hundredth_of_the_strain() -> None:
    """The law under a land at the strain STIFF e is that beside it at e, to first order."""
    strain: Array = np.array([1e-4, 1e-3, 5e-3, 0.02])
    held, free = stiffened(FABRIC).loading_curve(STIFF * strain), FABRIC.loading_curve(strain)
    assert np.all(np.abs(held / free - 1.0) < 2.0 * strain + 1e-9)


def test_without_lands_nothing_changes_to_the_last_digit() -> None:
    spec = PathSpec("w", ALONG_WARP, ((-50.0, 1.3), (50.0, 1.3)), (LoopSpec(30.0, 4.0, 0.0),))
    far = land(-40.0, -4.0, 2.0, 2.0)
    free = [strip(lands, 20.0, 0.02, specs=[spec]) for lands in (NONE, far)]
    for model, wires, last in free:
        assert (model.lattice_block.family == WARP).any()
        assert len(last.truss_strain) == len(model.lattice.trusses) + len(wires.element_wire) + 1
    assert np.array_equal(free[0][0].lattice_block.rest_length, free[0][0].lattice.rest_length)


def test_laws_that_scatter_do_so_on_lands_too() -> None:
    model, *_ = strip(land(3.0, 0.0, SIZE, WIDTH), 20.0, 0.003)
    softer = with_laws(model, (WARP,), lambda law: law.scaled(0.5))
    for before, after in zip(model.contributions[:2], softer.contributions[:2], strict=True):
        assert isinstance(before, TrussBlock)
        assert isinstance(after, TrussBlock)
        factors = [new.E / old.E for old, new in zip(before.laws, after.laws, strict=True)]
        assert factors == [0.5, 1.0, 1.0] * (len(before.laws) // 3)
    assert len(model.contributions[1].laws) == 6
