"""The woven nylon at any angle: strips of the case `nylon_30`, turned, against the measured curves."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np
from support.nylon_data import FOLDER, load_nylon
from support.prediction import Prediction, compare, datum_of
from support.unit_cell import unit_cell_curve

from etextile.identify.coupon import loading_curve
from etextile.identify.refine import refine, target_of
from etextile.identify.result import area_ratios
from etextile.identify.virtual import Coupon, coupon_stress
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.studies.identify.identify import curves_of, identify_curves, named_laws, weave_of
from etextile.studies.identify.refine import ANGLES, law_of
from etextile.types import Array
from loadcases.fabric import load_fabric
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
    coupon = Coupon(case.pattern, angle, coarsening or case.fabric.coarsening)
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


ASSUMPTIONS = {
    "nothing buckles (shipped)": (1.0, 1.0, 1.0),
    "half of that": (0.5, 0.5, 0.5),
    "a tenth": (0.1, 0.1, 0.1),
    "diagonals go slack": (1.0, 1.0, 0.0),
}
"""Compression ratios of warp, weft and diagonal under which the prediction is looked at again."""


def under_assumptions(angle: int = 30) -> dict[str, Prediction]:
    """Return predictions at an angle, for each assumption on compression refined anew, and without a lattice at all.

    Long strips away from their clamps (the unit cell). 'linear orthotropic sheet': the secants measured at 0, 45 and 90
    degrees turned as those of any sheet with three planes of symmetry, strain by strain.
    """
    fabric = load_fabric("nylon_woven")
    weave, strain = weave_of(fabric), np.linspace(0.0, STRAIN, 90)[1:]
    _, curves = curves_of(FOLDER)
    found = identify_curves(
        curves, title="nylon", fabric="nylon_woven", modulus_from="estimated_mid"
    ).identified.families
    targets = {name: target_of(item.law, item.area_ratio, item.fit.strain_range[1]) for name, item in found.items()}
    measured = load_nylon(angle)
    lender = named_laws(load_fabric("estimated_mid"), "estimated_mid")["diagonal"]
    datum = datum_of(measured, found["diagonal"].area_ratio, named=lender)
    result = {}
    for name, ratios in ASSUMPTIONS.items():
        simulate = partial(_strip, weave, ratios)
        laws = refine({family: item.law for family, item in found.items()}, targets, simulate).laws
        result[name] = compare(measured, strain, _cell(weave, laws, ratios, angle=angle, strain=strain), datum=datum)
    secant = {
        ANGLES[family]: loading_curve(item.law, np.log1p(strain)).stress / (item.area_ratio * strain)
        for family, item in found.items()
    }
    turned = _orthotropic(secant[0.0], secant[45.0], secant[90.0], angle=angle) * strain
    return {**result, "linear orthotropic sheet": compare(measured, strain, turned, datum=datum)}


def _strip(weave: Weave, ratios: tuple[float, ...], family: str, laws: Mapping[str, PowerLaw], strain: Array) -> Array:
    """Return the stress of the strip that identifies a family."""
    return _cell(weave, laws, ratios, angle=ANGLES[family], strain=strain)


def _cell(
    weave: Weave, laws: Mapping[str, PowerLaw], ratios: tuple[float, ...], *, angle: float, strain: Array
) -> Array:
    """Return the stress of the unit cell at an angle with given compression ratios."""
    chosen = [replace(laws[family], compression_ratio=ratio) for family, ratio in zip(ANGLES, ratios, strict=True)]
    return unit_cell_curve(weave, chosen, angle=angle, strain=strain).stress


def _orthotropic(at_0: Array, at_45: Array, at_90: Array, *, angle: float) -> Array:
    """Return the secant modulus of an orthotropic sheet at an angle from those at 0, 45 and 90 degrees.

    1 / E = cos^4 / E_0 + sin^4 / E_90 + X cos^2 sin^2 with X from 45 degrees.
    """
    c, s = np.cos(np.radians(angle)) ** 2, np.sin(np.radians(angle)) ** 2
    mixed = 4.0 / at_45 - 1.0 / at_0 - 1.0 / at_90
    return np.asarray(1.0 / (c**2 / at_0 + s**2 / at_90 + mixed * c * s))
