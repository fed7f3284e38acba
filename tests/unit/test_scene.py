"""Scenes: the lattice as a surface, places on it, and the whole specimen from a quarter."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.results.layout import BodySurface, CaseRecord, UndeformedGrid
from etextile.results.reader import Results, open_results
from etextile.results.store import ResultWriter
from viz import surface
from viz.mirror import whole
from viz.scene import build_scene, wire_states


NX, NY = 4, 3
LIFT_MM = 2.0
WOVEN, LOOPS = np.array([0.01, 0.02, 0.03, 0.04]), np.array([0.05, 0.06, 0.07, 0.08])
"""Own strains of two trusses of each wire in the weave, and of the two of its loops behind them."""


def lattice(*, flip: bool = False) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points, warp and weft trusses of a quarter of 8 x 6 mm; `flip` turns every other warp truss round."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(NX + 1.0), np.arange(NY + 1.0), indexing="ij"))
    number = np.arange(len(x)).reshape(NX + 1, NY + 1)
    warp = np.stack([number[:-1].ravel(), number[1:].ravel()], axis=1)
    weft = np.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], axis=1)
    if flip:
        warp[::2] = warp[::2, ::-1]
    return np.column_stack([x, y, 0.0 * x]), warp, weft


def results(path: Path, *, angle: float = 0.0) -> Results:
    """Write one step of a quarter that is lifted by 2 mm, with wires at y = 0 and 2, loops at x = 0 and 3."""
    points, warp, weft = lattice()
    rows = [np.column_stack([np.arange(NX + 1.0), np.full(NX + 1, row), np.zeros(NX + 1)]) for row in (0.0, 2.0)]
    flat = np.concatenate([points, *rows])
    order = len(points) + np.arange(2 * (NX + 1)).reshape(2, -1)
    wire = np.stack([order[:, :-1], order[:, 1:]], axis=-1).reshape(-1, 2)
    cells = np.concatenate([warp, weft, wire])
    family = np.repeat(np.array([0, 1, 3], dtype=np.int8), [len(warp), len(weft), len(wire)])
    owner = np.where(family == 3, np.repeat([0, 0, 1], [len(warp) + len(weft), NX, NX]), -1).astype(np.int32)
    loop_warp, loop_wire = np.array([0.0, 3.0, 0.0, 3.0]), np.array([0, 0, 1, 1])
    wires = {
        "weft_mm": [0.0, 2.0],
        "start_mm": [0.0, 0.0],
        "end_mm": [4.0, 4.0],
        "share": [0.5, 1.0],
        "loop_wire": loop_wire,
        "loop_index": [0, 1, 0, 1],
        "loop_warp_mm": loop_warp,
        "loop_exit_mm": loop_warp - 0.5,
        "loop_entry_mm": loop_warp + 0.5,
        "loop_slack": np.zeros(4),
        "loop_halved": loop_warp == 0.0,
        "loop_copies": [1, 2, 1, 2],
        "wire_copies": [1, 2],
        "symmetric": True,
        "element_wire": [0, 0, 1, 1],
        "element_warp_mm": np.zeros(4),
    }
    contact = np.zeros_like(flat)
    contact[0, 2] = 3.0
    strain = np.where(family == 0, 0.1, 0.02)
    energy = SimpleNamespace(external=0.0, stored=0.0, plastic=0.0, friction=0.0, contact=0.0, work_doubt=0.0)
    verdict = SimpleNamespace(
        converged=True,
        reason="converged",
        iterations=1,
        linear_solves=1,
        cut_backs=0,
        residual_N=0.0,
        tolerance_N=0.0,
        sentence="",
        worst_node=0,
    )
    increment = SimpleNamespace(
        displacement_mm=LIFT_MM,
        positions=flat + np.array([0.0, 0.0, LIFT_MM]),
        truss_strain=strain,
        truss_stress=strain,
        truss_plastic_strain=strain,
        truss_force=strain,
        contact_force=contact,
        punch_force_N=7.0,
        clamp_force_N=7.0,
        max_penetration_mm=0.0,
        softening=0,
        energy=energy,
        verdict=verdict,
        output=True,
    )
    histories = {"span_strain": np.arange(4) / 10, "wire_strain": LOOPS, "element_strain": WOVEN}
    clamped = np.isclose(flat[:, 0], NX) & (np.arange(len(flat)) < len(points))
    grid = UndeformedGrid(flat, cells, family, owner, None, clamped, (angle == 0.0, angle == 0.0), angle)
    body = BodySurface(np.eye(3), np.array([[0, 1, 2]]), np.array([0.0, 0.0, 1.0]))
    with ResultWriter.create(path / "r.vtkhdf", grid, case=CaseRecord("x"), steps=1, wires=wires, body=body) as writer:
        writer.append(increment, histories=histories)
    return open_results(path / "r.vtkhdf")


@pytest.mark.parametrize("flip", [False, True])
def test_cells_are_found_between_warp_and_weft_whatever_way_trusses_point(flip: bool) -> None:
    points, warp, weft = lattice(flip=flip)
    quads = surface.quads_of(points, warp, weft)
    assert len(quads) == NX * NY
    corners = points[quads]
    np.testing.assert_allclose(np.ptp(corners, axis=1)[:, :2], 1.0)
    area = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])[:, 2] / 2
    np.testing.assert_allclose(np.abs(area), 1.0)


def test_a_cell_shows_the_mean_of_the_trusses_along_its_sides() -> None:
    points, warp, weft = lattice()
    quads = surface.quads_of(points, warp, weft)
    middle = points[warp].mean(axis=1)
    values = surface.cell_values(quads, warp, middle @ (1.0, 10.0, 0.0), n_points=len(points))
    np.testing.assert_allclose(values, points[quads].mean(axis=1) @ (1.0, 10.0, 0.0))
    np.testing.assert_array_equal(surface.cell_values(quads, warp[:0], values[:0], n_points=len(points)), 0.0)


def test_places_in_cells_are_bilinear_and_places_outside_take_the_edge() -> None:
    points, warp, weft = lattice()
    quads = surface.quads_of(points, warp, weft)
    places = np.array([[0.0, 0.0], [1.25, 2.5], [4.0, 3.0], [9.0, 1.0]])
    bent = np.column_stack([points[:, 0], points[:, 0] * points[:, 1]])
    found = surface.at(points, quads, places, bent)
    np.testing.assert_allclose(found[:3], np.column_stack([places[:3, 0], places[:3].prod(axis=1)]))
    np.testing.assert_allclose(found[3], [4.0, 4.0])


def test_a_side_is_clamped_only_along_its_held_edge() -> None:
    points, warp, weft = lattice()
    quads = surface.quads_of(points, warp, weft)
    assert surface.clamped_sides(points, quads, np.isclose(points[:, 0], NX)) == {"x_max": (0.0, 3.0)}
    held = np.isclose(points[:, 1], 0.0) & (points[:, 0] > 1.5)
    assert surface.clamped_sides(points, quads, held) == {"y_min": (2.0, 4.0)}


def test_a_scene_holds_what_the_step_says(tmp_path: Path) -> None:
    scene = build_scene(results(tmp_path), loop_state=np.array([0, 1, 2, 3]), title="t")
    assert (scene.displacement_mm, scene.force_N, scene.portion, scene.mirrored) == (2.0, 7.0, "quarter", False)
    np.testing.assert_allclose(scene.points[:, 2], LIFT_MM, atol=1e-6)
    np.testing.assert_allclose(scene.colouring.cells, 10.0, rtol=1e-6)
    np.testing.assert_allclose(scene.loops.deformed[3], [3.0, 2.0, LIFT_MM], atol=1e-6)
    np.testing.assert_allclose(scene.body.vertices[:, 2].max(), 1.0 + LIFT_MM)
    assert np.flatnonzero(scene.touched).tolist() == [0]
    assert wire_states(scene) == {0: 1, 1: 3}
    assert np.unique(scene.wires.wire).tolist() == [0, 1]
    expected = [*WOVEN[:2], *LOOPS[:2], *WOVEN[2:], *LOOPS[2:]]
    np.testing.assert_allclose(scene.wires.strain, expected, rtol=1e-6)


def test_a_quarter_is_mirrored_to_the_whole_without_doubling_what_lies_on_the_planes(tmp_path: Path) -> None:
    scene = whole(build_scene(results(tmp_path)))
    assert scene.mirrored
    lattice_points = (2 * NX + 1) * (2 * NY + 1)
    assert len(scene.points) == lattice_points + 3 * (2 * NX + 1)
    assert len(scene.quads) == 4 * NX * NY == len(scene.colouring.cells)
    assert len(np.unique(scene.quads)) == lattice_points
    assert len(scene.wires.segments) == 3 * 2 * NX
    places = {tuple(place) for place in scene.loops.flat.tolist()}
    assert len(places) == len(scene.loops.flat) == 9
    assert {(-3.0, -2.0), (0.0, -2.0), (3.0, 0.0)} <= places
    low, high = scene.points.min(axis=0), scene.points.max(axis=0)
    np.testing.assert_allclose([low[:2], high[:2]], [[-NX, -NY], [NX, NY]], atol=1e-6)


def test_loops_follow_the_warp_when_it_is_turned(tmp_path: Path) -> None:
    scene = build_scene(results(tmp_path, angle=90.0))
    np.testing.assert_allclose(scene.loops.flat[3], [-2.0, 3.0], atol=1e-12)
    np.testing.assert_allclose(scene.loops.half_span[3], [0.0, 0.5], atol=1e-12)


def test_an_unknown_field_is_answered_with_the_known_ones(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="did you mean 'weft_strain'"):
        build_scene(results(tmp_path), field="weft_stain")
