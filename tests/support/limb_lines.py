"""Lines over the skin of a bare limb: what a taut string over the joint would be strained by, without any fabric."""

from __future__ import annotations

import numpy as np

from etextile.contact.bending import Bending
from etextile.types import Array


CUFF = 120.0
"""Distance of the cuffs from the hinge along the skin, mm."""


def fitted(mesh: Bending) -> dict[str, float]:
    """Return the girths of a parametric elbow with those of the mesh at the joint and at the cuffs."""
    joint, upper, lower = mesh.girth(np.array([0.0, -CUFF, CUFF]))
    length = 160.0
    return {
        "body.joint_girth": round(float(joint), 3),
        "body.upper_girth": round(float(joint + (upper - joint) * length / CUFF), 3),
        "body.lower_girth": round(float(joint + (lower - joint) * length / CUFF), 3),
        "body.segment_length": length,
    }


def outline(limb: Bending, degrees: float) -> Array:
    """Return the outer line (n, 2) of a limb in the plane of flexion, x and z, by polar angle about the hinge."""
    posed = limb.posed(flexion=np.radians(degrees), deflated=0.0)
    half = 90.0 + 0.5 * degrees
    polar = np.radians(np.linspace(-half, half, 181))[1:-1]
    way = np.stack([np.sin(polar), np.zeros(len(polar)), np.cos(polar)], axis=1)
    low, high = np.zeros(len(polar)), np.full(len(polar), 170.0)
    for _ in range(40):
        middle = 0.5 * (low + high)
        inside = posed.distance(middle[:, None] * way).gap < 0.0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return np.asarray((0.5 * (low + high))[:, None] * way)[:, [0, 2]]


def taut(limb: Bending, degrees: float) -> float:
    """Return the strain of a string over the outer line between skin points that far from the hinge on either side."""
    lengths = []
    for angle in (0.0, degrees):
        line = outline(limb, angle)
        turn = np.radians(0.5 * angle)
        ends = []
        for side in (-1.0, 1.0):
            along = line @ np.array([side * np.cos(turn), -np.sin(turn)])
            near = side * line[:, 0] > 0.0
            ends.append(int(np.flatnonzero(near)[np.argmin(np.abs(along[near] - CUFF))]))
        hull = _upper_hull(line[min(ends) : max(ends) + 1])
        lengths.append(float(np.linalg.norm(np.diff(hull, axis=0), axis=1).sum()))
    return lengths[1] / lengths[0] - 1.0


def _upper_hull(points: Array) -> Array:
    """Return the points of a line from left to right that a taut string over it touches."""
    kept: list[Array] = []
    for point in points:
        while len(kept) > 1:
            a, b = kept[-2], kept[-1]
            if (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]) < 0.0:
                break
            kept.pop()
        kept.append(point)
    return np.array(kept)
