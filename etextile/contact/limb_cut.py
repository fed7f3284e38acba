"""A limb cut from a body mesh: laid into the frame of its hinge, ended by planes, weighted by two segments.

The hinge's axis y is the normal of the plane of the two bones (or is given), its sense that of more flexion; x halves
the bend of the rest pose, and z looks to the outer side. The bones give the flexion of the rest pose.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from etextile.contact.caps import capped
from etextile.contact.mesh import checked
from etextile.contact.mesh_file import welded
from etextile.contact.mesh_obj import OrderedMesh
from etextile.contact.rig import Hinge
from etextile.contact.skinning import SkinnedMesh
from etextile.errors import BadInput
from etextile.types import Array, IntArray


SHORTEST, LONGEST = 100.0, 700.0
"""Length of the shorter bone at a joint in mm outside of which the scale is doubted."""
UNITS = {"metres": 1000.0, "decimetres": 100.0, "centimetres": 10.0, "millimetres": 1.0, "inches": 25.4}
STRAIGHT_DEG = 3.0
"""Bend of the rest pose below which its bones do not tell the axis of the hinge."""
LENGTH = 0.7
"""Length of the segments over that of the shorter bone where none is given."""
SPANS = 0.3
"""Share of the length on either side of the hinge that a surface must reach to be the limb."""
MOST_TRIANGLES = 30_000
"""Triangles of a limb: a result page holds them at every step."""


@dataclass(frozen=True)
class HingeFrame:
    """Axes (3, 3) of a hinge as rows, its place (3,), flexion (rad) of the rest pose, directions (3,) of the bones.

    length: of the shorter bone, in the unit of the file.
    """

    axes: Array
    place: Array
    rest: float
    upper: Array
    lower: Array
    length: float

    @classmethod
    def of(cls, hinge: Hinge, axis: tuple[float, float, float] | None) -> HingeFrame:
        """Return the frame of a hinge; raises BadInput where bones have no length or do not tell the axis."""
        upper, lower = hinge.place - hinge.upper, hinge.lower - hinge.place
        lengths = np.linalg.norm([upper, lower], axis=1)
        if lengths.min() <= 0.0:
            message = "the bones at the joint have no length, choose another joint or mend the rig"
            raise BadInput.of(message, key="body.joint")
        upper, lower = upper / lengths[0], lower / lengths[1]
        about = np.cross(upper, lower) if axis is None else np.asarray(axis, dtype=float)
        _require_axis(about, upper, lower, given=axis is not None)
        y = about / np.linalg.norm(about)
        before, after = (_across(bone, y) for bone in (upper, lower))
        rest = float(np.arctan2(np.cross(before, after) @ y, before @ after))
        x = _across(before + after, y)
        return cls(np.stack([x, y, np.cross(x, y)]), hinge.place, rest, upper, lower, float(lengths.min()))


def require_scale(bone: float, scale: float) -> None:
    """Raise BadInput when a bone of this length in the unit of the file is no bone of a limb, with a likely scale."""
    if SHORTEST <= scale * bone <= LONGEST:
        return
    likely = [(unit, factor) for unit, factor in UNITS.items() if SHORTEST <= factor * bone <= LONGEST]
    advice = "set scale so that it becomes millimetres"
    if likely:
        advice = f"the file seems to be in {likely[0][0]}: set scale to {likely[0][1]:g}"
    message = (
        f"the shorter bone at the joint is {scale * bone:.4g} mm long with scale {scale:g}, expected {SHORTEST:g} to "
        f"{LONGEST:g} mm; {advice}"
    )
    raise BadInput.of(message, key="body.scale")


def _across(direction: Array, axis: Array) -> Array:
    """Return the unit vector along the part of a direction that is normal to an axis."""
    part = direction - (direction @ axis) * axis
    return np.asarray(part / np.linalg.norm(part))


def _require_axis(about: Array, upper: Array, lower: Array, *, given: bool) -> None:
    """Raise BadInput for an axis that the bones do not tell, or that is along one of them."""
    size = float(np.linalg.norm(about))
    bend = float(np.degrees(np.arctan2(np.linalg.norm(np.cross(upper, lower)), upper @ lower)))
    if not given and bend < STRAIGHT_DEG:
        message = (
            f"the rest pose is straight (bent by {bend:.2g} deg), so its bones do not tell about which axis the joint "
            "bends: give axis, in the coordinates of the mesh file (right-handed, [1, 0, 0] for knees that face +z)"
        )
        raise BadInput.of(message, key="body.axis")
    if given and not (size > 0.0 and max(abs(upper @ about), abs(lower @ about)) < 0.9 * size):
        message = "the axis must be a direction across the limb, not along a bone and not [0, 0, 0]"
        raise BadInput.of(message, key="body.axis")


def cut_limb(
    mesh: OrderedMesh, triangles: IntArray, weight: Array, *, frame: HingeFrame, scale: float, length: float,
    kind: str, file: Path,
) -> tuple[SkinnedMesh, tuple[str, ...]]:  # fmt: skip
    """Return the limb within `length` mm of its hinge, closed, with notes; raises BadInput for what is no limb.

    weight (v,): share of the lower segment by vertex of the file, nan where there is none; scale: mm per unit.
    """
    from trimesh.intersections import slice_faces_plane

    points = scale * (mesh.vertices - frame.place) @ frame.axes.T
    upper, lower = frame.axes @ frame.upper, frame.axes @ frame.lower
    carried = np.stack([np.nan_to_num(weight, nan=-1.0), np.isnan(weight).astype(float)], axis=1)
    for inward, start in ((upper, -length * upper), (-lower, length * lower)):
        points, triangles, carried = slice_faces_plane(points, triangles, inward, start, uv=carried)
        if not len(triangles):
            raise BadInput.of(_nowhere(length), file=str(file), key="body.joint")
    triangles = _around_hinge(points, triangles, length, mesh=mesh, file=file)
    bare = int(np.sum(carried[np.unique(triangles), 1] > 0.0))
    if bare:
        message = (
            f"{bare} vertices of the limb are moved by no bone: the weights are those of another mesh, or the limb is "
            "not the group that was weighted (see group)"
        )
        raise BadInput.of(message, file=str(file), key="body.weights")
    vertices, faces, _ = welded(points, np.asarray(triangles, dtype=np.int64))
    share = _nearest(points[np.unique(triangles)], carried[np.unique(triangles), 0], vertices)
    count = len(vertices)
    vertices, faces, caps = capped(vertices, faces, name=str(file))
    vertices, faces, notes = checked(vertices, faces, name=str(file), scale=scale)
    if len(faces) > MOST_TRIANGLES:
        message = (
            f"the limb has {len(faces)} triangles, more than {MOST_TRIANGLES}: simplify the mesh, weights included"
        )
        raise BadInput.of(message, file=str(file), key="body.file")
    share = np.concatenate([share, (vertices[count:, 0] > 0.0).astype(float)])
    return SkinnedMesh(vertices, faces, share, frame.rest, kind), (*caps, *notes)


def _nowhere(length: float) -> str:
    return (
        f"there is no surface within {length:.4g} mm of the joint; check group, and that rig and mesh are of one body"
    )


def _around_hinge(points: Array, triangles: IntArray, length: float, *, mesh: OrderedMesh, file: Path) -> IntArray:
    """Return the triangles of the one surface that reaches to both sides of the hinge around it."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    same = np.unique(np.round(points, 6), axis=0, return_inverse=True)[1].reshape(-1)
    ends = same[triangles]
    links = coo_array(
        (np.ones(2 * len(ends)), (ends[:, [0, 1]].ravel(), ends[:, [1, 2]].ravel())), shape=(len(points), len(points))
    )
    piece = connected_components(links, directed=False)[1][ends[:, 0]]
    found = []
    for number in np.unique(piece):
        own = points[triangles[piece == number]].reshape(-1, 3)
        low, high = own.min(axis=0), own.max(axis=0)
        spans = low[0] < -SPANS * length and high[0] > SPANS * length
        if spans and np.all(low[1:] < 0.0) and np.all(high[1:] > 0.0):
            found.append(number)
    if len(found) != 1:
        why = "no surface reaches" if not found else f"{len(found)} surfaces reach"
        message = f"{why} around the joint to both of its sides; name the skin with group, one of {mesh.listed}"
        raise BadInput.of(message, file=str(file), key="body.group")
    return np.asarray(triangles[piece == found[0]])


def _nearest(points: Array, values: Array, places: Array) -> Array:
    """Return the values (n,) of the points nearest to places (n, 3)."""
    from scipy.spatial import cKDTree

    return np.asarray(values[cKDTree(points).query(places)[1]])
