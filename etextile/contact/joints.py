"""The joints that a limb may bend at, with the dimensions of an adult man: what `body.joint` accepts.

Girths and lengths are those of the bent bodies `etextile.contact.elbow` and `etextile.contact.knee`, where their
sources stand. Estimated, no source found: the girth of the straight elbow (a circle between the breadth over the
epicondyles and the depth there), and how far the tips stand out over the joint.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, radians, sin

from etextile.contact.body import require, require_positive
from etextile.contact.limb import SKIN_LENGTH, Limb
from etextile.registry import Registry


@dataclass(frozen=True)
class Joint:
    """Dimensions of a joint, mm: girths at the hinge and where the segments end, their length; the tip and its place.

    tip_angle: deg, by which the tip lies towards the upper segment when the limb is straight; tip_share: share of the
    flexion of the lower segment that it goes along with.
    """

    joint_girth: float
    upper_girth: float
    lower_girth: float
    segment_length: float
    tip_radius: float
    tip_height: float
    tip_angle: float
    tip_share: float


JOINTS: Registry[Joint] = Registry("joint")
"""Joints by name."""

JOINTS.register("elbow", Joint(251.0, 344.0, 282.0, 160.0, 15.0, 3.0, 60.0, 1.0))
JOINTS.register("knee", Joint(372.0, 480.0, 372.0, 200.0, 24.0, 4.0, 0.0, 0.5))


def limb(
    joint: str,
    *,
    joint_girth: float | None = None,
    upper_girth: float | None = None,
    lower_girth: float | None = None,
    segment_length: float | None = None,
    tip_radius: float | None = None,
    tip_height: float | None = None,
    skin_length: float = SKIN_LENGTH,
) -> Limb:
    """Return the straight limb of a joint; dimensions (mm) that are None are those of the joint.

    tip_height: how far the tip stands out over the joint, none for 0. The tip of the elbow (olecranon) belongs to the
    forearm: on a straight arm it lies in its groove, at 120 deg it is the foremost point. The kneecap turns half as
    far. Raises BadInput.
    """
    own = JOINTS[joint]
    girths = tuple(
        default if given is None else given
        for given, default in (
            (joint_girth, own.joint_girth), (upper_girth, own.upper_girth), (lower_girth, own.lower_girth)
        )
    )  # fmt: skip
    length = own.segment_length if segment_length is None else segment_length
    radius = own.tip_radius if tip_radius is None else tip_radius
    height = own.tip_height if tip_height is None else tip_height
    require_positive(
        joint_girth=girths[0],
        upper_girth=girths[1],
        lower_girth=girths[2],
        segment_length=length,
        skin_length=skin_length,
    )
    hinge, upper, lower = (girth / (2.0 * pi) for girth in girths)
    require(_misfits((hinge, upper, lower), length, radius, height))
    reach, angle = hinge + height - radius, radians(own.tip_angle)
    tip = None if height == 0.0 else (radius, reach * cos(angle), -reach * sin(angle))
    return Limb(hinge, (upper, length), (lower, length), tip=tip, tip_share=own.tip_share, skin_length=skin_length)


def _misfits(radii: tuple[float, float, float], length: float, tip: float, height: float) -> list[tuple[str, str]]:
    """Return (message, key) for dimensions that do not make a limb."""
    hinge, *far = radii
    found = []
    for name, radius in zip(("upper_girth", "lower_girth"), far, strict=True):
        if abs(radius - hinge) > 0.5 * length:
            found.append((f"the segment widens or tapers too much (got {2 * pi * radius:g} mm)", name))
    if length < 2.0 * hinge:
        found.append((f"must be at least the joint's breadth, {2 * hinge:.0f} mm (got {length:g})", "segment_length"))
    if height < 0.0 or height > 0.3 * hinge:
        found.append((f"must lie between 0 and 0.3 of the joint's radius (got {height:g} mm)", "tip_height"))
    if not 5.0 <= tip <= hinge:
        found.append((f"must lie between 5 mm and the joint's radius (got {tip:g} mm)", "tip_radius"))
    return found
