"""The deformed fabric, body and wires as a picture: the only file that draws with VTK.

Text, legends and markers are put on top by matplotlib (`viz.maps`), so that they look the same in every map.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from etextile.types import Array, BoolArray, IntArray
from viz import gl, style, surface
from viz.camera import Camera
from viz.scene import Scene


_FINE = 2
"""Pictures are drawn this many times larger and averaged: smooth edges, the same on every graphics library."""
_LIFT = 0.006
_WIRE_RADIUS = 0.0024
_WIRE_COVER = 0.09
_EDGE_RADIUS = 0.0007
_CLAMP_RADIUS = 0.007
"""Lift of wires towards the eye, radius of wires (also as a part of their spacing), outlines and clamps.

All but the spacing's are parts of the piece's diagonal.
"""
_EYE = 4.0
_CLIPPING = (1.0, 7.0)
"""Distance of the eye and of the clipping planes from it, as parts of the diagonal."""
_BODY_MARGIN = 0.02
_BELOW = 5.0
"""Room around the fabric in which the body is shown, as a part of its longest side, and how much more below."""
_MOST_CELLS_WITH_EDGES = 4000


@dataclass(frozen=True)
class Picture:
    """Colours (h, w, 3); per pixel how near the eye the surface is, mm, -inf where there is none; where the body is."""

    image: NDArray[np.uint8]
    nearness: Array
    body: BoolArray
    camera: Camera

    def visible(self, points: Array, *, tolerance: float) -> BoolArray:
        """Return which points (n, 3) are not hidden behind something by more than the tolerance, mm."""
        column, row = np.round(self.camera.project(points)).astype(np.int64).T
        height, width = self.nearness.shape
        inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
        seen = self.nearness[np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)]
        return np.asarray(inside & (self.camera.nearness(points) > seen - tolerance))


def render(
    scene: Scene, camera: Camera, *, fabric: NDArray[np.uint8], wires: NDArray[np.uint8], wire_width: float = 1.0
) -> Picture:
    """Draw a scene; `fabric` (q, 3) colours the cells and `wires` (k, 3) the wire segments. Raises NoGraphics."""
    gl.require()
    import pyvista

    width, height = camera.size
    plotter: Any = pyvista.Plotter(off_screen=True, window_size=[width * _FINE, height * _FINE], lighting="none")
    try:
        plotter.render_window.SetMultiSamples(0)
        plotter.set_background("white")
        _light(plotter, camera)
        diagonal = float(np.linalg.norm(np.ptp(scene.flat, axis=0)))
        _add_fabric(plotter, scene, fabric)
        _add_outlines(plotter, scene, camera, diagonal)
        if len(wires):
            _add_wires(plotter, scene, camera, wires, diagonal, width=wire_width)
        cloth = list(plotter.actors.values())
        _add_body(plotter, scene, camera)
        _place(plotter, camera, diagonal)
        plotter.render_window.Render()
        image, depth = _colours(plotter), _depth(plotter)
        for actor in cloth:
            actor.SetVisibility(False)
        plotter.render_window.Render()
        body = _depth(plotter) < 1.0
    finally:
        plotter.close()
    near, far = _CLIPPING
    nearness = np.where(depth < 1.0, diagonal * (_EYE - near - depth * (far - near)), -np.inf)
    return Picture(_shrink(image), nearness[::_FINE, ::_FINE], body[::_FINE, ::_FINE], camera)


def wire_radius(scene: Scene, diagonal: float) -> float:
    """Return the radius to draw wires with, mm: much more than the real one, but they must not cover the fabric."""
    ends = scene.flat[scene.wires.segments]
    length = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())
    spacing = float(np.prod(np.ptp(scene.flat[:, :2], axis=0))) / length
    return min(_WIRE_RADIUS * diagonal, _WIRE_COVER * spacing)


def _colours(plotter: Any) -> NDArray[np.uint8]:
    """Read the picture (h, w, 3), top row first."""
    from pyvista import convert_array
    from vtkmodules.vtkCommonCore import vtkUnsignedCharArray

    width, height = plotter.render_window.GetSize()
    pixels = vtkUnsignedCharArray()
    plotter.render_window.GetPixelData(0, 0, width - 1, height - 1, 0, pixels, 0)
    return np.asarray(convert_array(pixels).reshape(height, width, 3)[::-1])


def _depth(plotter: Any) -> Array:
    """Read the depth buffer (h, w), 0 at the near plane to 1 at the far plane or where nothing is, top row first."""
    from pyvista import convert_array
    from vtkmodules.vtkCommonCore import vtkFloatArray

    width, height = plotter.render_window.GetSize()
    depth = vtkFloatArray()
    plotter.render_window.GetZbufferData(0, 0, width - 1, height - 1, depth)
    return np.asarray(convert_array(depth).reshape(height, width)[::-1], dtype=np.float64)


def extent(points: Array) -> tuple[Array, Array]:
    """Return the low and high corner of the box around the fabric in which the body is shown."""
    room = _BODY_MARGIN * float(np.ptp(points, axis=0).max()) * np.ones(3)
    return points.min(axis=0) - room * (1.0, 1.0, _BELOW), points.max(axis=0) + room


def _light(plotter: Any, camera: Camera) -> None:
    """Light from over the viewer's left shoulder, and a weaker one from the right."""
    import pyvista

    for sideways, upwards, strength in ((-0.6, 0.8, 0.62), (0.9, 0.2, 0.2)):
        place = camera.towards + sideways * camera.right + upwards * camera.up
        light = pyvista.Light(position=tuple(place), focal_point=(0.0, 0.0, 0.0), intensity=strength)
        light.positional = False
        plotter.add_light(light)


