"""The deformed fabric, body and wires as a picture: what is drawn where; `viz.canvas` draws it with VTK.

Text, legends and markers are put on top by matplotlib (`viz.maps`), so that they look the same in every map.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from etextile.types import Array, BoolArray
from viz import gl, style, surface
from viz.camera import Camera
from viz.canvas import Canvas, Look, canvas_of, clipped, surface_of, tubes_of
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
_LIGHTS = ((-0.6, 0.8, 0.62), (0.9, 0.2, 0.2))
"""Sideways, upwards and strength of the lights: over the viewer's left shoulder, and a weaker one from the right."""


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
    canvas = canvas_of((camera.size[0] * _FINE, camera.size[1] * _FINE))
    try:
        for sideways, upwards, strength in _LIGHTS:
            canvas.light(camera.towards + sideways * camera.right + upwards * camera.up, strength)
        diagonal = float(np.linalg.norm(np.ptp(scene.flat, axis=0)))
        cloth = _fabric(canvas, scene, fabric) + _outlines(canvas, scene, camera, diagonal)
        if len(wires):
            cloth += _wires(canvas, scene, camera, wires, diagonal, width=wire_width)
        _body(canvas, scene, camera)
        canvas.look(
            camera.middle,
            _EYE * diagonal * camera.towards,
            camera.up,
            height=camera.size[1] * camera.mm_per_pixel,
            clipping=(diagonal * _CLIPPING[0], diagonal * _CLIPPING[1]),
        )
        image, depth = canvas.draw()
        for actor in cloth:
            actor.SetVisibility(False)
        body = canvas.depth() < 1.0
    finally:
        canvas.clear()
    near, far = _CLIPPING
    seen = depth[::_FINE, ::_FINE].astype(np.float64)
    nearness = np.where(seen < 1.0, diagonal * (_EYE - near - seen * (far - near)), -np.inf)
    return Picture(_shrink(image), nearness, body[::_FINE, ::_FINE], camera)


def wire_radius(scene: Scene, diagonal: float) -> float:
    """Return the radius to draw wires with, mm: much more than the real one, but they must not cover the fabric."""
    ends = scene.flat[scene.wires.segments]
    length = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum())
    spacing = float(np.prod(np.ptp(scene.flat[:, :2], axis=0))) / length
    return min(_WIRE_RADIUS * diagonal, _WIRE_COVER * spacing)


def extent(points: Array) -> tuple[Array, Array]:
    """Return the low and high corner of the box around the fabric in which the body is shown."""
    room = _BODY_MARGIN * float(np.ptp(points, axis=0).max()) * np.ones(3)
    return points.min(axis=0) - room * (1.0, 1.0, _BELOW), points.max(axis=0) + room


def _fabric(canvas: Canvas, scene: Scene, colours: NDArray[np.uint8]) -> list[Any]:
    look = Look(ambient=0.66, diffuse=0.55, edges=0.15 if len(scene.quads) <= _MOST_CELLS_WITH_EDGES else 0.0)
    return [canvas.add(surface_of(scene.points, scene.quads, colours=colours), look)]


def _outlines(canvas: Canvas, scene: Scene, camera: Camera, diagonal: float) -> list[Any]:
    """Draw the edge of the fabric, where it lay flat, and the clamps as bars."""
    edges = surface.boundary(scene.quads)
    lift = 0.5 * _LIFT * diagonal * camera.towards
    held = np.all(scene.clamped[edges], axis=1)
    flat = [] if scene.worn else [(scene.flat, edges, style.QUIET, 0.5 * _EDGE_RADIUS)]
    return [
        canvas.add(tubes_of(points, part, radius=radius * diagonal, sides=10), Look(colour, ambient=0.6, diffuse=0.5))
        for points, part, colour, radius in (
            (scene.points + lift, edges, style.EDGE, _EDGE_RADIUS),
            *flat,
            (scene.points, edges[held], style.CLAMP, _CLAMP_RADIUS),
        )
        if len(part)
    ]


def _wires(
    canvas: Canvas, scene: Scene, camera: Camera, colours: NDArray[np.uint8], diagonal: float, *, width: float
) -> list[Any]:
    """Draw the wires lifted towards the eye, which moves nothing in a parallel projection."""
    segments, points = scene.wires.segments, scene.points + _LIFT * diagonal * camera.towards
    radius = width * wire_radius(scene, diagonal)
    drawn = []
    for colour in np.unique(colours, axis=0):
        chosen = segments[np.all(colours == colour, axis=1)]
        look = Look("#{:02x}{:02x}{:02x}".format(*colour), ambient=0.6, diffuse=0.5, smooth=True)
        drawn.append(canvas.add(tubes_of(points, chosen, radius=radius, sides=12), look))
    return drawn


def _body(canvas: Canvas, scene: Scene, camera: Camera) -> None:
    """Draw the part of the body near the fabric, set back from the eye by the sag of a cell.

    Set back, it does not show through cells that are coarse beside its curvature.
    """
    if scene.body is None:
        return
    sides = scene.points[scene.quads[:, 2]] - scene.points[scene.quads[:, 0]]
    back = 0.5 * float(np.median(np.linalg.norm(sides, axis=1)))
    low, high = extent(scene.points)
    shift = -back * camera.towards
    shape = surface_of(scene.body.vertices + shift, scene.body.faces)
    if not scene.worn:
        shape = clipped(shape, low + shift, high + shift)
    canvas.add(shape, Look(style.BODY, ambient=0.45, diffuse=0.65, specular=0.15, specular_power=20.0, smooth=True))


def _shrink(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Average blocks of pixels."""
    total = np.zeros((image.shape[0] // _FINE, image.shape[1] // _FINE, 3), dtype=np.uint16)
    for row in range(_FINE):
        for column in range(_FINE):
            total += image[row::_FINE, column::_FINE]
    half = _FINE * _FINE // 2
    return np.asarray((total + half) // (_FINE * _FINE), dtype=np.uint8)
