"""The deformed maps: a rendered view of the fabric with markers, legend and caption in the style of all pictures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from viz import style
from viz.camera import Camera, aim
from viz.legend import caption, colour_bar, finish, line_legend, loop_markers, marker_size, sheet, state_legend
from viz.render import Picture, near_fabric, render
from viz.scene import Scene, wire_states


if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIZE = (1600, 1100)
_PICTURE = (0.015, 0.10, 0.765, 0.82)
"""Left, bottom, width and height of the rendered view in the sheet."""


def failure_map(scene: Scene, path: Path, *, camera: str = "iso", size: tuple[int, int] = SIZE) -> Path:
    """Draw the deformed fabric coloured by strain, with body, wires and loops by state; return the path of the PNG.

    Raises NoGraphics without OpenGL and BadInput for an unknown camera.
    """
    states = wire_states(scene.loops)
    wires = _rgb([style.wire_colour(states.get(int(wire), 0)) for wire in scene.wires.wire])
    return _deformed(scene, path, camera, size, wires, title="Failure map", loops=True)


def strain_map(scene: Scene, path: Path, *, camera: str = "iso", size: tuple[int, int] = SIZE) -> Path:
    """Draw the deformed fabric coloured by strain, wires thin and dark; return the path of the PNG."""
    wires = _rgb([style.WIRE] * len(scene.wires.wire))
    label = scene.colouring.label
    return _deformed(scene, path, camera, size, wires, title=f"{label[0].upper()}{label[1:]}", loops=False)


def _deformed(
    scene: Scene, path: Path, view: str, size: tuple[int, int], wires: NDArray[np.uint8], *, title: str, loops: bool
) -> Path:
    left, bottom, width, height = _PICTURE
    room = (round(width * size[0]), round(height * size[1]))
    camera = aim(view, _seen(scene), size=room)
    scale = style.strain_scale(scene.colouring.cells)
    fabric = (255 * style.strain_colours()(scale(scene.colouring.cells))[:, :3]).round().astype(np.uint8)
    picture = render(scene, camera, fabric=fabric, wires=wires)
    with style.drawing():
        figure = sheet(size, f"{title}: {scene.title}" if scene.title else title)
        axes = figure.add_axes((left, bottom, room[0] / size[0], room[1] / size[1]))
        _lay(axes, picture)
        _outline_body(axes, picture)
        _axes_cross(axes, camera, scene)
        if loops:
            _mark(axes, picture, scene)
            state_legend(figure, scene.loops.state, place=(0.79, 0.90))
            line_legend(figure, place=(0.79, 0.70), body=scene.body is not None, clamps=bool(scene.clamped.any()))
        colour_bar(figure, scale, f"{scene.colouring.label} [{scene.colouring.unit}]", place=(0.83, 0.16, 0.018, 0.38))
        caption(figure, scene)
        return finish(figure, path)


def _seen(scene: Scene) -> NDArray[np.float64]:
    """Return all points that should be in the picture: the fabric, flat and deformed, and the body beneath it."""
    if scene.body is None:
        return np.concatenate([scene.points, scene.flat])
    body = near_fabric(scene.body, scene.points)
    return np.concatenate([scene.points, scene.flat, body.vertices[np.unique(body.faces)]])


def _rgb(colours: list[str]) -> NDArray[np.uint8]:
    from matplotlib.colors import to_rgba_array

    return (255 * to_rgba_array(colours)[:, :3]).round().astype(np.uint8) if colours else np.zeros((0, 3), np.uint8)


def _lay(axes: Axes, picture: Picture) -> None:
    """Show a picture pixel by pixel, with axes coordinates in its pixels."""
    height, width = picture.image.shape[:2]
    axes.imshow(picture.image, extent=(0, width, height, 0), interpolation="nearest", aspect="auto")
    axes.set(xlim=(0, width), ylim=(height, 0))
    axes.set_axis_off()


def _outline_body(axes: Axes, picture: Picture) -> None:
    """Dash the outline of the body, most of which lies under the fabric."""
    if picture.body.any():
        axes.contour(picture.body, levels=[0.5], colors=style.EDGE, linewidths=0.9, linestyles=[(0, (4, 3))])


def _axes_cross(axes: Axes, camera: Camera, scene: Scene) -> None:
    """Draw warp, weft and up as arrows of a round length, which is the scale of the picture too."""
    length = style.round_up(0.1 * float(np.ptp(scene.flat, axis=0).max()))
    angle = np.deg2rad(scene.warp_angle_deg)
    warp = np.array([np.cos(angle), np.sin(angle), 0.0])
    weft = np.array([-np.sin(angle), np.cos(angle), 0.0])
    foot = np.array([0.09 * camera.size[0], 0.93 * camera.size[1]])
    centre = camera.project(camera.middle[None])[0]
    for name, direction in (("warp", warp), ("weft", weft), ("up", np.array([0.0, 0.0, 1.0]))):
        arrow = camera.project((camera.middle + length * direction)[None])[0] - centre
        if np.linalg.norm(arrow) * camera.mm_per_pixel < 0.15 * length:
            continue
        axes.annotate(
            "",
            xy=foot + arrow,
            xytext=foot,
            arrowprops={"arrowstyle": "-|>", "color": style.QUIET, "shrinkA": 0, "shrinkB": 0},
        )
        tip = foot + arrow + 10.0 * arrow / np.linalg.norm(arrow)
        axes.text(*tip, name, fontsize=8.5, color=style.QUIET, ha="left" if arrow[0] > 5.0 else "center", va="center")
    axes.text(
        foot[0],
        foot[1] + 0.035 * camera.size[1],
        f"arrows {length:g} mm",
        fontsize=8.5,
        color=style.QUIET,
        ha="center",
        va="top",
    )


def _mark(axes: Axes, picture: Picture, scene: Scene) -> None:
    """Put the loops' markers where they are seen; a loop behind the fabric is left out."""
    camera: Camera = picture.camera
    diagonal = float(np.linalg.norm(np.ptp(scene.flat, axis=0)))
    seen = picture.visible(scene.loops.deformed, tolerance=0.02 * diagonal)
    pixels = camera.project(scene.loops.deformed)
    size = marker_size(pixels, dpi=axes.figure.dpi, largest=9.0)
    loop_markers(axes, pixels[seen], scene.loops.state[seen], size=size)
