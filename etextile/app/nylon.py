"""The woven nylon at any angle: strips of the case `nylon_30`, turned, against the measured curves."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from etextile.app.identify import named_laws, weave_of
from etextile.app.refine import law_of
from etextile.identify.prediction import Prediction, compare, datum_of
from etextile.identify.result import area_ratios
from etextile.identify.virtual import Coupon, coupon_stress
from etextile.types import Array
from loadcases.fabric import load_fabric
from loadcases.nylon import load_nylon
from loadcases.reader import load_case


STRAIN = 0.0445
INCREMENTS = 10


def strip_curve(angle: float, *, coarsening: float | None = None) -> tuple[Array, Array]:
    """Return nominal strain and stress (n,), MPa, of a strip of the case `nylon_30` cut at `angle` degrees to the warp.

    `coarsening`: another than the case's.
    """
    case = load_case("nylon_30").case
    fabric = load_fabric(case.fabric.set)
    laws = [law_of(family) for family in (fabric.warp, fabric.weft, fabric.diagonal)]
    coupon = Coupon(case.fabric.size, angle, coarsening or case.fabric.coarsening)
    strain = STRAIN * (np.arange(1, INCREMENTS + 1) / INCREMENTS) ** 1.5
    return strain, coupon_stress(weave_of(fabric), laws, coupon, strain=strain)


def predictions(angles: Iterable[int], *, coarsening: float | None = None) -> dict[int, Prediction]:
    """Return strips against the shipped measurements at 0, 30, 45 or 90 degrees; only 30 is a prediction."""
    lenders = named_laws(load_fabric("estimated_mid"), "estimated_mid")
    ratios = area_ratios(weave_of(load_fabric("nylon_woven")))
    found = {}
    for angle in angles:
        curve = load_nylon(angle)
        family = {0: "warp", 90: "weft"}.get(angle, "diagonal")
        datum = datum_of(curve, ratios[family], named=lenders[family])
        found[angle] = compare(curve, *strip_curve(angle, coarsening=coarsening), datum=datum)
    return found
