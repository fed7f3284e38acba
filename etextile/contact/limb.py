"""A limb that bends: two round cones that meet at a hinge, and a hard tip (olecranon, patella), at any flexion.

The hinge lies on the axis of both segments, along y; straight, the limb lies along x and its outer side looks to +z.
Both segments end in the same sphere at the joint, so the outer side is exactly r theta long at the hinge (r: radius of
the joint) and the distance is exact outside but for two blends: of the segments in the crook, whose width grows from
nothing at the sphere, and of the tip. A segment's distance is that of a round cone (the hull of two balls); turned by
an angle it changes at a fixed place x by -n . (omega x x), n its normal.

Blend of distances a, b over a width k, |a - b| < k: (a + b) / 2 - k / 4 - (a - b)^2 / (4 k), else the smaller. In the
crook k = K tanh(e / K), e the distance to the joint's sphere less the mean of a and b.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from etextile.contact.bending import Bending, about_y
from etextile.contact.body import Distance, evaluation_points
from etextile.types import Array, IntArray


SKIN_LENGTH = 200.0
"""Length of the skin that stretches over a joint, mm."""


@dataclass(frozen=True)
class DistanceField:
    """A distance of n points with its derivatives: gap, gradient, Hessian as in `Distance`, rate (n,) by the angle."""

    gap: Array
    normal: Array
    hessian: Array
    rate: Array


@dataclass(frozen=True)
class Limb(Bending):
    """Dimensions of a limb, mm, and its pose.

    joint_radius: of the limb at the hinge; upper and lower: (radius at the far end, length from the hinge); tip:
    (radius, distance of its centre from the axis, distance along the lower segment) or None; crook: K; tip_blend: width
    of the blend of the tip; lower_share: share of the flexion that the lower segment turns, the upper turns the rest;
    tip_share: 1 where the tip belongs to the lower segment, 0 to the upper; flexion: rad; deflated: how far inside of
    its surface the limb stands while a tight sleeve is put on, mm; skin_length: of the skin that stretches, mm.
    """

    joint_radius: float
    upper: tuple[float, float]
    lower: tuple[float, float]
    tip: tuple[float, float, float] | None = None
    crook: float = 20.0
    tip_blend: float = 8.0
    lower_share: float = 0.5
    tip_share: float = 1.0
    flexion: float = 0.0
    deflated: float = 0.0
    skin_length: float = SKIN_LENGTH

    @property
    def middle(self) -> Array:
        """Return the axis of the limb."""
        return np.zeros(2)

    def posed(self, *, flexion: float, deflated: float) -> Self:
        """Return the limb bent by `flexion` (rad), standing `deflated` mm inside of its own surface."""
        return replace(self, flexion=flexion, deflated=deflated)

    @property
    def angles(self) -> tuple[float, float]:
        """Angles (rad) by which upper and lower segment are turned about y."""
        return -(1.0 - self.lower_share) * self.flexion, self.lower_share * self.flexion

    def distance(self, points: Array) -> Distance:
        """Return the signed distance of `points` (n, 3)."""
        found = self.field(points)
        return Distance(found.gap, found.normal, found.hessian)

    def rate(self, points: Array) -> Array:
        """Return the derivative (n,) of the signed distance of fixed points by the flexion, mm per rad."""
        return self.field(points).rate

    def field(self, points: Array) -> DistanceField:
        """Return distance and derivatives of `points` (n, 3)."""
        points = evaluation_points(points)
        turned_upper, turned_lower = self.angles
        upper = _turned(_cone, points, turned_upper, self.lower_share - 1.0, (-1.0, self.joint_radius, *self.upper))
        lower = _turned(_cone, points, turned_lower, self.lower_share, (1.0, self.joint_radius, *self.lower))
        joint = _ball(points, np.zeros(3), self.joint_radius)
        found = _crook(upper, lower, DistanceField(*joint, np.zeros(len(points))), self.crook)
        if self.tip is not None:
            share = self.tip_share * self.lower_share + (1.0 - self.tip_share) * (self.lower_share - 1.0)
            tip = _turned(_tip, points, share * self.flexion, share, self.tip)
            found = _blend(found, tip, self.tip_blend)
        return DistanceField(found.gap + self.deflated, found.normal, found.hessian, found.rate)

    def radius(self, along: Array) -> Array:
        """Return the radius (n,) mm of the straight limb without its tip at places `along` (n,) x, mm."""
        along = np.asarray(along, dtype=float)
        found = np.full(along.shape, 0.0)
        for sign, (far, length) in ((-1.0, self.upper), (1.0, self.lower)):
            sine = (self.joint_radius - far) / length
            cosine = float(np.sqrt(1.0 - sine**2))
            cone = (self.joint_radius - sine * sign * along) / cosine
            ball = np.sqrt(np.maximum(self.joint_radius**2 - along**2, 0.0))
            own = np.where(sign * along < self.joint_radius * sine, ball, cone)
            found = np.maximum(found, np.where(sign * along >= 0.0, own, 0.0))
        return found

    def fitted(self, places: Array) -> Array:
        """Return nodes (n, 3) of a round piece moved outwards to the skin where it is tight."""
        factor = np.maximum(self.radius(places[:, 0]) / np.hypot(places[:, 1], places[:, 2]), 1.0)
        return np.asarray(places * np.stack([np.ones(len(places)), factor, factor], axis=1))

    def bounds(self) -> Array:
        """Return the lower and upper corner (2, 3) of a box around the limb."""
        reach = max(far + length for far, length in (self.upper, self.lower))
        wide = max(self.joint_radius, self.upper[0], self.lower[0])
        high = wide if self.tip is None else max(wide, self.tip[1] + self.tip[0])
        low = np.array([-reach, -wide, -max(reach, wide)])
        return np.stack([low, np.array([reach, wide, high])])

    def support(self, direction: Array) -> float:
        """Return the maximum of x . direction over the limb (the blends left out)."""
        centres, radii = self._balls()
        return float((centres @ direction + radii * np.linalg.norm(direction)).max())

    def _balls(self) -> tuple[Array, Array]:
        """Return centres (b, 3) and radii (b,) of the balls whose hull the segments and the tip are."""
        up, low = (about_y(angle) for angle in self.angles)
        centres = [np.zeros(3), up @ [-self.upper[1], 0.0, 0.0], low @ [self.lower[1], 0.0, 0.0]]
        radii = [self.joint_radius, self.upper[0], self.lower[0]]
        if self.tip is not None:
            share = self.tip_share * self.lower_share + (1.0 - self.tip_share) * (self.lower_share - 1.0)
            centres.append(about_y(share * self.flexion) @ [self.tip[2], 0.0, self.tip[1]])
            radii.append(self.tip[0])
        return np.array(centres), np.array(radii) - self.deflated

    def surface(self, *, edge: float = 4.0) -> tuple[Array, IntArray]:
        """Return vertices (v, 3) and triangles (f, 3) of sides of about `edge` mm, wound outward, for drawing."""
        from etextile.contact.implicit import implicit_mesh

        centres, radii = self._balls()
        reach = radii.max() + 4.0
        box = np.stack([(centres - reach).min(axis=0), (centres + reach).max(axis=0)])
        return implicit_mesh(lambda points: self.distance(points).gap, box, edge=edge)


Shape = Callable[..., tuple[Array, Array, Array]]


def _turned(shape: Shape, points: Array, angle: float, share: float, sizes: tuple[float, ...]) -> DistanceField:
    """Return a shape turned about y by `angle` (rad), which grows by `share` per rad of flexion."""
    turn = about_y(angle)
    gap, normal, hessian = shape(points @ turn, *sizes)
    normal = normal @ turn.T
    rate = -share * (normal[:, 0] * points[:, 2] - normal[:, 2] * points[:, 0])
    return DistanceField(gap, normal, turn @ hessian @ turn.T, rate)


def _ball(points: Array, centre: Array, radius: float) -> tuple[Array, Array, Array]:
    """Return distance, normal and Hessian of a ball."""
    away = points - centre
    size = np.maximum(np.linalg.norm(away, axis=1), 1e-9)
    normal = away / size[:, None]
    hessian = (np.eye(3) - normal[:, :, None] * normal[:, None, :]) / size[:, None, None]
    return size - radius, normal, hessian


def _tip(points: Array, radius: float, height: float, along: float) -> tuple[Array, Array, Array]:
    """Return distance, normal and Hessian of the tip."""
    return _ball(points, np.array([along, 0.0, height]), radius)


def _cone(points: Array, sign: float, near: float, far: float, length: float) -> tuple[Array, Array, Array]:
    """Return distance, normal and Hessian of a round cone from the origin along sign x."""
    sine = (near - far) / length
    cosine = float(np.sqrt(1.0 - sine**2))
    axis = np.array([sign, 0.0, 0.0])
    along = points @ axis
    away = points - along[:, None] * axis
    off = np.maximum(np.linalg.norm(away, axis=1), 1e-9)
    radial = away / off[:, None]
    gap = cosine * off + sine * along - near
    normal = cosine * radial + sine * axis
    round_about = np.eye(3) - axis[:, None] * axis[None, :] - radial[:, :, None] * radial[:, None, :]
    hessian = cosine / off[:, None, None] * round_about
    place = cosine * along - sine * off
    for where, centre, radius in ((place < 0.0, np.zeros(3), near), (place > cosine * length, length * axis, far)):
        for whole, part in zip((gap, normal, hessian), _ball(points[where], centre, radius), strict=True):
            whole[where] = part
    return gap, normal, hessian


def _smaller(first: DistanceField, second: DistanceField) -> DistanceField:
    """Return the smaller of two distances."""
    takes = first.gap <= second.gap
    return DistanceField(
        *(
            np.where(takes.reshape(-1, *[1] * (one.ndim - 1)), one, other)
            for one, other in (
                (getattr(first, name), getattr(second, name)) for name in DistanceField.__dataclass_fields__
            )
        )
    )


def _blend(first: DistanceField, second: DistanceField, width: float) -> DistanceField:
    """Return the smooth smaller of two distances, blended over a fixed width."""
    return _compose(first, second, np.full(len(first.gap), width), None)


def _crook(upper: DistanceField, lower: DistanceField, joint: DistanceField, width: float) -> DistanceField:
    """Return the segments joined: their smaller distance outside, blended where both are nearer than the joint."""
    depth = joint.gap - 0.5 * (upper.gap + lower.gap)
    share = np.tanh(np.maximum(depth, 0.0) / width)
    return _compose(upper, lower, width * share, (joint, 1.0 - share**2, -2.0 * share * (1.0 - share**2) / width))


def _compose(
    first: DistanceField, second: DistanceField, width: Array, joint: tuple[DistanceField, Array, Array] | None
) -> DistanceField:
    """Return the blend of two distances over `width` (n,), which follows e of the joint with two derivatives."""
    smaller = _smaller(first, second)
    apart = first.gap - second.gap
    which = np.flatnonzero(np.abs(apart) < width)
    if not len(which):
        return smaller
    a, b = _some(first, which), _some(second, which)
    k, d = width[which], apart[which]
    mean = _combined(a, b, 0.5, 0.5)
    apart_field = _combined(a, b, 1.0, -1.0)
    gap = mean.gap - 0.25 * k - d**2 / (4.0 * k)
    gradients = [(mean, np.ones_like(k)), (apart_field, -d / (2.0 * k))]
    seconds = [(apart_field, apart_field, -1.0 / (2.0 * k))]
    if joint is not None:
        depth = _combined(_some(joint[0], which), mean, 1.0, -1.0)
        slope, bend = joint[1][which], joint[2][which]
        by_k, by_kk = -0.25 + d**2 / (4.0 * k**2), -(d**2) / (2.0 * k**3)
        gradients.append((depth, by_k * slope))
        seconds.append((depth, depth, by_kk * slope**2 + by_k * bend))
        seconds += [(apart_field, depth, d / (2.0 * k**2) * slope), (depth, apart_field, d / (2.0 * k**2) * slope)]
    normal, hessian, rate = np.zeros_like(mean.normal), np.zeros_like(mean.hessian), np.zeros_like(gap)
    for field, factor in gradients:
        normal += factor[:, None] * field.normal
        hessian += factor[:, None, None] * field.hessian
        rate += factor * field.rate
    for one, other, factor in seconds:
        hessian += factor[:, None, None] * one.normal[:, :, None] * other.normal[:, None, :]
    for name, values in (("gap", gap), ("normal", normal), ("hessian", hessian), ("rate", rate)):
        getattr(smaller, name)[which] = values
    return smaller


def _some(field: DistanceField, which: IntArray) -> DistanceField:
    return DistanceField(*(getattr(field, name)[which] for name in DistanceField.__dataclass_fields__))


def _combined(first: DistanceField, second: DistanceField, a: float, b: float) -> DistanceField:
    """Return a first + b second, derivative by derivative."""
    return DistanceField(
        *(a * getattr(first, name) + b * getattr(second, name) for name in DistanceField.__dataclass_fields__)
    )
