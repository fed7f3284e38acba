"""The deformed fabric of a page as compact arrays: cells, wires, loops, parts and body at every step.

Places are rounded to a 65 535th of the scene. A fine fabric is thinned: what is drawn, never what is judged.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np

from etextile.types import Array, IntArray
from viz.scene import Scene
from viz.style import BODY


MOST_CELLS = 12_000
"""Fabric cells that are drawn; a finer fabric is thinned to every second, third, ... yarn."""
GRID_DIGITS = 4
"""Decimals of a millimetre by which yarns are told apart."""
PARTS = 65535
SAG = 0.18
"""Depth to which a cell cuts into a body over its diagonal, at most: that of a diagonal over a right angle."""
DEEP = 0.9
"""Share of the touching cells of which a page hides how deep they cut."""
_TINY = 1e-9


def shape_data(scenes: Sequence[Scene]) -> dict[str, Any]:
    """Return what viz/static/fabric.js draws, over the steps; points stand there once, whoever uses them."""
    last = scenes[-1]
    quads, _ = thinned(last)
    used, cells = np.unique(quads, return_inverse=True)
    wire_points, segments = np.unique(last.wires.segments, return_inverse=True)
    low, size = spans(np.concatenate([scene.points for scene in scenes]))
    return {
        "steps": len(scenes),
        "low": low.tolist(),
        "scale": size / PARTS,
        "points": packed(rounded([scene.points[used] for scene in scenes], low, size)),
        "cells": packed(cells.astype(np.uint32)),
        "wire_points": packed(rounded([scene.points[wire_points] for scene in scenes], low, size)),
        "segments": packed(segments.astype(np.uint32)),
        "loops": packed(rounded([scene.loops.deformed for scene in scenes], low, size)),
        "parts": _parts(scenes, low, size),
        "body": _body(scenes),
        "thinned": len(quads) < len(last.quads),
    }


def thinned(scene: Scene) -> tuple[IntArray, IntArray]:
    """Return the cells (q, 4) to draw, and for every cell of the scene the number of the drawn one it lies in.

    Squares of cells become one each; where a square is not full, at holes and curved edges, its cells are kept.
    """
    quads = scene.quads
    if len(quads) <= MOST_CELLS:
        return quads, np.arange(len(quads))
    stride = int(np.ceil(np.sqrt(len(quads) / MOST_CELLS)))
    place, lines = _grid(scene)
    low = place[quads].min(axis=1)
    blocks, block, count = np.unique(low // stride, axis=0, return_inverse=True, return_counts=True)
    near, far = blocks * stride, np.minimum((blocks + 1) * stride, lines - 1)
    corners = np.stack([near, np.stack([far[:, 0], near[:, 1]], 1), far, np.stack([near[:, 0], far[:, 1]], 1)], axis=1)
    nodes = np.unique(quads)
    key, first = np.unique(place[nodes] @ (lines[1], 1), return_index=True)
    wanted = corners @ (lines[1], 1)
    at = np.minimum(np.searchsorted(key, wanted), len(key) - 1)
    whole = (count == np.prod(far - near, axis=1)) & (key[at] == wanted).all(axis=1)
    number = np.cumsum(whole) - 1
    kept = ~whole[block.ravel()]
    owner = np.where(kept, whole.sum() + np.cumsum(kept) - 1, number[block.ravel()])
    return np.concatenate([nodes[first[at[whole]]], quads[kept]]), owner


def _grid(scene: Scene) -> tuple[IntArray, IntArray]:
    """Return the yarns (n, 2) that cross at each point of the fabric, counted along both directions, and how many."""
    angle = np.radians(scene.warp_angle_deg)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    nodes = np.unique(scene.quads)
    flat = np.round(scene.flat[nodes, :2] @ turn, GRID_DIGITS)
    found = [np.unique(flat[:, axis], return_inverse=True) for axis in (0, 1)]
    place = np.full((len(scene.flat), 2), -1)
    place[nodes] = np.stack([inverse for _, inverse in found], axis=1)
    return place, np.array([len(values) for values, _ in found])


def _parts(scenes: Sequence[Scene], low: Array, size: float) -> dict[str, Any] | None:
    """Return the lands of parts: names, corners (P, 4, 2) when flat and over the steps (S, P, 4, 3)."""
    last = scenes[-1].parts
    if last is None:
        return None
    places = [scene.parts.deformed.reshape(-1, 3) for scene in scenes if scene.parts is not None]
    return {
        "names": list(last.names),
        "flat": np.round(last.flat, 3).tolist(),
        "places": packed(rounded(places, low, size)),
    }


def _body(scenes: Sequence[Scene]) -> dict[str, Any] | None:
    """Return the body: every pose once and which one a step has; a rigid body once, with its shift at every step."""
    bodies = [scene.body for scene in scenes]
    if any(body is None for body in bodies):
        return None
    vertices = [body.vertices for body in bodies if body is not None]
    shift = [(item - vertices[0]).mean(axis=0) for item in vertices]
    rigid = all(np.abs(item - vertices[0] - by).max() < 1e-6 for item, by in zip(vertices, shift, strict=True))
    places = [vertices[0]] if rigid else vertices
    low, size = spans(np.concatenate(places))
    faces = next(body.faces for body in bodies if body is not None)
    poses, pose = _distinct(rounded(places, low, size))
    return {
        "low": low.tolist(),
        "scale": size / PARTS,
        "points": packed(poses),
        "pose": [0] * len(scenes) if rigid else pose,
        "faces": packed(np.asarray(faces).astype(np.uint32)),
        "shrink": sag(scenes[-1]),
        "depth": sag(scenes[-1], share=DEEP),
        "colour": BODY,
        "shift": [item.tolist() for item in shift] if rigid else None,
    }


def _distinct(places: Any) -> tuple[Any, list[int]]:
    """Return the rows (P, n, 3) of places (S, n, 3) that differ, in their order, and the row of every step (S,)."""
    number: dict[bytes, int] = {}
    pose = [number.setdefault(row.tobytes(), len(number)) for row in places]
    return places[[pose.index(k) for k in range(len(number))]], pose


def sag(scene: Scene, *, share: float = 0.5) -> float:
    """Return how deep (mm) flat cells cut into a body between their corners, at that `share` of those that touch it.

    The body is drawn smaller by the half of them, and gives way to what lies behind it by no more than the deepest.
    """
    quads, _ = thinned(scene)
    touching = quads[scene.touched[quads].any(axis=1)]
    if not len(touching):
        return 0.0
    across = np.linalg.norm(scene.points[touching[:, [2, 3]]] - scene.points[touching[:, [0, 1]]], axis=2).max(axis=1)
    return SAG * float(np.quantile(across, share))


def spans(places: Array) -> tuple[Array, float]:
    """Return the lowest coordinates of places (n, d) and the largest extent, never 0."""
    return places.min(axis=0), float(max(np.ptp(places, axis=0).max(), _TINY))


def rounded(places: Sequence[Array] | Array, low: Array, size: float) -> Any:
    """Return places (..., d) as whole parts of `size` from `low` on, two bytes each."""
    return np.round(np.clip((np.asarray(places) - low) / size, 0.0, 1.0) * PARTS).astype(np.uint16)


def packed(values: Any) -> str:
    """Return the bytes of an array, little-endian, as text."""
    little = values.astype(values.dtype.newbyteorder("<"), copy=False)
    return base64.b64encode(np.ascontiguousarray(little).tobytes()).decode()
