"""A body mesh that bends at a joint: cut from a scan or an animation model, skinned, baked at poses.

mesh file, rig and weights -> limb in the frame of its hinge (limb_recipe.py, limb_cut.py) -> vertices at any flexion
(skinning.py) -> distance over space and angle (poses.py). Where the straight limb begins a piece is round, about the
mean middle of the limb's sections, with their girth; growing, the limb gives it its own shape. In the crook the mesh
runs into itself and the distance is that of the union; as for every limb, what folds there stays undetermined.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Self

import numpy as np

from etextile.contact.bending import Bending
from etextile.contact.body import Distance, evaluation_points, require_positive
from etextile.contact.grid import RIM
from etextile.contact.limb import SKIN_LENGTH
from etextile.contact.limb_recipe import LimbRecipe, fading_length, unbaked
from etextile.contact.mesh import automatic_spacing, checked_spacing
from etextile.contact.poses import PosedMesh, everywhere
from etextile.contact.sections import Sections
from etextile.contact.skinning import SkinnedMesh
from etextile.types import Array, IntArray


NODES = 150_000
"""Size of the distance grid of a pose where its spacing is not given: there are 33 of them."""


@dataclass(frozen=True)
class SkinnedLimb(Bending):
    """A skinned mesh in a pose: its grids (made when first asked), its sections when straight, what it was made from.

    length: of the segments from the hinge, mm; skin_length as in `Bending`; flexion (rad) and deflated (mm): the pose.
    """

    source: PosedMesh = field(repr=False)
    sections: Sections = field(repr=False)
    length: float
    skin_length: float = SKIN_LENGTH
    flexion: float = 0.0
    deflated: float = 0.0
    notes: tuple[str, ...] = ()

    @property
    def skin(self) -> SkinnedMesh:
        """The mesh with its weights."""
        return self.source.mesh

    @property
    def lower_share(self) -> float:
        """Return one half: both segments turn alike."""
        return 0.5

    @property
    def middle(self) -> Array:
        """Return the mean middle (2,) of the sections, mm."""
        return self.sections.middle

    def posed(self, *, flexion: float, deflated: float) -> Self:
        """Return the limb bent by `flexion` (rad), standing `deflated` mm inside of its own surface."""
        return replace(self, flexion=flexion, deflated=deflated)

    def distance(self, points: Array) -> Distance:
        """Return the signed distance of `points` (n, 3); outside the grid a positive lower bound."""
        found = self.source.grids.at(self.flexion).distance(evaluation_points(points))
        return Distance(found.gap + self.deflated, found.normal, found.hessian)

    def rate(self, points: Array) -> Array:
        """Return the derivative (n,) of the distance of fixed points by the flexion, mm per rad; 0 outside the grid."""
        points = evaluation_points(points)
        slope = self.source.grids.rate_at(self.flexion)
        place = (points - slope.origin) / slope.spacing
        within = np.all((place >= RIM) & (place <= np.array(slope.coefficients.shape) - 1.0 - RIM), axis=1)
        return np.where(within, slope.distance(points).gap, 0.0)

    def radius(self, along: Array) -> Array:
        """Return the girth (n,) over 2 pi of the straight limb at places `along` (n,) x, mm."""
        return self.sections.radius(along)

    def fitted(self, places: Array) -> Array:
        """Return nodes (n, 3) of a round piece about `middle` on the sections, as far round; loose ones with ease."""
        return self.sections.fitted(places)

    def surface(self, *, edge: float = 4.0) -> tuple[Array, IntArray]:
        """Return the mesh in its pose."""
        return self.skin.shrunk(self.flexion, self.deflated), self.skin.faces

    def bounds(self) -> Array:
        """Return the box (2, 3) around all poses."""
        return np.asarray(self.sections.box)

    def support(self, direction: Array) -> float:
        """Return the maximum of x . direction over the vertices in this pose."""
        return float((self.surface()[0] @ direction).max())


def limb_mesh(
    *,
    file: str | Path,
    rig: str | Path,
    weights: str | Path,
    joint: str,
    group: str | None = None,
    scale: float = 1.0,
    axis: tuple[float, float, float] | None = None,
    skinning: str = "linear",
    joint_girth: float | None = None,
    segment_length: float | None = None,
    skin_length: float | None = None,
    grid_spacing: float | None = None,
) -> SkinnedLimb:
    """Return the straight limb cut at `joint` from a mesh `file` with `rig` and `weights`, see the case file's keys.

    Raises BadInput for files that cannot be used or do not belong together, an unknown joint or group, a rest pose that
    does not tell the axis, a limb that is open, in pieces or of doubtful size, and a grid that does not fit.
    """
    axis = None if axis is None else (float(axis[0]), float(axis[1]), float(axis[2]))
    made = unbaked(LimbRecipe(file, rig, weights, joint, group, scale, axis, skinning, joint_girth, segment_length))
    if skin_length is not None:
        require_positive(skin_length=skin_length)
    around = everywhere(made.mesh)
    spacing = automatic_spacing(around, NODES) if grid_spacing is None else checked_spacing(around, grid_spacing)
    source = PosedMesh(made.mesh, spacing)
    stretch = fading_length(made.mesh) if skin_length is None else skin_length
    return SkinnedLimb(source, made.sections, made.length, skin_length=stretch, notes=made.notes)
