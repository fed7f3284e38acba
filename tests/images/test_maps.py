"""Maps by their meaning: what is broken looks broken, where it is broken, on any graphics library."""

import sys
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

from etextile.errors import BadInput
from viz import flat, gl, maps, style
from viz.animate import animate
from viz.legend import finish
from viz.maps import View
from viz.mirror import whole
from viz.scene import Scene, SceneLoops, SceneWires


Maker = Callable[..., Scene]
SMALL = (800, 560)


def read(path: Path) -> np.ndarray:
    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB"), dtype=float) / 255.0


def colour_at(image: np.ndarray, pixel: np.ndarray) -> np.ndarray:
    column, row = np.round(pixel).astype(int)
    return image[row, column]


def lightness(colour: np.ndarray) -> float:
    return style.luminance(tuple(np.clip(colour, 0.0, 1.0)))


def assert_states(image: np.ndarray, pixels: np.ndarray, states: np.ndarray) -> None:
    assert len(states)
    for pixel, state in zip(pixels, states, strict=True):
        wanted = np.array(to_rgb(style.STATES[state].colour))
        np.testing.assert_allclose(colour_at(image, pixel), wanted, atol=0.02)


@pytest.mark.parametrize("states", [(0, 1, 2), (3, 2, 1), (3, 3, 0)])
def test_flat_map_shows_each_loop_in_the_colour_of_its_state(
    scene: Maker, tmp_path: Path, states: tuple[int, ...]
) -> None:
    shown = scene(states=states)
    figure = flat.flat_failure_figure(shown)
    image = read(finish(figure, tmp_path / "flat.png"))
    assert image.shape[:2] == flat.SIZE[::-1]
    pixels = figure.axes[0].transData.transform(shown.loops.flat)
    pixels[:, 1] = image.shape[0] - pixels[:, 1]
    assert_states(image, pixels, shown.loops.state)


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize("states", [(0, 1, 2), (3, 2, 1)])
def test_deformed_map_from_above_shows_each_loop_in_the_colour_of_its_state(
    scene: Maker, tmp_path: Path, states: tuple[int, ...]
) -> None:
    shown, view = scene(states=states), View(camera="top", size=SMALL)
    image = read(maps.failure_map(shown, tmp_path / "failure.png", view=view))
    assert image.shape[:2] == SMALL[::-1]
    assert_states(image, maps.pixels(shown, shown.loops.deformed, view=view), shown.loops.state)


@pytest.mark.usefixtures("opengl")
def test_loops_behind_the_fabric_are_not_shown(scene: Maker, tmp_path: Path) -> None:
    shown, view = scene(states=(2, 2, 2)), View(camera="side", size=SMALL)
    bare = replace(shown, wires=SceneWires(shown.wires.segments[:0], shown.wires.wire[:0], shown.wires.strain[:0]))
    image = read(maps.failure_map(bare, tmp_path / "side.png", view=view))
    before, behind = shown.loops.flat[:, 1] == -40.0, shown.loops.flat[:, 1] == 40.0
    places = maps.pixels(bare, shown.loops.deformed, view=view)
    np.testing.assert_allclose(places[before], places[behind])
    assert_states(image, places[before], shown.loops.state[before])
    given = {entry.name: getattr(shown.loops, entry.name) for entry in fields(SceneLoops)}
    hidden = SceneLoops(**{name: values[behind] for name, values in given.items() if len(values)})
    image = read(maps.failure_map(replace(bare, loops=hidden), tmp_path / "hidden.png", view=view))
    broken = np.array(to_rgb(style.STATES[2].colour))
    for pixel in places[behind]:
        assert np.abs(colour_at(image, pixel) - broken).max() > 0.2


@pytest.mark.usefixtures("opengl")
def test_more_strain_is_darker_and_the_colour_is_that_of_the_scale(scene: Maker, tmp_path: Path) -> None:
    shown, view = scene(), View(camera="top", size=SMALL)
    image = read(maps.strain_map(shown, tmp_path / "strain.png", view=view))
    centres = shown.points[shown.quads].mean(axis=1)
    rows = np.flatnonzero(np.isclose(centres[:, 1], 32.5) & (centres[:, 0] > 0))
    order = rows[np.argsort(shown.colouring.cells[rows])]
    seen = [lightness(colour_at(image, pixel)) for pixel in maps.pixels(shown, centres[order], view=view)]
    assert np.all(np.diff(seen) < 0)
    ramp = style.strain_colours()(style.strain_scale(40.0)(shown.colouring.cells[order]))[:, :3]
    np.testing.assert_allclose(seen, [lightness(colour) for colour in ramp], atol=16.0)


@pytest.mark.usefixtures("opengl")
def test_nothing_is_drawn_beside_the_fabric_and_the_body_shows_below_it(scene: Maker, tmp_path: Path) -> None:
    shown, view = scene(), View(camera="side", size=SMALL)
    high = replace(shown, points=shown.points + np.array([0.0, 0.0, 12.0]))
    image = read(maps.failure_map(high, tmp_path / "body.png", view=view))
    body = maps.pixels(high, np.array([[3.0, 0.0, 20.0]]), view=view)
    grey = colour_at(image, body[0])
    assert np.ptp(grey) < 0.06
    assert 0.2 < grey.mean() < 0.9
    assert image[5, 5].min() == 1.0


