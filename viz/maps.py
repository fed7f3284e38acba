"""The deformed maps: a rendered view of the fabric with markers, legend and caption in the style of all pictures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from etextile.types import Array
from viz import style
from viz.camera import Camera, aim
from viz.legend import caption, colour_bar, finish, line_legend, loop_markers, marker_size, sheet, state_legend, titled
from viz.render import Picture, extent, render
from viz.scene import Scene, wire_states


if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SIZE = (1600, 1100)
_CORNER = (0.015, 0.10)
_SHARE = (0.765, 0.82)
"""Lower left corner of the rendered view in the sheet, and its share of the width and height."""


@dataclass(frozen=True)
class View:
    """How a deformed map is looked at: camera name, size in pixels, end of the colour scale, points kept in sight.

    The colour scale ends at the largest value and the picture just holds the piece unless said otherwise, which a
    sequence of pictures needs.
    """

    camera: str = "iso"
    size: tuple[int, int] = SIZE
    limit: float | None = None
    in_sight: Array | None = None


def failure_map(scene: Scene, path: Path, *, view: View | None = None) -> Path:
    """Draw the deformed fabric coloured by strain, with body, wires and loops by state; return the path of the PNG.

    Raises NoGraphics without OpenGL and BadInput for an unknown camera.
    """
    figure = deformed_figure(scene, view or View(), loops=True)
    return finish(figure, path)


def strain_map(scene: Scene, path: Path, *, view: View | None = None) -> Path:
    """Draw the deformed fabric coloured by the scene's field, wires thin and dark; return the path of the PNG.

    Raises NoGraphics without OpenGL and BadInput for an unknown camera.
    """
    figure = deformed_figure(scene, view or View(), loops=False)
    return finish(figure, path)


def deformed_figure(scene: Scene, view: View, *, loops: bool) -> Figure:
    """Return the deformed map as a figure: with the loops by state, or with the strain alone."""
    camera = aim_at(scene, view)
    colouring = scene.colouring
    scale = style.strain_scale(colouring.cells if view.limit is None else view.limit)
    fabric = (255 * style.strain_colours()(scale(colouring.cells))[:, :3]).round().astype(np.uint8)
    states = wire_states(scene)
    wires = [style.wire_colour(states.get(int(wire), 0)) if loops else style.WIRE for wire in scene.wires.wire]
    picture = render(scene, camera, fabric=fabric, wires=_rgb(wires), wire_width=1.0 if loops else 0.5)
    with style.drawing():
        figure = sheet(
            view.size, titled("Failure map" if loops else colouring.heading, scene.title, provisional=scene.provisional)
        )
        share = (camera.size[0] / view.size[0], camera.size[1] / view.size[1])
        axes = figure.add_axes((*_CORNER, *share))
        _lay(figure, axes, picture)
        _outline_body(axes, picture)
        if not scene.worn:
            _axes_cross(axes, camera, scene)
        _show_parts(axes, picture, scene)
        if loops:
            _mark(axes, picture, scene)
            state_legend(figure, scene.loops.shown, place=(0.79, 0.90))
        body, clamps = scene.body is not None, bool(scene.clamped.any())
        wires_there = len(scene.wires.wire) > 0
        place = (0.79, 0.70 if loops else 0.90)
        line_legend(figure, place=place, by_state=loops, body=body, clamps=clamps, wires=wires_there, worn=scene.worn)
        colour_bar(figure, scale, f"{colouring.label} [{colouring.unit}]", place=(0.83, 0.16, 0.018, 0.38))
        caption(figure, scene)
        return figure


def pixels(scene: Scene, points: Array, *, view: View | None = None) -> Array:
    """Return where points (n, 3) lie in the deformed map of a scene: (n, 2) pixels from the top left corner."""
    view = view or View()
    camera = aim_at(scene, view)
    corner = np.array([_CORNER[0] * view.size[0], (1.0 - _CORNER[1]) * view.size[1] - camera.size[1]])
    return corner + camera.project(points)


def aim_at(scene: Scene, view: View) -> Camera:
    """Return the camera of a view, with everything in sight that should be."""
    room = (round(_SHARE[0] * view.size[0]), round(_SHARE[1] * view.size[1]))
    return aim(view.camera, seen(scene) if view.in_sight is None else view.in_sight, size=room)


def seen(scene: Scene) -> NDArray[np.float64]:
    """Return all points that should be in the picture: the fabric, flat and deformed, and the body beneath it."""
    shown = [scene.points] if scene.worn else [scene.points, scene.flat]
    if scene.body is not None:
        low, high = extent(scene.points) if not scene.worn else (-np.inf, np.inf)
        shown.append(scene.body.vertices[np.all((scene.body.vertices > low) & (scene.body.vertices < high), axis=1)])
    return np.concatenate(shown)


def _rgb(colours: list[str]) -> NDArray[np.uint8]:
    from matplotlib.colors import to_rgba_array

    return (255 * to_rgba_array(colours)[:, :3]).round().astype(np.uint8) if colours else np.zeros((0, 3), np.uint8)


def _lay(figure: Figure, axes: Axes, picture: Picture) -> None:
    """Show a picture pixel by pixel behind axes whose coordinates are its pixels.

    matplotlib would resample it first, onto the pixels it has already: half the time of drawing a map.
    """
    from matplotlib.image import FigureImage

    class Pixels(FigureImage):
        """A picture in the pixels of the figure."""

        def make_image(
            self, renderer: Any, magnification: float = 1.0, unsampled: bool = False
        ) -> tuple[Any, float, float, Any]:
            """Return the picture as it is, and its lower left corner."""
            return opaque, self.ox, self.oy, None

    height, width = picture.image.shape[:2]
    corner = axes.get_window_extent()
    opaque = np.dstack([picture.image, np.full((height, width), 255, np.uint8)])[::-1]
    pixels = Pixels(figure, offsetx=round(corner.x0), offsety=round(corner.y0))
    pixels.set_data(picture.image)
    pixels.set_zorder(-1)
    figure.add_artist(pixels)
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
            xy=(foot[0] + arrow[0], foot[1] + arrow[1]),
            xytext=(foot[0], foot[1]),
            arrowprops={"arrowstyle": "-|>", "color": style.QUIET, "shrinkA": 0, "shrinkB": 0},
        )
        tip = foot + arrow + 10.0 * arrow / np.linalg.norm(arrow)
        axes.text(
            tip[0],
            tip[1],
            name,
            fontsize=8.5,
            color=style.QUIET,
            ha="left" if arrow[0] > 5.0 else "center",
            va="center",
        )
    axes.text(
        foot[0],
        foot[1] + 0.035 * camera.size[1],
        f"arrows {length:g} mm",
        fontsize=8.5,
        color=style.QUIET,
        ha="center",
        va="top",
    )


def _show_parts(axes: Axes, picture: Picture, scene: Scene) -> None:
    """Outline the lands of parts where they are seen, with their names."""
    if scene.parts is None:
        return
    camera: Camera = picture.camera
    diagonal = float(np.linalg.norm(np.ptp(scene.flat, axis=0)))
    for name, land in zip(scene.parts.names, scene.parts.deformed, strict=True):
        if not picture.visible(land, tolerance=0.02 * diagonal).all():
            continue
        corners = camera.project(np.concatenate([land, land[:1]]))
        axes.plot(*corners.T, color=style.EDGE, linewidth=1.0, zorder=6)
        axes.annotate(
            name,
            (corners[:, 0].mean(), corners[:, 1].min()),
            xytext=(0, 3),
            textcoords="offset points",
            fontsize=7.0,
            ha="center",
            va="bottom",
            color=style.EDGE,
            zorder=8,
            parse_math=False,
        )


def _mark(axes: Axes, picture: Picture, scene: Scene) -> None:
    """Put the loops' markers where they are seen; a loop behind the fabric is left out."""
    camera: Camera = picture.camera
    diagonal = float(np.linalg.norm(np.ptp(scene.flat, axis=0)))
    shown = picture.visible(scene.loops.deformed, tolerance=0.02 * diagonal)
    places = camera.project(scene.loops.deformed)
    size = marker_size(places[shown], dpi=axes.figure.dpi, largest=9.0)
    loop_markers(axes, places[shown], scene.loops.shown[shown], size=size)
