"""Planar holes of a mesh closed: a scan of a limb ends at the planes it was cut at.

A hole is closed only when its rim lies in one plane and its middle sees all of the rim; anything else is a defect of
the scan, and what is inside of the body there would be guessed.
"""

from __future__ import annotations

import numpy as np

from etextile.errors import BadInput
from etextile.types import Array, IntArray


FLAT = 0.02
"""A rim is planar when no vertex stands further off its plane than this share of its diameter."""


def capped(vertices: Array, faces: IntArray, *, name: str) -> tuple[Array, IntArray, tuple[str, ...]]:
    """Return a mesh whose planar holes are closed by fans about their middles, and notes.

    Raises BadInput for a hole that is not planar, and for one whose middle does not see its rim.
    """
    notes, extra, points = [], [faces], [vertices]
    for count, rim in enumerate(rims(faces)):
        ring = vertices[rim]
        middle = ring.mean(axis=0)
        along, across, normal = np.linalg.svd(ring - middle, full_matrices=False)[2]
        flat = np.column_stack([(ring - middle) @ along, (ring - middle) @ across])
        diameter = float(2.0 * np.linalg.norm(flat, axis=1).max())
        off = float(np.abs((ring - middle) @ normal).max())
        where = f"around ({', '.join(f'{value:.4g}' for value in middle)})"
        if off > FLAT * diameter:
            message = (
                f"has a hole {where}, {diameter:.3g} mm wide, that is not planar (by {off:.2g} mm): close it by hand"
            )
            raise BadInput.of(message, file=name, key="body.cap_holes")
        after = np.roll(flat, -1, axis=0)
        areas = flat[:, 0] * after[:, 1] - flat[:, 1] * after[:, 0]
        if not (np.all(areas > 0.0) or np.all(areas < 0.0)):
            message = f"has a hole {where} whose middle does not see all of its rim: close it by hand"
            raise BadInput.of(message, file=name, key="body.cap_holes")
        top = len(vertices) + count
        points.append(middle[None])
        extra.append(np.column_stack([np.roll(rim, -1), rim, np.full(len(rim), top)]))
        notes.append(f"a planar hole {where}, {diameter:.3g} mm wide, was closed")
    return np.concatenate(points), np.concatenate(extra), tuple(notes)


def rims(faces: IntArray) -> list[IntArray]:
    """Return the rims of a mesh's holes, each as its vertices in the order in which the triangles run along it.

    A vertex at which two holes touch ends the search for that hole: it is left open and found later.
    """
    start, end = faces.reshape(-1), np.roll(faces, -1, axis=1).reshape(-1)
    key = np.sort(np.column_stack([start, end]), axis=1)
    _, inverse, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    alone = count[inverse.reshape(-1)] == 1
    follow = dict(zip(start[alone].tolist(), end[alone].tolist(), strict=True))
    found = []
    while follow:
        first, here = follow.popitem()
        rim = [first]
        while here in follow and here != first:
            rim.append(here)
            here = follow.pop(here)
        if here == first and len(rim) > 2:
            found.append(np.array(rim, dtype=np.int64))
    return found