@pytest.mark.usefixtures("opengl")
def test_a_mirrored_quarter_looks_like_the_whole(scene: Maker, tmp_path: Path) -> None:
    quarter = replace(whole(scene(quarter=True)), portion="whole")
    body = scene().body
    one = read(maps.failure_map(replace(quarter, body=body), tmp_path / "quarter.png", view=View(size=SMALL)))
    two = read(maps.failure_map(scene(), tmp_path / "whole.png", view=View(size=SMALL)))
    assert np.abs(one - two).mean() < 2e-3


@pytest.mark.usefixtures("opengl")
def test_the_same_scene_gives_the_same_file(scene: Maker, tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("one.png", "two.png")]
    for path in paths:
        maps.failure_map(scene(), path, view=View(size=SMALL))
    assert paths[0].read_bytes() == paths[1].read_bytes()
    for path in paths:
        flat.wire_strain_map(scene(), path, onset=0.07)
    assert paths[0].read_bytes() == paths[1].read_bytes()


@pytest.mark.usefixtures("opengl")
@pytest.mark.parametrize("size", [(640, 480), (1000, 500)])
def test_pictures_have_the_size_asked_for(scene: Maker, tmp_path: Path, size: tuple[int, int]) -> None:
    maps.failure_map(scene(), tmp_path / "a.png", view=View(size=size))
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.size == size


def test_wire_strain_map_colours_loops_by_their_strain(scene: Maker, tmp_path: Path) -> None:
    shown = scene(states=(0, 1, 3))
    image = read(flat.wire_strain_map(shown, tmp_path / "wires.png"))
    figure = flat.flat_failure_figure(shown)
    pixels = figure.axes[0].transData.transform(shown.loops.flat)
    pixels[:, 1] = image.shape[0] - pixels[:, 1]
    ramp = style.strain_colours()(style.strain_scale(12.0)(100.0 * shown.loops.wire_strain))[:, :3]
    for pixel, colour in zip(pixels, ramp, strict=True):
        np.testing.assert_allclose(colour_at(image, pixel), colour, atol=0.02)


@pytest.mark.usefixtures("opengl")
def test_an_animation_keeps_camera_and_scale(scene: Maker, tmp_path: Path) -> None:
    last = scene()
    first = replace(
        last,
        points=last.flat,
        colouring=replace(last.colouring, cells=0.1 * last.colouring.cells, peak=4.0),
        loops=replace(last.loops, deformed=np.column_stack([last.loops.flat, np.zeros(len(last.loops.flat))])),
    )
    (path,) = animate([first, last], tmp_path / "run.gif", view=View(camera="top", size=SMALL))
    with Image.open(path) as moving:
        assert moving.n_frames == 2
        frames = []
        for number in range(2):
            moving.seek(number)
            frames.append(np.asarray(moving.convert("RGB"), dtype=float) / 255.0)
    middle = maps.pixels(last, np.array([[7.5, 27.5, 0.0]]), view=View(camera="top", size=SMALL))[0]
    light, dark = (lightness(colour_at(frame, middle)) for frame in frames)
    assert light - dark > 30.0
    scales = [frame[SMALL[1] // 2 :, -140:] for frame in frames]
    np.testing.assert_allclose(scales[0], scales[1], atol=0.1)
    numbered = animate([first, last], tmp_path / "run.png", view=View(camera="top", size=SMALL))
    assert [path.name for path in numbered] == ["run_0.png", "run_1.png"]


def test_a_wrong_camera_or_animation_is_told(scene: Maker, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="did you mean 'side'"):
        maps.aim_at(scene(), View(camera="sied"))
    with pytest.raises(BadInput, match="mp4"):
        animate([scene()], tmp_path / "run.mp4")


@pytest.mark.skipif(sys.platform != "linux", reason="other systems bring OpenGL")
def test_without_opengl_the_remedy_is_told_and_flat_maps_are_drawn(
    scene: Maker, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An X window without an X server crashes VTK just as a missing library does."""
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.setenv("VTK_DEFAULT_OPENGL_WINDOW", "vtkXOpenGLRenderWindow")
    gl.available.cache_clear()
    try:
        with pytest.raises(gl.NoGraphics, match="apt-get install libegl1 libgl1-mesa-dri"):
            maps.failure_map(scene(), tmp_path / "failure.png")
        assert not (tmp_path / "failure.png").exists()
        assert flat.flat_failure_map(scene(), tmp_path / "flat.png").exists()
    finally:
        gl.available.cache_clear()


def test_states_are_told_apart_in_grey_and_by_shape() -> None:
    steps = -np.diff([style.luminance(look.colour) for look in style.STATES])
    assert np.all(steps > 15.0)
    assert len({look.marker for look in style.STATES}) == len(style.STATES)


def test_strain_colours_fall_evenly_in_lightness() -> None:
    ramp = [style.luminance(tuple(colour[:3])) for colour in style.strain_colours()(np.linspace(0.0, 1.0, 33))]
    np.testing.assert_allclose(ramp, np.linspace(ramp[0], ramp[-1], 33), atol=1.5)
    assert ramp[0] - ramp[-1] > 70.0