def _add_fabric(plotter: Any, scene: Scene, colours: NDArray[np.uint8]) -> None:
    import pyvista

    mesh = pyvista.PolyData(scene.points, _faces(scene.quads))
    mesh.cell_data["colour"] = colours
    plotter.add_mesh(
        mesh,
        scalars="colour",
        rgb=True,
        ambient=0.66,
        diffuse=0.55,
        specular=0.0,
        show_edges=len(scene.quads) <= _MOST_CELLS_WITH_EDGES,
        edge_color="#000000",
        edge_opacity=0.15,
        line_width=1.0,
    )


def _add_outlines(plotter: Any, scene: Scene, camera: Camera, diagonal: float) -> None:
    """Draw the edge of the fabric, where it lay flat, and the clamps as bars."""
    import pyvista

    edges = surface.boundary(scene.quads)
    lift = 0.5 * _LIFT * diagonal * camera.towards
    held = np.all(scene.clamped[edges], axis=1)
    for points, part, colour, radius in (
        (scene.points + lift, edges, style.EDGE, _EDGE_RADIUS),
        (scene.flat, edges, style.QUIET, 0.5 * _EDGE_RADIUS),
        (scene.points, edges[held], style.CLAMP, _CLAMP_RADIUS),
    ):
        if len(part):
            lines = pyvista.PolyData(points, lines=np.insert(part, 0, 2, axis=1).ravel()).strip(join=True)
            tube = lines.tube(radius=radius * diagonal, n_sides=10)
            plotter.add_mesh(tube, color=colour, ambient=0.6, diffuse=0.5)


def _add_wires(
    plotter: Any, scene: Scene, camera: Camera, colours: NDArray[np.uint8], diagonal: float, *, width: float
) -> None:
    """Draw the wires lifted towards the eye, which moves nothing in a parallel projection."""
    import pyvista

    segments, points = scene.wires.segments, scene.points + _LIFT * diagonal * camera.towards
    radius = width * wire_radius(scene, diagonal)
    for colour in np.unique(colours, axis=0):
        chosen = segments[np.all(colours == colour, axis=1)]
        part = pyvista.PolyData(points, lines=np.insert(chosen, 0, 2, axis=1).ravel())
        tube = part.strip(join=True).tube(radius=radius, n_sides=12)
        plotter.add_mesh(tube, color=colour / 255.0, ambient=0.6, diffuse=0.5, specular=0.0, smooth_shading=True)


def _add_body(plotter: Any, scene: Scene, camera: Camera) -> None:
    """Draw the part of the body near the fabric, set back from the eye by the sag of a cell.

    Set back, it does not show through cells that are coarse beside its curvature.
    """
    import pyvista

    if scene.body is None:
        return
    mesh: Any = pyvista.PolyData(scene.body.vertices, _faces(scene.body.faces))
    for corner, inwards in zip(extent(scene.points), (1.0, -1.0), strict=True):
        for axis in np.eye(3):
            mesh = mesh.clip(normal=tuple(inwards * axis), origin=tuple(corner), invert=False)
    if not mesh.n_cells:
        return
    sides = scene.points[scene.quads[:, 2]] - scene.points[scene.quads[:, 0]]
    back = 0.5 * float(np.median(np.linalg.norm(sides, axis=1)))
    mesh = mesh.translate(tuple(-back * camera.towards))
    plotter.add_mesh(
        mesh, color=style.BODY, ambient=0.45, diffuse=0.65, specular=0.15, specular_power=20.0, smooth_shading=True
    )


def _faces(corners: IntArray) -> IntArray:
    return np.insert(corners, 0, corners.shape[1], axis=1).ravel()


def _place(plotter: Any, camera: Camera, diagonal: float) -> None:
    """Give VTK's camera the projection of ours."""
    eye = plotter.camera
    eye.parallel_projection = True
    eye.focal_point = tuple(camera.middle)
    eye.position = tuple(camera.middle + _EYE * diagonal * camera.towards)
    eye.up = tuple(camera.up)
    eye.parallel_scale = 0.5 * camera.size[1] * camera.mm_per_pixel
    eye.clipping_range = tuple(diagonal * bound for bound in _CLIPPING)


def _shrink(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Average blocks of pixels."""
    total = np.zeros((image.shape[0] // _FINE, image.shape[1] // _FINE, 3), dtype=np.uint16)
    for row in range(_FINE):
        for column in range(_FINE):
            total += image[row::_FINE, column::_FINE]
    half = _FINE * _FINE // 2
    return np.asarray((total + half) // (_FINE * _FINE), dtype=np.uint8)
