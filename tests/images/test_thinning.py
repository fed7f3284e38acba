"""A fine fabric is drawn by fewer cells and steps: they cover it once and show its largest values."""

from __future__ import annotations

import base64
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from viz.live import STEPS_OF_FINE, chosen_steps, field_data
from viz.scene import Colouring, Scene
from viz.shape import MOST_CELLS, sag, thinned


def fine(scene: Scene, cells: tuple[int, int], *, seed: int = 3) -> Scene:
    """The scene on a lattice of so many cells whose values are random; its wires lie between the nodes."""
    lines = [np.linspace(-50.0, 50.0, count + 1) for count in cells]
    x, y = (axis.ravel() for axis in np.meshgrid(*lines, indexing="ij"))
    number = np.arange(len(x)).reshape(cells[0] + 1, cells[1] + 1)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], axis=-1).reshape(-1, 4)
    wire = np.column_stack([np.linspace(-49.7, 49.7, 331), np.full(331, 0.0371), np.zeros(331)])
    points = np.concatenate([np.column_stack([x, y, 0.0 * x]), wire])
    values = np.random.default_rng(seed).random(len(quads))
    return replace(
        scene,
        flat=points,
        points=points,
        quads=quads,
        colouring=Colouring("warp strain", "%", values, float(values.max())),
        touched=np.zeros(len(points), dtype=bool),
        clamped=np.zeros(len(points), dtype=bool),
        wires=replace(scene.wires, segments=len(x) + np.column_stack([np.arange(330), np.arange(1, 331)]),
                      wire=np.zeros(330, dtype=np.int64), strain=np.zeros(330)),
    )  # fmt: skip


def area(points: np.ndarray, quads: np.ndarray) -> np.ndarray:
    """Areas (q,) of flat cells by the cross product of their diagonals."""
    a, b = points[quads[:, 2]] - points[quads[:, 0]], points[quads[:, 3]] - points[quads[:, 1]]
    return 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


@pytest.mark.parametrize("cells", [(180, 305), (331, 166), (111, 109)])
def test_drawn_cells_cover_the_fabric_once_and_own_what_lies_in_them(
    scene: Callable[..., Scene], cells: tuple[int, int]
) -> None:
    made = fine(scene(), cells)
    drawn, owner = thinned(made)
    assert len(drawn) <= MOST_CELLS < len(made.quads)
    assert area(made.flat, drawn).sum() == pytest.approx(100.0 * 100.0)
    middle = made.flat[made.quads].mean(axis=1)
    corners = made.flat[drawn[owner]]
    assert (owner >= 0).all()
    assert (corners[:, :, :2].min(axis=1) < middle[:, :2]).all()
    assert (middle[:, :2] < corners[:, :, :2].max(axis=1)).all()
    shown = np.frombuffer(base64.b64decode(field_data([made], owner)["values"]), dtype=np.uint8)
    largest = [made.colouring.cells[owner == number].max() for number in (0, 77, len(drawn) - 1)]
    assert shown[[0, 77, -1]] == pytest.approx(250.0 * np.array(largest), abs=0.51)


def test_holes_stay_holes(scene: Callable[..., Scene]) -> None:
    made = fine(scene(), (180, 305))
    middle = made.flat[made.quads].mean(axis=1)
    kept = np.hypot(middle[:, 0], middle[:, 1]) > 20.0
    made = replace(made, quads=made.quads[kept], colouring=replace(made.colouring, cells=made.colouring.cells[kept]))
    drawn, _ = thinned(made)
    assert area(made.flat, drawn).sum() == pytest.approx(100.0 * 100.0 - np.pi * 20.0**2, rel=0.05)
    assert np.hypot(*made.flat[drawn].mean(axis=1)[:, :2].T).min() > 17.0


def test_a_coarse_fabric_is_drawn_as_it_is(scene: Callable[..., Scene]) -> None:
    made = fine(scene(), (40, 60))
    drawn, owner = thinned(made)
    assert np.array_equal(drawn, made.quads)
    assert np.array_equal(owner, np.arange(len(drawn)))


def test_a_body_under_thinned_cells_is_drawn_smaller_by_what_these_cut_into_it(scene: Callable[..., Scene]) -> None:
    found = fine(scene(), (300, 300))
    found = replace(found, touched=np.linalg.norm(found.flat, axis=1) < 10.0)
    drawn, _ = thinned(found)
    across = np.linalg.norm(found.points[drawn[:, 2]] - found.points[drawn[:, 0]], axis=1)
    assert sag(found) == pytest.approx(0.18 * np.median(across), rel=0.05)
    assert sag(replace(found, touched=np.zeros(len(found.flat), dtype=bool))) == 0.0


def test_steps_about_the_break_are_always_drawn() -> None:
    assert chosen_steps(100, 80) == list(range(80))
    some = chosen_steps(MOST_CELLS + 1, 80, keep=(36, 37))
    assert {0, 36, 37, 79} <= set(some)
    assert len(some) <= STEPS_OF_FINE + 2
    assert some == sorted(some)
