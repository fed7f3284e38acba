"""Elbow: upper arm and forearm bent around a hard, pointed olecranon, the body of the elbow load case.

Dimensions of an adult man, mm. G. Heinz, L. J. Peterson, R. W. Johnson, C. J. Kerk, "Exploring relationships in body
dimensions", J. Statistics Education 11(2), 2003, means of 247 men: breadth over the epicondyles 72, girth of the
forearm 282, of the wrist 172, of the flexed upper arm 344. Olecranon 23 wide (50 ulnae: "Redefining the proximal ulna
anatomy", Surg. Radiol. Anat., 2014, doi 10.1007/s00276-014-1340-4), tip reaching 15.8 beyond the joint surface (200
ulnae: T. Totlis et al., Surg. Radiol. Anat. 36, 2014). Estimated, no source found: the tip radius of 15 (half that
width and 3 of skin), the depth of the joint below the tip, the radii near the joint, the width of the blends.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from etextile.contact.body import require, require_positive
from etextile.contact.implicit import Implicit, capped_cone, implicit_mesh, smooth_union
from etextile.contact.mesh import MeshBody, checked, mesh_body
from etextile.types import Array, IntArray


EDGE = 4.0
"""Edge length of the elbow's triangles, mm."""

WRIST_GIRTH, WRIST_DISTANCE = 172.0, 250.0
"""Girth of the wrist and its distance from the joint, mm (the distance is estimated)."""


JOINT_DEPTH = 30.0
"""Depth of the joint's axis below the centre of the tip, mm (estimated)."""


def elbow_mesh(
    tip_radius: float = 15.0,
    flexion: float = 100.0,
    *,
    breadth: float = 72.0,
    upper_arm_girth: float = 344.0,
    forearm_girth: float = 282.0,
    arm_length: float = 140.0,
) -> tuple[Array, IntArray]:
    """Return vertices (v, 3) and outward triangles (f, 3) of an elbow whose tip is the origin and points along +z.

    flexion: deg, 0 for a straight arm; both arms lie in the xz plane, equally far from the vertical, the upper arm
    towards -x, and end `arm_length` mm from the joint. breadth: over the epicondyles, mm; girths: circumferences, mm.
    The parts are joined by a smooth union, meshed by surface nets and checked like a mesh of a user's. Raises BadInput.
    """
    require_positive(
        tip_radius=tip_radius,
        breadth=breadth,
        upper_arm_girth=upper_arm_girth,
        forearm_girth=forearm_girth,
        arm_length=arm_length,
    )
    require(_misfits(tip_radius, flexion, breadth, arm_length))
    return _elbow_mesh(tip_radius, flexion, breadth, upper_arm_girth, forearm_girth, arm_length)


def elbow(
    *,
    tip_radius: float = 15.0,
    flexion: float = 100.0,
    breadth: float = 72.0,
    upper_arm_girth: float = 344.0,
    forearm_girth: float = 282.0,
    arm_length: float = 140.0,
    grid_spacing: float | None = None,
) -> MeshBody:
    """Return the elbow of `elbow_mesh` as a body with a smooth distance grid."""
    vertices, faces = elbow_mesh(
        tip_radius,
        flexion,
        breadth=breadth,
        upper_arm_girth=upper_arm_girth,
        forearm_girth=forearm_girth,
        arm_length=arm_length,
    )
    return mesh_body(vertices, faces, grid_spacing=grid_spacing)


def _misfits(tip_radius: float, flexion: float, breadth: float, arm_length: float) -> list[tuple[str, str]]:
    """Return (message, key) for dimensions that do not make an elbow."""
    found = []
    if not 60.0 <= flexion <= 150.0:
        found.append((f"must lie between 60 and 150 deg (got {flexion:g})", "flexion"))
    if not 8.0 <= tip_radius <= 0.4 * breadth:
        found.append((f"must lie between 8 mm and 0.4 of the breadth (got {tip_radius:g})", "tip_radius"))
    if not 100.0 <= arm_length <= 250.0:
        found.append((f"must lie between 100 and 250 mm (got {arm_length:g})", "arm_length"))
    return found


def elbow_shape(
    tip_radius: float, flexion: float, breadth: float, upper_arm_girth: float, forearm_girth: float, arm_length: float
) -> Implicit:
    """Return the elbow as an implicit function: two limbs and the epicondyles, then the ulna with its tip."""
    half = np.radians(0.5 * (180.0 - flexion))
    upper, lower = np.array([-np.sin(half), 0, -np.cos(half)]), np.array([np.sin(half), 0, -np.cos(half)])
    joint = np.array([0.0, 0.0, -(tip_radius + JOINT_DEPTH)])
    near, condyle = JOINT_DEPTH - 2.0, 17.0
    biceps, widest = upper_arm_girth / (2 * np.pi), forearm_girth / (2 * np.pi)
    wrist = widest + (WRIST_GIRTH / (2 * np.pi) - widest) * (arm_length - 80.0) / (WRIST_DISTANCE - 80.0)
    side = np.array([0.0, 0.5 * breadth - condyle, 0.0])
    belly = capped_cone(joint, joint + 80.0 * lower, near, widest)
    taper = capped_cone(joint + 80.0 * lower, joint + arm_length * lower, widest, wrist)
    upper_arm = capped_cone(joint, joint + arm_length * upper, near, biceps)
    epicondyles = capped_cone(joint - side, joint + side, condyle, condyle)
    fold = capped_cone(joint - np.array([0, 0, 20.0]), joint - np.array([0, 0, 48.0]), near, near)
    limbs = smooth_union([upper_arm, smooth_union([belly, taper], 3.0), epicondyles, fold], 20.0)
    tip = np.array([0.0, 0.0, -tip_radius])
    ulna = capped_cone(tip, tip + 80.0 * lower, tip_radius, tip_radius)
    return smooth_union([limbs, ulna], 12.0)


@lru_cache(maxsize=8)
def _elbow_mesh(
    tip_radius: float, flexion: float, breadth: float, upper_arm_girth: float, forearm_girth: float, arm_length: float
) -> tuple[Array, IntArray]:
    shape = elbow_shape(tip_radius, flexion, breadth, upper_arm_girth, forearm_girth, arm_length)
    reach = arm_length + max(upper_arm_girth, forearm_girth) / (2 * np.pi) + 10.0
    depth = tip_radius + JOINT_DEPTH + reach
    width = max(0.5 * breadth, upper_arm_girth / (2 * np.pi), forearm_girth / (2 * np.pi)) + 10.0
    bounds = np.array([[-reach, -width, -depth], [reach, width, 5.0]])
    vertices, faces = implicit_mesh(shape, bounds, edge=EDGE)
    vertices, faces, _ = checked(vertices, faces, name="elbow")
    vertices.setflags(write=False)
    faces.setflags(write=False)
    return vertices, faces
