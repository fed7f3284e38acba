"""What part of the coupon's warp stiffness belongs to the wires, so that it is not counted twice.

The coupons behind the fabric sets contained the wires. At engineering strain e a coupon of width b carries b / spacing
wires; the woven-in part of a wire is stretched to (1 + e) / (1 + crimp), a loop to (1 + e) / (1 + slack), each weighted
by its length. The warp law is fitted anew (H and n, least squares over the identified strains) to the measured curve
less that, so that a coupon with wires returns the measured curve.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from etextile.errors import BadInput
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


_MOST_STEPS, _ENOUGH = 60, 1e-9
"""Gauss-Newton steps at most, and the step in (ln H, n) that ends them."""
RELATIVE_FROM = 0.05
"""Misfit counts relative to the measured stress, below this share of the peak more and more absolutely."""


@dataclass(frozen=True)
class WireShare:
    """Warp law without the wires; their share of the force at the end of the range and at most; misfit of the curve.

    `misfit` is the largest difference between coupon with wires and measured curve, as a share of its peak;
    `relative_misfit` the largest share of the measured stress itself, from 1 % strain on.
    """

    law: PowerLaw
    at_end: float
    largest: float
    misfit: float
    relative_misfit: float


def wire_stress(
    strain: Array,
    law: PowerLaw,
    *,
    area_mm2: float,
    spacing_mm: float,
    thickness_mm: float,
    crimp: float,
    slack: float,
    free_share: float,
    rigid_share: float = 0.0,
) -> Array:
    """Return the wires' part of the fabric's engineering stress (MPa) at engineering strains (n,).

    `free_share` is the part of the length that is loops, `rigid_share` the part of a loop that is a rigid component.
    """
    total = np.zeros_like(strain)
    for excess, weight, rigid in ((crimp, 1.0 - free_share, 0.0), (slack, free_share, rigid_share)):
        stretch = np.maximum((1.0 + strain - rigid) / (1.0 + excess - rigid) - 1.0, 0.0)
        total += weight * law.loading_curve(stretch)
    return total * area_mm2 / (spacing_mm * thickness_mm)


def without_wires(warp: PowerLaw, weave: Weave, stress: Array, strain: Array) -> WireShare:
    """Return the warp law lowered by the wires' fabric stress (n,) MPa at engineering strains (n,) of the coupon.

    Raises BadInput when the wires alone would carry more than half of what the coupon did.
    """
    scale = weave.truss_area / weave.nominal_area[0]
    measured = warp.loading_curve(strain) * scale
    largest = float(np.max(stress / measured))
    if np.any(stress > 0.5 * measured):
        worst = float(strain[int(np.argmax(stress / measured))])
        raise BadInput.of(
            f"the wires alone would carry {100 * largest:.0f} % of the coupon's stress at {100 * worst:.1f} % strain, "
            "but the coupon contained them; set wires.coupons_contain_wires to false if it did not, or use fewer or "
            "thinner filaments or more wires.crimp",
            key="wires.filaments",
        )

    def excess(log_h_and_n: Array) -> Array:
        law = replace(warp, H=float(np.exp(log_h_and_n[0])), n=float(log_h_and_n[1]))
        difference: Array = law.loading_curve(strain) * scale + stress - measured
        return difference

    weight = 1.0 / (measured + RELATIVE_FROM * measured[-1])
    best = _least_squares(lambda guess: weight * excess(guess), np.array([np.log(warp.H), warp.n]))
    law = replace(warp, H=float(np.exp(best[0])), n=float(best[1]))
    left = np.abs(excess(best))
    return WireShare(
        law,
        at_end=float(stress[-1] / measured[-1]),
        largest=largest,
        misfit=float(left.max() / measured[-1]),
        relative_misfit=float((left / measured)[strain >= 0.01].max()),
    )


def _least_squares(difference: Callable[[Array], Array], start: Array) -> Array:
    """Return the two unknowns that minimise the sum of squares: Gauss-Newton, steps halved until the sum falls.

    scipy's would do as well, but its import alone takes longer than the rest of a small case. Raises BadInput when
    steps do not die out.
    """
    at, now = start, difference(start)
    for _ in range(_MOST_STEPS):
        width = 1e-6 * np.eye(len(at))
        slopes = np.stack([(difference(at + row) - difference(at - row)) / 2e-6 for row in width], axis=1)
        step = -np.linalg.lstsq(slopes, now, rcond=None)[0]
        for _ in range(_MOST_STEPS):
            then = difference(at + step)
            if then @ then <= now @ now or float(np.abs(step).max()) < _ENOUGH:
                break
            step *= 0.5
        at, now = at + step, then
        if float(np.abs(step).max()) < _ENOUGH:
            return at
    raise BadInput.of("no warp law without the wires meets the coupon's curve", key="wires")
