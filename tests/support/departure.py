"""Full coupons against the single elements they are identified as: how far they depart, and what each cause adds.

In a coupon along a yarn nothing but that yarn should carry. What carries beside it are stretched diagonals, and they
stretch as far as the width cannot contract: because clamps hold it near the ends, or because the other yarns resist
compression. So three coupons tell the causes apart: ends that slide across (compression alone), clamped ends (clamps
too), and a width held everywhere (diagonals stretched in full: the bound). Without diagonals nothing is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from support.unit_cell import unit_cell_curve

from etextile.identify.coupon import loading_curve
from etextile.identify.virtual import Coupon, Ends, coupon_stress, in_bias
from etextile.lattice.weave import DIAGONAL, WARP, WEFT, Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.types import Array


RATIOS = (0.0, 0.001, 0.1)
"""Compression ratios looked at: buckling yarns, nearly so, and the paper's for its unit cell."""
NO_DIAGONALS = 1e-6
ANGLE = {WARP: 0.0, WEFT: 90.0, DIAGONAL: 45.0}


@dataclass(frozen=True)
class Departure:
    """Stress of the single element (n,) over strain (n,), MPa, and relative departures (n,) of coupons by name."""

    strain: Array
    single: Array
    coupons: dict[str, Array]


def single_element(weave: Weave, law: PowerLaw, family: int, *, strain: Array) -> Array:
    """Return the fabric stress (n,) of one truss at engineering strains (n,), as the direct identification has it."""
    ratio = weave.nominal_area[family] / weave.truss_area
    return np.asarray(loading_curve(law, np.log1p(strain)).stress / ratio)


def along_yarns(
    weave: Weave, laws: Sequence[PowerLaw], family: int, *, size: tuple[float, float], coarsening: float, strain: Array
) -> Departure:
    """Return the departures of coupons along warp or weft, by cause.

    Names: 'clamped 0.1' and 'sliding 0.1' with the compression ratio, 'width held', 'clamped without diagonals'.
    """
    single = single_element(weave, laws[family], family, strain=strain)

    def pulled(ends: Ends, ratio: float, diagonals: float = 1.0) -> Array:
        chosen = [replace(law, compression_ratio=ratio) for law in laws]
        chosen[DIAGONAL] = chosen[DIAGONAL].scaled(diagonals)
        coupon = Coupon(size, ANGLE[family], coarsening, ends)
        return coupon_stress(weave, chosen, coupon, strain=strain) / single - 1.0

    found = {}
    for ratio in RATIOS:
        found[f"clamped {ratio:g}"] = pulled("clamped", ratio)
        found[f"sliding {ratio:g}"] = pulled("sliding", ratio)
    found["width held"] = pulled("width held", 0.0)
    found["clamped without diagonals"] = pulled("clamped", 0.0, NO_DIAGONALS)
    return Departure(strain, single, found)


def in_bias_direction(
    weave: Weave, laws: Sequence[PowerLaw], *, size: tuple[float, float], coarsening: float, strain: Array
) -> Departure:
    """Return the departures of bias coupons and of the unit cell from a single diagonal.

    Names: 'coupon 0.1' with the compression ratio of all trusses, 'coupon, yarns held' (warp and weft keep their length
    in compression), 'unit cell 0.1' (the paper's check).
    """
    single = single_element(weave, laws[DIAGONAL], DIAGONAL, strain=strain)
    coupon = Coupon(size, ANGLE[DIAGONAL], coarsening)
    found = {"coupon, yarns held": coupon_stress(weave, in_bias(laws), coupon, strain=strain)}
    for ratio in RATIOS:
        chosen = [replace(law, compression_ratio=ratio) for law in laws]
        found[f"coupon {ratio:g}"] = coupon_stress(weave, chosen, coupon, strain=strain)
    chosen = [replace(law, compression_ratio=RATIOS[-1]) for law in laws]
    found[f"unit cell {RATIOS[-1]:g}"] = unit_cell_curve(weave, chosen, angle=ANGLE[DIAGONAL], strain=strain).stress
    return Departure(strain, single, {name: stress / single - 1.0 for name, stress in found.items()})


def held_width_share(weave: Weave, laws: Sequence[PowerLaw], family: int, *, strain: float) -> float:
    """Return what both diagonals add to a coupon along warp or weft whose width cannot contract, in closed form.

    A diagonal at angle a to the pull is stretched by lambda = sqrt(((1 + e) cos a)^2 + sin^2 a) and pulls along it with
    cos a' = (1 + e) cos a / lambda; a cut across the coupon meets two of them for every yarn.
    """
    along, across = (weave.cell_warp, weave.cell_weft) if family == WARP else (weave.cell_weft, weave.cell_warp)
    cosine, sine = along / weave.cell_diagonal, across / weave.cell_diagonal
    stretch = float(np.hypot((1.0 + strain) * cosine, sine))
    pull = float(loading_curve(laws[DIAGONAL], np.log([stretch])).stress[0]) * (1.0 + strain) * cosine / stretch
    return 2.0 * pull / float(loading_curve(laws[family], np.log1p([strain])).stress[0])
