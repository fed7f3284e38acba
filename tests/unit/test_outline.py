"""Pieces with an outline: areas, what yarns stand for, and affine motion in equilibrium, as for rectangles."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.lattice.cut import cut_outline
from etextile.lattice.piece import Lattice
from etextile.lattice.shape import Circle, Outlined, Polygon
from etextile.lattice.weave import DIAGONAL, WARP, WEFT, Weave
from etextile.types import Array


WEAVE = Weave((0.2849), 0.1603, 0.35, 0.0155, warp_density=11.0, weft_density=8.9)
HEXAGON = tuple((30.0 * np.cos(a), 30.0 * np.sin(a)) for a in np.radians(np.arange(0.0, 360.0, 60.0)))
OFF_CENTRE = ((-20.0, -10.0), (25.0, -15.0), (30.0, 12.0), (-5.0, 30.0))
SHAPES: dict[str, tuple[Outlined, float]] = {
    "circle": (Circle(39.9), np.pi * 39.9**2),
    "hexagon": (Polygon(HEXAGON), 1.5 * np.sqrt(3.0) * 30.0**2),
    "four corners": (Polygon(OFF_CENTRE), 1455.0),
}


def shoelace(corners: Array) -> float:
    x, y = corners[..., 0], corners[..., 1]
    return float(0.5 * np.sum(x * np.roll(y, -1, axis=-1) - y * np.roll(x, -1, axis=-1)))


def covered(lattice: Lattice) -> float:
    return shoelace(lattice.points[np.concatenate([lattice.quads, lattice.edge_cells])][..., :2])


@pytest.mark.parametrize("angle", [0.0, 33.0])
@pytest.mark.parametrize("name", SHAPES)
def test_every_family_covers_the_whole_piece(name: str, angle: float) -> None:
    shape, area = SHAPES[name]
    if isinstance(shape, Polygon):
        assert shoelace(np.array(shape.corners)) == pytest.approx(area)
    lattice = cut_outline(WEAVE, shape, coarsening=13.0, warp_angle=angle, portion="whole")
    for family, parts in ((WARP, 1), (WEFT, 1), (DIAGONAL, 2)):
        own = lattice.family == family
        volume = float((lattice.area[own] * lattice.rest_length[own]).sum())
        assert volume * WEAVE.nominal_area[family] / (WEAVE.truss_area * WEAVE.thickness) == pytest.approx(parts * area)
    assert lattice.share.sum() * np.prod(lattice.coarsening) * WEAVE.cell_warp * WEAVE.cell_weft == pytest.approx(area)


@pytest.mark.parametrize("name", SHAPES)
def test_the_drawn_cells_close_on_the_outline(name: str) -> None:
    """What lies between the chords and the outline, or in a corner that no yarn passes, is less than a cell wide."""
    shape, area = SHAPES[name]
    for coarsening in (16.0, 8.0, 4.0):
        lattice = cut_outline(WEAVE, shape, coarsening=coarsening, warp_angle=20.0, portion="whole")
        assert np.all(shape.depth(lattice.points[:, :2]) > -1e-9)
        cell = coarsening**2 * WEAVE.cell_warp * WEAVE.cell_weft
        corners = len(shape.corners) if isinstance(shape, Polygon) else 2.0
        assert 0.0 < area - covered(lattice) < corners * cell
        assert shoelace(lattice.points[lattice.edge_cells][..., :2]) > 0.0


@pytest.mark.parametrize("portion", ["whole", "half", "quarter"])
def test_affine_motion_is_in_equilibrium_and_the_ring_bears_what_the_stress_says(portion: str) -> None:
    lattice = cut_outline(WEAVE, Circle(40.0), coarsening=12.0, warp_angle=0.0, portion=portion)
    gradient = np.array([[0.02, 0.005], [0.005, 0.03]]) if portion == "whole" else np.diag([0.02, 0.03])
    points = lattice.points[:, :2]
    way = np.diff(points[lattice.trusses], axis=1)[:, 0]
    along = way / lattice.rest_length[:, None]
    force = 1000.0 * lattice.area * np.einsum("mi,ij,mj->m", along, gradient, along)
    residual = np.zeros_like(points)
    np.add.at(residual, lattice.trusses[:, 0], force[:, None] * along)
    np.add.at(residual, lattice.trusses[:, 1], -force[:, None] * along)
    free = ~lattice.edges["outline"][:, None] & np.array(
        [[not (cut and p == 0.0) for cut, p in zip(lattice.symmetry, point, strict=True)] for point in points]
    )
    assert np.abs(residual[free]).max() < 1e-9 * force.max()
    # the virtual work of the ring on the affine motion is the energy, which the area of the piece gives
    work = float(np.einsum("ni,ij,nj->", -residual, gradient, points))
    density = 0.0
    for family, factor in ((WARP, 1.0), (WEFT, 1.0), (DIAGONAL, 1.0)):
        chosen = lattice.family == family
        for unit in np.unique(np.round(along[chosen], 9), axis=0):
            strain = unit @ gradient @ unit
            density += factor * 1000.0 * WEAVE.truss_area * WEAVE.thickness / WEAVE.nominal_area[family] * strain**2
    assert work == pytest.approx(density * np.pi * 40.0**2 / lattice.multiplicity, rel=1e-6)


def test_a_quarter_is_the_whole_seen_once() -> None:
    whole, quarter = (
        cut_outline(WEAVE, Circle(40.0), coarsening=12.0, warp_angle=0.0, portion=portion)
        for portion in ("whole", "quarter")
    )
    assert 4.0 * (quarter.area * quarter.rest_length).sum() == pytest.approx((whole.area * whole.rest_length).sum())
    assert 4.0 * quarter.share.sum() == pytest.approx(whole.share.sum())
    assert 4.0 * covered(quarter) == pytest.approx(covered(whole))


def test_the_centre_is_not_moved_onto_a_circle_that_is_near() -> None:
    moved = Circle(2.0).snapped(np.array([[0.0, 0.0], [1.5, 0.0]]), near=3.0)
    np.testing.assert_array_equal(moved, [[0.0, 0.0], [2.0, 0.0]])
