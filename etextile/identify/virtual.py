"""Virtual coupons: a rectangle of lattice between two clamps, pulled; its nominal curve, its zones and its centre.

A single truss stands for a whole coupon in the direct identification. The coupon itself knows more: diagonals take part
in warp and weft tension, clamps hold the width, and at an angle to the yarns three zones form: A at the clamps, where
both yarns through a point are held by a clamp, B where one is, C where none is (Beex et al., figure 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from etextile.lattice.cut import cut_piece
from etextile.lattice.piece import Lattice
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock
from etextile.solve.newton import Settings
from etextile.solve.path import advance
from etextile.types import Array, IntArray


Ends = Literal["clamped", "sliding", "width held"]
BIAS_COMPRESSION = (1.0, 1.0, 0.0)
"""Least compression ratios of warp, weft and diagonal in a bias coupon: yarns keep their length, as in a trellis.

Yarns that buckle (0) let the centre draw in by a quarter more than a trellis does. The case `bias_extension` says the
same.
"""
ZONES = "CBA"
"""Name of a zone by the number of yarn families that a clamp holds in it."""


@dataclass(frozen=True)
class Coupon:
    """A coupon between its clamps: size (length, width) mm, angle of the warp to the length in degrees, coarsening.

    `ends`: clamped; sliding across (no constraint by clamps); width held everywhere (the other extreme).
    """

    size: tuple[float, float]
    warp_angle: float = 0.0
    coarsening: float = 8.0
    ends: Ends = "clamped"


def coupon_model(weave: Weave, laws: Sequence[PowerLaw], coupon: Coupon, *, strain: Array) -> Model:
    """Return the model of a coupon pulled at x_max to rising nominal strains (n,); it stays in its plane.

    `laws`: of warp, weft and diagonal. Raises BadInput when the coarsening leaves no whole cell.
    """
    lattice = cut_piece(
        weave, coupon.size, coarsening=coupon.coarsening, warp_angle=coupon.warp_angle, held=("x_min", "x_max")
    )
    trusses = TrussBlock.between_nodes(
        "lattice", lattice.trusses, length=lattice.rest_length, area=lattice.area, family=lattice.family,
        laws=tuple(laws),
    )  # fmt: skip
    clamped = lattice.edges["x_min"] | lattice.edges["x_max"]
    fixed = np.zeros(lattice.points.shape, dtype=np.bool_)
    fixed[:, 2] = True
    fixed[clamped, 0] = True
    fixed[:, 1] = clamped if coupon.ends == "clamped" else coupon.ends == "width held"
    if coupon.ends == "sliding":
        fixed[[_middle(lattice, edge) for edge in ("x_min", "x_max")], 1] = True
    carried = np.zeros(lattice.points.shape)
    carried[lattice.edges["x_max"], 0] = 1.0
    travel = np.asarray(strain, dtype=np.float64) * coupon.size[0]
    return Model(lattice, lattice.points, fixed, carried, (trusses,), travel, np.array([1.0, 0.0, 0.0]))


def _middle(lattice: Lattice, edge: str) -> int:
    """Return the node in the middle of an edge along x."""
    nodes = np.flatnonzero(lattice.edges[edge])
    return int(nodes[np.argmin(np.abs(lattice.points[nodes, 1]))])


def coupon_stress(
    weave: Weave,
    laws: Sequence[PowerLaw],
    coupon: Coupon,
    *,
    strain: Array,
    settings: Settings | None = None,
    increments: int | None = None,
) -> Array:
    """Return the fabric engineering stress (n,), MPa, of a coupon at rising nominal strains (n,).

    `increments`: at how many strains the coupon is computed (closer at first, where curves bend), with a monotone
    interpolation between; none: at every strain asked for. Raises NoEquilibrium when the path cannot go on.
    """
    from scipy.interpolate import PchipInterpolator

    nodes = strain if increments is None else float(strain[-1]) * (np.arange(1, increments + 1) / increments) ** 1.5
    model = coupon_model(weave, laws, coupon, strain=nodes)
    force = [item.punch_force_N for item in advance(model, settings) if item.output]
    stress = np.array(force) / (coupon.size[1] * weave.thickness)
    if increments is None:
        return stress
    return np.asarray(PchipInterpolator(np.append(0.0, nodes), np.append(0.0, stress))(strain))


def in_bias(laws: Sequence[PowerLaw]) -> tuple[PowerLaw, ...]:
    """Return the laws with the compression ratios of a bias coupon, where their own are not larger."""
    return tuple(
        replace(law, compression_ratio=max(law.compression_ratio, least))
        for law, least in zip(laws, BIAS_COMPRESSION, strict=True)
    )


@dataclass(frozen=True)
class CellMotion:
    """Average motion of lattice cells (q,): engineering strains of warp and weft, shear angle (rad) between them, and
    strains of material lines along and across the coupon.

    The shear angle is positive when the cell gets longer along x.
    """

    warp: Array
    weft: Array
    shear: Array
    along: Array
    across: Array


def cell_motion(lattice: Lattice, positions: Array) -> CellMotion:
    """Return the motion of all whole cells at node positions (n, 3)."""
    before, now = _sides(lattice.points, lattice.quads), _sides(positions, lattice.quads)
    length = np.linalg.norm(now, axis=2)
    strain = length / np.linalg.norm(before, axis=2) - 1.0
    cosine = np.einsum("qc,qc->q", now[:, 0], now[:, 1]) / (length[:, 0] * length[:, 1])
    opening = np.arccos(np.clip(cosine, -1.0, 1.0)) - 0.5 * np.pi
    sense = -1.0 if np.sin(2.0 * np.radians(lattice.warp_angle)) < -1e-12 else 1.0
    gradient = np.linalg.solve(before[:, :, :2], now)
    along, across = (np.linalg.norm(gradient[:, axis], axis=1) - 1.0 for axis in (0, 1))
    return CellMotion(strain[:, 0], strain[:, 1], sense * opening, along, across)


def _sides(points: Array, quads: IntArray) -> Array:
    """Return the mean sides (q, 2, 3) of cells along warp and weft."""
    a, b, c, d = (points[quads[:, k]] for k in range(4))
    return np.stack([0.5 * (b - a + c - d), 0.5 * (d - a + c - b)], axis=1)


def zone_of_cells(lattice: Lattice, size: tuple[float, float]) -> IntArray:
    """Return for each whole cell (q,) how many yarns through its centre a clamp holds: 2 in A, 1 in B, 0 in C."""
    centre = lattice.points[lattice.quads, :2].mean(axis=1)
    held = np.zeros(len(centre), dtype=np.int64)
    for angle in np.radians([lattice.warp_angle, lattice.warp_angle + 90.0]):
        c, s = np.cos(angle), np.sin(angle)
        if abs(c) > 1e-12:
            ends = centre[:, 1:] + s / c * (0.5 * size[0] * np.array([-1.0, 1.0]) - centre[:, :1])
            held += np.any(np.abs(ends) <= 0.5 * size[1], axis=1)
    return held


def at_centre(lattice: Lattice, size: tuple[float, float]) -> IntArray:
    """Return the whole cells about the centre of the coupon, within a sixth of its width (at least the nearest)."""
    distance = np.linalg.norm(lattice.points[lattice.quads, :2].mean(axis=1), axis=1)
    return np.flatnonzero(distance <= max(size[1] / 6.0, 1.001 * float(distance.min())))


def trellis_angle(strain: Array) -> Array:
    """Return the shear angle (rad) of a trellis of stiff yarns at 45 degrees, stretched by `strain` along a diagonal.

    gamma = pi / 2 - 2 acos((1 + e) / sqrt 2); NaN beyond the strain sqrt 2 - 1 at which it is closed.
    """
    ratio = (1.0 + np.asarray(strain, dtype=np.float64)) / np.sqrt(2.0)
    closed = ratio > 1.0
    return np.where(closed, np.nan, 0.5 * np.pi - 2.0 * np.arccos(np.where(closed, 1.0, ratio)))


def ideal_centre_strain(strain: Array, size: tuple[float, float]) -> Array:
    """Return the strain (n,) of zone C in a bias coupon whose fabric resists no shear: L e / (L - W) at nominal e."""
    length, width = size
    return np.asarray(strain, dtype=np.float64) * length / (length - width)
