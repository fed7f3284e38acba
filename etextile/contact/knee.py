"""Knee: thigh and shank bent around broad condyles with a flat kneecap on top, the body of the knee load case.

Dimensions of an adult man, mm. G. Heinz, L. J. Peterson, R. W. Johnson, C. J. Kerk, "Exploring relationships in body
dimensions", J. Statistics Education 11(2), 2003, means of 247 men: breadth over the condyles 98, girth of the knee
372, of the calf 372, of the thigh below the buttock 565. Kneecap 44.8 wide, 34.4 high, 22.4 thick: F. Iranpour et al.,
Clin. Orthop. Relat. Res. 466, 2008, as tabulated in doi 10.1186/s42836-022-00117-8. Estimated, no source found: the
thigh's girth 180 above the joint (between that of knee and buttock), the skin over the kneecap, its height above the
condyles, the radii near the joint and of the tendons, the width of the blends. The kneecap of a bent knee faces about
half-way between the fronts of thigh and shank; here it does so exactly.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from etextile.contact.body import require, require_positive
from etextile.contact.implicit import Implicit, capped_cone, grown_ellipsoid, implicit_mesh, smooth_union
from etextile.contact.mesh import MeshBody, checked, mesh_body
from etextile.types import Array, IntArray


EDGE = 5.0
"""Edge length of the knee's triangles, mm."""

SKIN, PROTRUSION = 3.0, 13.0
"""Skin over the kneecap, and its height above the condyles, mm (estimated)."""

CONDYLE, TENDON = 40.0, 12.0
"""Radii of the front of the condyles and of the tendons above and below the kneecap, with skin, mm (estimated)."""


def knee_mesh(
    flexion: float = 90.0,
    *,
    breadth: float = 98.0,
    thigh_girth: float = 480.0,
    calf_girth: float = 372.0,
    patella_width: float = 44.8,
    patella_height: float = 34.4,
    patella_thickness: float = 22.4,
    leg_length: float = 180.0,
) -> tuple[Array, IntArray]:
    """Return vertices (v, 3) and outward triangles (f, 3) of a knee whose cap has its top in the origin, facing +z.

    flexion: deg, 0 for a straight leg; thigh (towards -x) and shank lie in the xz plane, equally far from the
    vertical, and end `leg_length` mm from the joint. Breadth over the condyles, girths (the thigh's where it ends) and
    the kneecap's dimensions in mm, its width along y. The parts are joined by a smooth union, meshed by surface nets
    and checked like a mesh of a user's. Raises BadInput.
    """
    require_positive(
        breadth=breadth,
        thigh_girth=thigh_girth,
        calf_girth=calf_girth,
        patella_width=patella_width,
        patella_height=patella_height,
        patella_thickness=patella_thickness,
        leg_length=leg_length,
    )
    patella = (patella_height, patella_width, patella_thickness)
    require(_misfits(flexion, breadth, patella, leg_length))
    return _knee_mesh(flexion, breadth, thigh_girth, calf_girth, patella, leg_length)


def knee(
    *,
    flexion: float = 90.0,
    breadth: float = 98.0,
    thigh_girth: float = 480.0,
    calf_girth: float = 372.0,
    patella_width: float = 44.8,
    patella_height: float = 34.4,
    patella_thickness: float = 22.4,
    leg_length: float = 180.0,
    grid_spacing: float | None = None,
) -> MeshBody:
    """Return the knee of `knee_mesh` as a body with a smooth distance grid."""
    vertices, faces = knee_mesh(
        flexion,
        breadth=breadth,
        thigh_girth=thigh_girth,
        calf_girth=calf_girth,
        patella_width=patella_width,
        patella_height=patella_height,
        patella_thickness=patella_thickness,
        leg_length=leg_length,
    )
    return mesh_body(vertices, faces, grid_spacing=grid_spacing)


