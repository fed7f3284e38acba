r"""Shear angle and shear force of a bias coupon from its force and displacement alone, free of the coupon's size.

Yarns that keep their length shear the middle of a coupon of length H and width W by gamma and two triangles at each
clamp by gamma / 2. With D = H - W the displacement d gives D + d = D (cos gamma/2 + sin gamma/2), and the power of the
force is that of the shear moment M per area of both zones (areas (2H - 3W) W / 2 and W^2):

    M(gamma) = [(H / W - 1) F (cos gamma/2 - sin gamma/2) - W M(gamma/2)] / (2H - 3W),    F_sh = M / cos gamma

(Cao et al., Composites Part A 39, 2008, 1037-1053). So coupons of several sizes of one fabric give one curve.
"""

from __future__ import annotations

import numpy as np

from etextile.types import Array


LEAST_RATIO = 1.5
"""Length over width of a coupon from which on its middle has an area."""


def shear_angle(displacement: Array, size: tuple[float, float]) -> Array:
    """Return the shear angle (n,) rad of the middle of a coupon at displacements (n,) mm; NaN beyond closing."""
    length, width = size
    ratio = (1.0 + np.asarray(displacement, dtype=np.float64) / (length - width)) / np.sqrt(2.0)
    closed = ratio > 1.0
    return np.where(closed, np.nan, 0.5 * np.pi - 2.0 * np.arccos(np.where(closed, 1.0, ratio)))


def normalised_shear_force(displacement: Array, force: Array, size: tuple[float, float]) -> tuple[Array, Array]:
    """Return shear angle (n,) rad and shear force per width (n,) N/mm at rising displacements (n,) mm and forces N.

    `size`: length and width of the coupon, mm. What is sheared half as much is taken from the curve itself, from its
    beginning on. Raises ValueError for a coupon shorter than 1.5 widths, whose middle is gone.
    """
    length, width = size
    if length <= LEAST_RATIO * width:
        raise ValueError(f"a coupon of {length:g} x {width:g} mm has no middle, 1.5 widths are needed")
    angle = shear_angle(displacement, size)
    half = 0.5 * angle
    lever = (length / width - 1.0) * np.asarray(force, dtype=np.float64) * (np.cos(half) - np.sin(half))
    known_angle, known_moment = [0.0], [0.0]
    moment = np.full(len(angle), np.nan)
    for i in np.flatnonzero(np.isfinite(angle) & (angle > 0.0)):
        before, end = known_angle[-1], known_moment[-1]
        if half[i] <= before:
            at_half = float(np.interp(half[i], known_angle, known_moment))
            moment[i] = (lever[i] - width * at_half) / (2.0 * length - 3.0 * width)
        else:  # between the last point and this one, whose moment is not known yet: on the line between the two
            share = (half[i] - before) / (angle[i] - before)
            moment[i] = (lever[i] - width * (1.0 - share) * end) / (2.0 * length - 3.0 * width + width * share)
        if angle[i] > before:
            known_angle.append(float(angle[i]))
            known_moment.append(float(moment[i]))
    return angle, moment / np.cos(angle)
