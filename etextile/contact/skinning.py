r"""A mesh that bends at a hinge: every vertex follows two segments by its share w of the lower one.

Segments turn about the hinge by -+delta / 2, delta the flexion less that of the rest pose. `linear` blends the two
rotations (linear blend skinning: J. P. Lewis, M. Cordner, N. Fong, SIGGRAPH 2000),

    x' = (1 - w) R(-delta/2) x + w R(delta/2) x = cos(delta/2) x + (2 w - 1) sin(delta/2) (z, 0, -x)

so that where w = 1/2 a point comes nearer to the hinge by cos(delta / 2): the limb collapses, by 13 % at 60 degrees
from the rest pose and 29 % at 90. `dual_quaternion` blends the rotations themselves (L. Kavan et al., ACM Trans.
Graphics 27(4), 2008), about one hinge a rotation by 2 atan((2 w - 1) tan(delta / 4)): distances from the hinge stay.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from etextile.types import Array, IntArray


LINEAR, DUAL = KINDS = ("linear", "dual_quaternion")

CREASE_DEG = 75.0
"""Edges whose triangles meet at more than this angle stay sharp (the rims of the caps). Meshes made for skinning are
coarse, and bending sharpens the edges over a joint: those of skin are not meant as edges."""


@dataclass(frozen=True)
class SkinnedMesh:
    """Vertices (v, 3) mm in the rest pose, the hinge in the origin along y; triangles (f, 3); shares w (v,).

    rest: flexion (rad) of the rest pose, in which upper and lower segment are turned by half of it each; kind: one of
    KINDS.
    """

    vertices: Array = field(repr=False)
    faces: IntArray = field(repr=False)
    weight: Array = field(repr=False)
    rest: float
    kind: str = LINEAR

    def bent(self, flexion: float) -> Array:
        """Return the vertices (v, 3) at a flexion (rad)."""
        delta, lean = flexion - self.rest, 2.0 * self.weight - 1.0
        if self.kind == LINEAR:
            cos, sin = np.full(len(lean), np.cos(0.5 * delta)), lean * np.sin(0.5 * delta)
        else:
            turn = 2.0 * np.arctan(lean * np.tan(0.25 * delta))
            cos, sin = np.cos(turn), np.sin(turn)
        x, y, z = self.vertices.T
        return np.stack([cos * x + sin * z, y, cos * z - sin * x], axis=1)

    def shrunk(self, flexion: float, depth: float) -> Array:
        """Return the vertices (v, 3) at a flexion (rad), `depth` mm inside of the surface, for drawing."""
        from etextile.contact.refine import unit

        vertices = self.bent(flexion)
        if depth == 0.0:
            return vertices
        corners = vertices[self.faces]
        outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normal = np.zeros_like(vertices)
        for corner in range(3):
            np.add.at(normal, self.faces[:, corner], outward)
        return np.asarray(vertices - depth * unit(normal))
