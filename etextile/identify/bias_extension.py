r"""The shear law of a fabric from bias coupons alone: fitted to coupons of one size it foretells those of any other.

Yarns keep their length, so displacement gives the shear angle gamma of the middle (`shear_force`), and the force is
linear in the shear moment M per area,

    F = [(2H - 3W) M(gamma) + W M(gamma / 2)] / [(H/W - 1) (cos gamma/2 - sin gamma/2)].

M is taken piecewise linear and never falling: its rises from knot to knot, none below zero, are found by least squares
on the forces themselves. So an initial friction, a flat part and locking each have room, and no derivative of a record
is taken. The lattice's diagonals get the power law that comes nearest: in a trellis of sides a, b a diagonal of length
d^2 = a^2 + b^2 + 2 a b sin(gamma) and tension N gives M = N cos(gamma) / d.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from etextile.identify.coupon import loading_curve
from etextile.identify.shear_force import LEAST_RATIO, shear_angle
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


KNOTS = np.radians(
    [0.0, 1.0, 2.0, 4.0, 7.0, 10.0, 13.5, 17.0, 21.0, 25.0, 29.0, 33.0, 37.0, 41.0, 45.0, 50.0, 56.0, 63.0, 75.0]
)
"""Angles, rad, between which M is a straight line."""
STIFF = 200.0
"""Modulus of the diagonals over the steepest slope of their law: what they give elastically is next to nothing."""
NEAR = 1e-3
"""Strain of yarns that count as inextensible under the largest stress of a coupon."""


@dataclass(frozen=True)
class BiasCoupon:
    """One coupon: displacement (n,) mm and force (n,) N of its loading; length between the clamps and width, mm."""

    name: str
    displacement: Array
    force: Array
    size: tuple[float, float]

    def __post_init__(self) -> None:
        length, width = self.size
        if length < LEAST_RATIO * width:
            raise ValueError(f"a coupon of {length:g} x {width:g} mm has no middle, 1.5 widths are needed")


@dataclass(frozen=True)
class ShearLaw:
    """Shear moment per area M (k,) N/mm at shear angles (k,) rad, straight between and beyond."""

    angle: Array
    moment: Array

    def at(self, angle: Array) -> Array:
        """Return M (n,) N/mm at angles (n,) rad."""
        return _hats(self.angle, angle) @ self.moment

    def force(self, displacement: Array, size: tuple[float, float]) -> Array:
        """Return the force (n,) N of a coupon of length and width (mm) at displacements (n,) mm; NaN once closed."""
        return _levers(self.angle, displacement, size) @ self.moment

    def shear_force(self, angle: Array) -> Array:
        """Return the normalised shear force per width (n,) N/mm at angles (n,) rad."""
        return np.asarray(self.at(angle) / np.cos(angle))


@dataclass(frozen=True)
class ForetoldCoupon:
    """How a law fitted to other sizes foretells a coupon: mean absolute and largest difference over its peak force."""

    name: str
    mean: float
    largest: float
    beyond: bool


def _hats(knots: Array, angle: Array) -> Array:
    """Return the weights (n, k) of the values at the knots; beyond the last one the last line goes on."""
    angle = np.asarray(angle, dtype=np.float64)
    right = np.clip(np.searchsorted(knots, angle), 1, len(knots) - 1)
    share = (angle - knots[right - 1]) / (knots[right] - knots[right - 1])
    found = np.zeros((len(angle), len(knots)))
    found[np.arange(len(angle)), right - 1] = 1.0 - share
    found[np.arange(len(angle)), right] = share
    return found


def _levers(knots: Array, displacement: Array, size: tuple[float, float]) -> Array:
    """Return the force (n, k) that a unit moment at each knot gives a coupon."""
    length, width = size
    angle = shear_angle(displacement, size)
    half = 0.5 * angle
    lever = (length / width - 1.0) * (np.cos(half) - np.sin(half))
    known = np.nan_to_num(angle)
    both = (2.0 * length - 3.0 * width) * _hats(knots, known) + width * _hats(knots, 0.5 * known)
    return np.asarray(both / lever[:, None])


def fit_law(coupons: Sequence[BiasCoupon]) -> ShearLaw:
    """Return the law that comes nearest to the forces of all coupons, each relative to its peak and length of record.

    Raises ValueError where no coupon is sheared by as much as a degree.
    """
    from scipy.optimize import nnls

    reach = max(float(np.nanmax(shear_angle(item.displacement, item.size))) for item in coupons)
    if not reach > KNOTS[1]:
        raise ValueError(f"the coupons are sheared by {np.degrees(reach):.2g} degrees only")
    inner = KNOTS[0.97 * reach > KNOTS]
    knots = np.append(inner, reach)
    rises = np.tril(np.ones((len(knots), len(knots))))[:, 1:]
    rows, values = [], []
    for item in coupons:
        seen = np.isfinite(shear_angle(item.displacement, item.size)) & (item.displacement >= 0.0)
        scale = float(np.abs(item.force[seen]).max()) * np.sqrt(seen.sum())
        rows.append(_levers(knots, item.displacement[seen], item.size) @ rises / scale)
        values.append(item.force[seen] / scale)
    found, _ = nnls(np.concatenate(rows), np.concatenate(values))
    return ShearLaw(knots, rises @ found)


def foretold(coupons: Sequence[BiasCoupon]) -> tuple[ForetoldCoupon, ...]:
    """Return how coupons of every size are foretold by a law fitted to all other sizes; none with a single size."""
    sizes = {item.size for item in coupons}
    found = []
    for item in coupons if len(sizes) > 1 else ():
        law = fit_law([other for other in coupons if other.size != item.size])
        found.append(_foretold(law, item))
    return tuple(found)


def _foretold(law: ShearLaw, item: BiasCoupon) -> ForetoldCoupon:
    angle = shear_angle(item.displacement, item.size)
    seen = np.isfinite(angle) & (item.displacement >= 0.0)
    left = np.abs(law.force(item.displacement[seen], item.size) - item.force[seen])
    peak = float(np.abs(item.force[seen]).max())
    return ForetoldCoupon(
        item.name, float(left.mean()) / peak, float(left.max()) / peak, bool(angle[seen].max() > 1.02 * law.angle[-1])
    )


def diagonal_law(law: ShearLaw, weave: Weave, start: PowerLaw) -> tuple[PowerLaw, float]:
    """Return the power law of tension-only diagonals nearest to a shear law, and what it misses over the largest M.

    H and n are found by least squares on M over the angles of the law; E is so high that all of it is hardening.
    """
    from scipy.optimize import least_squares

    angle = np.linspace(0.02, 1.0, 60) * law.angle[-1]
    moment = law.at(angle)
    a, b = weave.cell_warp, weave.cell_weft
    rest = np.hypot(a, b)
    length = np.sqrt(rest**2 + 2.0 * a * b * np.sin(angle))
    strain = np.log(length / rest)

    def of(y: Array) -> tuple[PowerLaw, Array]:
        h, n = float(np.exp(y[0])), float(np.exp(y[1]))
        steep = h * max(n, 1.0) * float(strain[-1]) ** (n - 1.0)
        found = replace(start, E=STIFF * steep, sigma_y0=0.0, H=h, n=n)
        tension = loading_curve(found, strain).stress * weave.truss_area
        return found, np.asarray(tension * np.cos(angle) / length)

    size = float(moment[-1]) * length[-1] / (np.cos(angle[-1]) * weave.truss_area)
    y, wide = np.array([np.log(size / strain[-1] ** 1.5), np.log(1.5)]), np.array([12.0, 1.6])
    best = least_squares(lambda y: (of(y)[1] - moment) / moment.max(), y, bounds=(y - wide, y + wide)).x
    found, nearest = of(best)
    return found, float(np.sqrt(np.mean((nearest - moment) ** 2)) / moment.max())


def inextensible(coupons: Sequence[BiasCoupon], thickness: float, start: PowerLaw, area_ratio: float) -> PowerLaw:
    """Return a yarn law that strains by no more than `NEAR` under the largest stress of the coupons.

    `area_ratio`: truss stress over fabric stress.
    """
    largest = max(float(item.force.max()) / (item.size[1] * thickness) for item in coupons) * area_ratio
    modulus = largest / NEAR
    return replace(start, E=modulus, sigma_y0=modulus, H=modulus, n=1.0)