def _misfits(
    flexion: float, breadth: float, patella: tuple[float, float, float], leg_length: float
) -> list[tuple[str, str]]:
    """Return (message, key) for dimensions that do not make a knee."""
    found = []
    if not 60.0 <= flexion <= 140.0:
        found.append((f"must lie between 60 and 140 deg (got {flexion:g})", "flexion"))
    if not 2 * CONDYLE < breadth <= 200.0:
        found.append((f"must lie between {2 * CONDYLE:g} and 200 mm (got {breadth:g})", "breadth"))
    for key, size in zip(("patella_height", "patella_width"), patella[:2], strict=True):
        if not patella[2] <= size <= breadth:
            found.append((f"must lie between the patella's thickness and the breadth (got {size:g})", key))
    if not 12.0 <= patella[2] <= 60.0:
        found.append((f"must lie between 12 and 60 mm (got {patella[2]:g})", "patella_thickness"))
    if not 130.0 <= leg_length <= 300.0:
        found.append((f"must lie between 130 and 300 mm (got {leg_length:g})", "leg_length"))
    return found


def knee_shape(
    flexion: float,
    breadth: float,
    thigh_girth: float,
    calf_girth: float,
    patella: tuple[float, float, float],
    leg_length: float,
) -> Implicit:
    """Return the knee as an implicit function: thigh, shank, condyles and tendons, then the kneecap."""
    half = np.radians(0.5 * (180.0 - flexion))
    up, down = np.array([-np.sin(half), 0, -np.cos(half)]), np.array([np.sin(half), 0, -np.cos(half)])
    thigh_front, shin_front = np.array([-np.cos(half), 0, np.sin(half)]), np.array([np.cos(half), 0, np.sin(half)])
    joint = np.array([0.0, 0.0, -(PROTRUSION + CONDYLE)])
    thigh, calf = thigh_girth / (2 * np.pi), calf_girth / (2 * np.pi)
    belly = joint + 110.0 * down - (calf - CONDYLE) * shin_front
    ankle = joint + leg_length * down - (0.8 * calf - CONDYLE) * shin_front
    side = np.array([0.0, 0.5 * breadth - CONDYLE, 0.0])
    shank = smooth_union([capped_cone(joint, belly, CONDYLE, calf), capped_cone(belly, ankle, calf, 0.8 * calf)], 6.0)
    condyles = capped_cone(joint - side, joint + side, CONDYLE, CONDYLE)
    fold = capped_cone(joint - np.array([0, 0, 25.0]), joint - np.array([0, 0, 56.0]), CONDYLE, CONDYLE)
    legs = smooth_union([capped_cone(joint, joint + leg_length * up, CONDYLE, thigh), shank, condyles, fold], 25.0)
    behind = np.array([0.0, 0.0, -(PROTRUSION + TENDON)])
    above = joint + 80.0 * up + (CONDYLE + 80.0 / leg_length * (thigh - CONDYLE) - TENDON) * thigh_front
    below = joint + 60.0 * down + (CONDYLE - TENDON) * shin_front
    tendons = [capped_cone(behind, above, TENDON, TENDON), capped_cone(behind, below, TENDON, TENDON)]
    semi_axes = (0.5 * patella[0], 0.5 * patella[1], 0.5 * patella[2])
    cap = grown_ellipsoid(np.array([0.0, 0.0, -(SKIN + semi_axes[2])]), semi_axes, SKIN)
    return smooth_union([smooth_union([legs, *tendons], 8.0), cap], 8.0)


@lru_cache(maxsize=8)
def _knee_mesh(
    flexion: float,
    breadth: float,
    thigh_girth: float,
    calf_girth: float,
    patella: tuple[float, float, float],
    leg_length: float,
) -> tuple[Array, IntArray]:
    shape = knee_shape(flexion, breadth, thigh_girth, calf_girth, patella, leg_length)
    widest = max(breadth / 2, thigh_girth / (2 * np.pi), calf_girth / (2 * np.pi)) + 15.0
    reach = leg_length + widest
    bounds = np.array([[-reach, -widest, -(reach + PROTRUSION + CONDYLE)], [reach, widest, 5.0]])
    vertices, faces = implicit_mesh(shape, bounds, edge=EDGE)
    vertices, faces, _ = checked(vertices, faces, name="knee")
    vertices.setflags(write=False)
    faces.setflags(write=False)
    return vertices, faces
