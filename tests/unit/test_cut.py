"""Pieces cut at an angle: no fabric is lost or made, yarns end on the edges, angle 0 is the piece known from before."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from etextile.errors import BadInput
from etextile.lattice.cut import SNAP, Frame, cut_frame, cut_piece
from etextile.lattice.piece import EDGES, Lattice, divide, weave_piece
from etextile.lattice.shape import Rectangle
from etextile.lattice.weave import Weave
from etextile.types import Array


WEAVE = Weave(0.2849, 0.1603, 0.35, 0.0155, 11.0, 8.9)
SIZE = (60.0, 29.0)
CLAMPS = ("x_min", "x_max")


def piece(angle: float, *, coarsening: float = 8.0, held: tuple[str, ...] = CLAMPS) -> Lattice:
    return cut_piece(WEAVE, SIZE, coarsening=coarsening, warp_angle=angle, held=held)


def fabric_in(lattice: Lattice) -> Array:
    """Yarn volume of each family over what a piece of this size holds, from the spacing of the yarns."""
    volume = np.array([(lattice.area * lattice.rest_length)[lattice.family == k].sum() for k in range(3)])
    per_area = WEAVE.truss_area * WEAVE.thickness / np.array(WEAVE.nominal_area) * np.array([1.0, 1.0, 2.0])
    return np.asarray(volume / (per_area * SIZE[0] * SIZE[1]))


@settings(deadline=None, max_examples=25)
@given(angle=st.floats(-180.0, 180.0), coarsening=st.floats(6.0, 14.0))
@example(angle=-91.55610262472875, coarsening=11.803268697124599)
def test_no_fabric_is_lost_or_made_at_any_angle(angle: float, coarsening: float) -> None:
    whole = piece(angle, coarsening=coarsening, held=EDGES)
    assert fabric_in(whole) == pytest.approx(1.0, abs=1e-9)
    assert fabric_in(piece(angle, coarsening=coarsening)) == pytest.approx(1.0, abs=1e-9)
    cell = np.prod(whole.coarsening) * WEAVE.cell_warp * WEAVE.cell_weft
    assert whole.share.sum() * cell == pytest.approx(SIZE[0] * SIZE[1], rel=1e-9)


@pytest.mark.parametrize("angle", [5.0, 29.0, 45.0, 72.0, -30.0, 135.0])
def test_yarns_run_in_their_directions_and_end_exactly_on_the_clamps(angle: float) -> None:
    lattice = piece(angle)
    ends = lattice.points[lattice.trusses]
    way = ends[:, 1] - ends[:, 0]
    assert lattice.rest_length == pytest.approx(np.linalg.norm(way, axis=1), rel=1e-12)
    tilt = np.degrees(np.arctan2(WEAVE.cell_weft, WEAVE.cell_warp))
    nominal = {0: [angle], 1: [angle + 90.0], 2: [angle + tilt, angle - tilt]}
    for family, directions in nominal.items():
        found = np.degrees(np.arctan2(way[:, 1], way[:, 0]))[lattice.family == family]
        off = np.min([np.abs((found - one + 90.0) % 180.0 - 90.0) for one in directions], axis=0)
        assert np.median(off) < 1e-9
        assert off[lattice.rest_length[lattice.family == family] > 0.5].max() < np.degrees(4.0 * SNAP)
    for name, x in (("x_min", -30.0), ("x_max", 30.0)):
        assert np.all(lattice.points[lattice.edges[name], 0] == x)
        assert np.count_nonzero(lattice.edges[name]) > 20
    assert np.all(np.abs(lattice.points[:, :2]) <= np.array(SIZE) / 2 + 1e-12)


@pytest.mark.parametrize("angle", [3.0, 15.0, 45.0, 80.0])
def test_free_edges_have_no_loose_ends_and_the_piece_hangs_together(angle: float) -> None:
    lattice = piece(angle)
    count = np.bincount(lattice.trusses.ravel(), minlength=len(lattice.points))
    clamped = lattice.edges["x_min"] | lattice.edges["x_max"]
    alone = np.flatnonzero((count < 2) & ~clamped)
    assert len(alone) <= 4, "at most where a yarn at a corner was left out"
    graph = coo_matrix((np.ones(len(lattice.trusses)), tuple(lattice.trusses.T)), shape=(len(count), len(count)))
    parts = connected_components(graph, directed=False)[1]
    assert np.all(np.isin(parts, parts[clamped]))
    for name, sign in (("y_min", -1.0), ("y_max", 1.0)):
        hung = lattice.points[lattice.edges[name], 1] * sign
        assert len(hung) > 10
        assert hung.min() > 29.0 / 2 - 2.0 * 8.0 * 0.2849


def test_a_yarn_well_inside_stands_for_one_and_one_along_an_edge_for_half() -> None:
    """A square cell at 45 degrees: diagonals run along the edges, and one of them lies on each."""
    weave = Weave(1.0, 1.0, 0.1, 0.1, 1.0, 1.0)
    side = float(np.sqrt(2.0))
    lattice = cut_piece(weave, (40.0, 8.0 * side), coarsening=1.0, warp_angle=45.0, held=CLAMPS)
    along = np.abs(np.diff(lattice.points[lattice.trusses, 1], axis=1)[:, 0]) < 1e-9
    place = lattice.points[lattice.trusses[:, 0], 1]
    edge = along & (np.abs(np.abs(place) - 4.0 * side) < 1e-9)
    assert lattice.area[along & ~edge] == pytest.approx(0.1)
    assert np.count_nonzero(edge) > 20
    assert lattice.area[edge] == pytest.approx(0.05)


@pytest.mark.parametrize("angle", [0.0, 180.0, -360.0])
def test_with_the_warp_along_x_it_is_the_piece_in_whole_cells(angle: float) -> None:
    ours, known = piece(angle), weave_piece(WEAVE, divide(WEAVE, SIZE, 8.0, "whole"))
    assert np.abs(ours.points) == pytest.approx(np.abs(known.points))
    for name in ("trusses", "family", "rest_length", "area", "quads", "share"):
        assert np.array_equal(getattr(ours, name), getattr(known, name)), name
    assert ours.warp_angle == angle
    if angle == 0.0:
        assert all(np.array_equal(ours.edges[name], known.edges[name]) for name in EDGES)


def test_cutting_at_angle_0_along_lattice_lines_gives_the_same_lattice() -> None:
    """The general way, put to a piece whose edges are lattice lines, finds every truss, area and share again."""
    known = weave_piece(WEAVE, divide(WEAVE, SIZE, 8.0, "whole"))
    step = tuple(n * cell for n, cell in zip(known.coarsening, (WEAVE.cell_warp, WEAVE.cell_weft), strict=True))
    offset = tuple(0.5 * (cells % 2) for cells in known.cells)
    cut = cut_frame(WEAVE, Frame((step[0], step[1]), 0.0, Rectangle((30.0, 14.5)), (offset[0], offset[1])), held=EDGES)

    def described(lattice: Lattice, *, area: bool) -> Counter[tuple[float, ...]]:
        ends = np.sort(np.round(lattice.points[lattice.trusses, :2] @ np.array([1000.0, 1.0]), 3), axis=1)
        shown = np.where(area | (lattice.family < 2), np.round(lattice.area, 9), 0.0)
        columns = (*ends.T, lattice.family, shown, np.round(lattice.rest_length, 6))
        return Counter(zip(*(column.tolist() for column in columns), strict=True))

    assert described(cut, area=False) == described(known, area=False)
    corner = described(cut, area=True) - described(known, area=True)
    assert 0 < len(corner) < 100, "diagonals share their strips at the corners, which the piece in whole cells does not"
    assert cut.area[cut.family == 2].sum() == pytest.approx(known.area[known.family == 2].sum())
    assert sorted(cut.share.round(9)) == sorted(known.share.round(9))
    assert cut.cells == known.cells
    assert all(np.count_nonzero(cut.edges[name]) == np.count_nonzero(known.edges[name]) for name in EDGES)


def test_at_90_degrees_warp_and_weft_change_places_and_edges_turn_along() -> None:
    lattice = piece(90.0)
    way = np.diff(lattice.points[lattice.trusses, :2], axis=1)[:, 0]
    assert np.all(np.abs(way[lattice.family == 0, 0]) < 1e-9)
    assert np.all(np.abs(way[lattice.family == 1, 1]) < 1e-9)
    for name, axis, place in (("x_min", 0, -30.0), ("x_max", 0, 30.0), ("y_min", 1, -14.5), ("y_max", 1, 14.5)):
        assert lattice.points[lattice.edges[name], axis] == pytest.approx(place)
    assert fabric_in(lattice) == pytest.approx(1.0)


def test_mirrored_angles_give_mirrored_pieces() -> None:
    one, other = piece(30.0), piece(-30.0)
    assert len(one.trusses) == len(other.trusses)
    assert np.sort(one.area) == pytest.approx(np.sort(other.area))
    assert np.sort(np.round(one.points[:, 1], 6)) == pytest.approx(np.sort(np.round(-other.points[:, 1], 6)))


def test_cells_are_whole_and_turned() -> None:
    lattice = piece(30.0)
    corners = lattice.points[lattice.quads, :2]
    along, aside = corners[:, 1] - corners[:, 0], corners[:, 3] - corners[:, 0]
    interior = np.abs(np.linalg.norm(along, axis=1) - 8.0 * 0.2849) < 1e-9
    assert np.count_nonzero(interior) > 0.9 * len(lattice.quads)
    expected = 8.0 * 0.2849 * np.array([np.cos(np.pi / 6), np.sin(np.pi / 6)])
    assert np.all(np.abs(along[interior] - expected) < 1e-9)
    assert np.median(along[:, 0] * aside[:, 1] - along[:, 1] * aside[:, 0]) == pytest.approx(64.0 * 0.2849 * 0.1603)


@pytest.mark.parametrize("angle", [0.0, 45.0, 90.0])
def test_a_coarsening_without_a_whole_cell_is_refused(angle: float) -> None:
    with pytest.raises(BadInput, match="leaves no whole cell") as caught:
        piece(angle, coarsening=700.0)
    assert caught.value.problems[0].key == "fabric.coarsening"


@pytest.mark.parametrize("angle", [10.0, 30.0, 45.0, 80.0])
def test_whole_and_cut_cells_fill_the_piece_up_to_the_edges_that_are_held(angle: float) -> None:
    lattice = piece(angle, held=EDGES)
    x, y = np.moveaxis(lattice.points[np.concatenate([lattice.quads, lattice.edge_cells]), :2], 2, 0)
    area = 0.5 * (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1)
    assert np.all(area > -1e-9), "all run round in the same sense"
    assert 0.98 * SIZE[0] * SIZE[1] < area.sum() <= SIZE[0] * SIZE[1] * (1.0 + 1e-9), "but for corners, none twice"
    clamped = piece(angle)
    on_clamp = clamped.edges["x_max"][clamped.edge_cells].sum(axis=1) >= 2
    assert np.count_nonzero(on_clamp) > 5
    assert len(clamped.edge_cells) < len(lattice.edge_cells), "where yarn ends were left off nothing is drawn"


def test_a_piece_in_whole_cells_has_no_cut_ones() -> None:
    assert piece(0.0).edge_cells.shape == (0, 4)
    assert piece(90.0).edge_cells.shape == (0, 4)
