"""A body mesh that bends at a joint: cut from a scan or an animation model, skinned, baked at poses.

mesh file, rig and weights -> limb in the frame of its hinge (limb_cut.py) -> vertices at any flexion (skinning.py) ->
distance over space and angle (poses.py). Where the straight limb begins a piece is round, about the mean middle of the
limb's sections, with their girth; growing, the limb gives it its own shape. In the crook the mesh runs into itself and
the distance is that of the union; as for every limb, what folds there stays undetermined.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Self

import numpy as np

from etextile.contact.bending import Bending
from etextile.contact.body import Distance, evaluation_points, require, require_positive
from etextile.contact.grid import RIM
from etextile.contact.limb import SKIN_LENGTH
from etextile.contact.limb_cut import LENGTH, HingeFrame, cut_limb, require_scale
from etextile.contact.mesh import automatic_spacing, checked_spacing
from etextile.contact.mesh_obj import read_ordered
from etextile.contact.poses import PosedMesh, everywhere
from etextile.contact.rig import hinge_of, read_rig, read_weights
from etextile.contact.sections import Sections, sections_of
from etextile.contact.skinning import KINDS, SkinnedMesh
from etextile.errors import BadInput
from etextile.types import Array, IntArray


NODES = 150_000
"""Size of the distance grid of a pose where its spacing is not given: there are 33 of them."""

LEAST_FADE, MOST_FADE = 0.05, 0.95
"""Shares of the lower segment between which a vertex counts for the length of skin that stretches."""


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
    made = unbaked(
        file=file, rig=rig, weights=weights, joint=joint, group=group, scale=scale, axis=axis, skinning=skinning,
        joint_girth=joint_girth, segment_length=segment_length,
    )  # fmt: skip
    if skin_length is not None:
        require_positive(skin_length=skin_length)
    around = everywhere(made.mesh)
    spacing = automatic_spacing(around, NODES) if grid_spacing is None else checked_spacing(around, grid_spacing)
    source = PosedMesh(made.mesh, spacing)
    stretch = fading_length(made.mesh) if skin_length is None else skin_length
    return SkinnedLimb(source, made.sections, made.length, skin_length=stretch, notes=made.notes)


@dataclass(frozen=True)
class UnbakedLimb:
    """A limb before its grids are made: mesh, sections, length of its segments (mm), what was found out."""

    mesh: SkinnedMesh
    sections: Sections
    length: float
    notes: tuple[str, ...]

    @property
    def girth(self) -> float:
        """Girth at the joint, straight, mm."""
        return float(2.0 * np.pi * self.sections.radius(np.zeros(1))[0])


def unbaked(
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
) -> UnbakedLimb:
    """Return a limb without its grids, from memory where its files have not changed; raises BadInput."""
    paths = tuple(Path(name) for name in (file, rig, weights))
    stamps = tuple(path.stat().st_mtime_ns if path.is_file() else 0 for path in paths)
    axis = None if axis is None else (float(axis[0]), float(axis[1]), float(axis[2]))
    return _unbaked(paths, stamps, joint, group, scale, axis, skinning, joint_girth, segment_length)


@lru_cache(maxsize=8)
def _unbaked(
    paths: tuple[Path, ...],
    stamps: tuple[int, ...],
    joint: str,
    group: str | None,
    scale: float,
    axis: tuple[float, float, float] | None,
    skinning: str,
    joint_girth: float | None,
    segment_length: float | None,
) -> UnbakedLimb:
    _require_numbers(scale, skinning, joint_girth, segment_length)
    file, rig, weights = paths
    ordered, bones = read_ordered(file), read_rig(rig)
    hinge = hinge_of(bones, joint, ordered, rig=rig)
    frame = HingeFrame.of(hinge, axis)
    require_scale(frame.length, scale)
    share = read_weights(weights, bones, hinge.beyond, len(ordered.vertices))
    triangles = ordered.triangles(group, file=file)

    def cut(factor: float, length: float) -> tuple[SkinnedMesh, tuple[str, ...]]:
        return cut_limb(
            ordered, triangles, share, frame=frame, scale=factor, length=length, kind=skinning, file=file
        )  # fmt: skip

    own_length = LENGTH * frame.length * scale
    mesh, notes = cut(scale, own_length)
    sections, length, factor = sections_of(mesh, own_length), own_length, 1.0
    if joint_girth is not None:
        factor = joint_girth / float(2.0 * np.pi * sections.radius(np.zeros(1))[0])
        length = factor * own_length
    if segment_length is not None:
        length = segment_length
    longest = frame.length * scale * factor
    if length > longest:
        message = f"the segment is longer than its bone (got {length:g} mm), stay below {longest:.0f} mm"
        raise BadInput.of(message, key="body.segment_length")
    if (factor, length) != (1.0, own_length):
        mesh, notes = cut(scale * factor, length)
        sections = sections_of(mesh, length)
    return UnbakedLimb(mesh, sections, length, (*_facts(mesh, sections, length, factor), *notes))


def _require_numbers(scale: float, skinning: str, joint_girth: float | None, segment_length: float | None) -> None:
    """Raise BadInput for a scale, a girth or a length that is none, and for an unknown kind of skinning."""
    given = {"joint_girth": joint_girth, "segment_length": segment_length}
    require_positive(scale=scale, **{name: value for name, value in given.items() if value is not None})
    if skinning not in KINDS:
        require([(f"no such skinning (got {skinning!r}), known are {', '.join(KINDS)}", "skinning")])


def _facts(mesh: SkinnedMesh, sections: Sections, length: float, factor: float) -> tuple[str, ...]:
    """Return what is to be known of a limb."""
    ends = 2.0 * np.pi * sections.radius(np.array([-0.75 * length, 0.0, 0.75 * length]))
    where = f"{0.75 * length:.0f} mm above the joint, at it and below it"
    scaled = "" if factor == 1.0 else f", scaled by {factor:.4g} to the girth at the joint"
    deg = np.degrees(mesh.rest)
    return (
        f"limb of {len(mesh.faces)} triangles{scaled}: girths {', '.join(f'{end:.0f}' for end in ends)} mm {where}",
        f"its rest pose is bent by {deg:.3g} deg; weights fade over {fading_length(mesh):.0f} mm of skin",
    )


def fading_length(mesh: SkinnedMesh) -> float:
    """Return the length (mm) over which the weights of the straight limb go from the upper segment to the lower.

    One over the slope of a straight line through the shares of the vertices that both segments move.
    """
    both = (mesh.weight > LEAST_FADE) & (mesh.weight < MOST_FADE)
    x, share = mesh.bent(0.0)[both, 0], mesh.weight[both]
    spread = np.ptp(x) if both.any() else 0.0
    if spread <= 0.0:
        return 1.0
    slope = float(np.polyfit(x, share, 1)[0])
    return float(1.0 / slope) if slope * spread > 0.1 else float(spread)
