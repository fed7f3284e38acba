"""identify --refine: laws for which virtual coupons, not single trusses, return the measured curves.

The coupons are those of the shipped cases `tension_warp`, `tension_weft` and `bias_extension`, in the size of the
measured ones. How far the direct use of each curve was off is kept over strain, for text and figure.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from etextile.identify.refine import ROUNDS, TargetCurve, refine, target_of
from etextile.identify.virtual import Coupon, coupon_stress, in_bias
from etextile.laws.powerlaw import PowerLaw
from etextile.studies.identify.found import Identification, Refinement
from etextile.studies.identify.identify import rounded, weave_of
from etextile.types import Array
from loadcases.fabric import Fabric, Family


ANGLES = {"warp": 0.0, "weft": 90.0, "diagonal": 45.0}
"""Angle of the warp to the pull in the coupon that identifies a family."""
DEFAULT_SIZE = (60.0, 29.0)
"""Free size of the coupons in Beex et al., mm."""
CELLS_ACROSS = 17
BIAS_LIMIT = 0.2
"""Nominal strain up to which bias curves are refined: up to there the centre follows a trellis within 5 %."""
SHOWN_LIMIT = 0.28
"""Nominal strain up to which the direct use of a bias curve is judged; near 0.3 the trellis closes."""
INCREMENTS = 14

Watch = Callable[[float, str], None]


def work(families: int) -> int:
    """Return the number of coupons that a refinement of some families simulates at most."""
    return families * (ROUNDS + 2)


def refined(
    result: Identification,
    base: Fabric,
    *,
    size: tuple[float, float] | None = None,
    coarsening: float | None = None,
    watch: Watch | None = None,
) -> Identification:
    """Return the identification with the families' laws refined; `base` supplied the weave.

    `size`: free length and width of the coupons, mm (60 x 29 by default); `watch` hears of every coupon pulled.
    Raises NoEquilibrium when a coupon cannot be pulled to the end.
    """
    found = _refinement(result, base, size=size or DEFAULT_SIZE, coarsening=coarsening, watch=watch)
    families = {
        name: _with_law(getattr(result.fabric, name), law, found.coupons[name])
        for name, law in found.refined.laws.items()
        if name in found.targets
    }
    fabric = result.fabric.model_copy(update=families)
    return replace(result, fabric=fabric, refinement=found)


def _refinement(
    result: Identification, base: Fabric, *, size: tuple[float, float], coarsening: float | None, watch: Watch | None
) -> Refinement:
    """Pull coupons and adjust the laws until they return the curves."""
    weave = weave_of(base)
    step = coarsening or max(1.0, size[1] / (CELLS_ACROSS * max(base.cell)))
    coupons = {name: Coupon(size, ANGLES[name], step) for name in result.identified.families}
    done = 0

    def simulate(family: str, laws: Mapping[str, PowerLaw], strain: Array) -> Array:
        nonlocal done
        stress = coupon_stress(weave, _laws_in(family, laws), coupons[family], strain=strain, increments=INCREMENTS)
        done += 1
        if watch is not None:
            watch(done, f"{family} coupon, {len(laws)} families at work")
        return stress

    laws = {name: law_of(getattr(result.fabric, name)) for name in ANGLES}
    targets: dict[str, TargetCurve] = {}
    direct: dict[str, tuple[TargetCurve, Array]] = {}
    for name, item in result.identified.families.items():
        top = item.fit.strain_range[1]
        limit, shown = (BIAS_LIMIT, SHOWN_LIMIT) if name == "diagonal" else (top, top)
        targets[name] = target_of(laws[name], item.area_ratio, min(top, limit))
        whole = target_of(laws[name], item.area_ratio, min(top, shown))
        direct[name] = (whole, simulate(name, laws, whole.strain) / whole.stress - 1.0)
    return Refinement(coupons, targets, refine(laws, targets, simulate), direct)


def _laws_in(family: str, laws: Mapping[str, PowerLaw]) -> Sequence[PowerLaw]:
    """Return the laws of warp, weft and diagonal as they act in the coupon of a family."""
    chosen = tuple(laws[name] for name in ANGLES)
    return in_bias(chosen) if family == "diagonal" else chosen


def law_of(family: Family) -> PowerLaw:
    """Return the law of a family of a fabric file."""
    return PowerLaw(
        family.E.value, family.sigma_y0.value, family.H.value, family.n.value, e0=family.e0,
        compression_ratio=family.compression_ratio,
    )  # fmt: skip


def _with_law(family: Family, law: PowerLaw, coupon: Coupon) -> Family:
    """Return a family with refined H and n; their relative scatter stays what the measured curves say."""
    gain = law.H / family.H.value
    size = f"{coupon.size[0]:g} x {coupon.size[1]:g} mm"
    spread = None if family.H.std is None else rounded(gain * family.H.std)
    covariance = family.covariance
    if covariance is not None:
        scale = np.array([gain if name == "H" else 1.0 for name in covariance.parameters])

        def scaled(matrix: Sequence[Sequence[float]]) -> tuple[tuple[float, ...], ...]:
            values = scale[:, None] * np.array(matrix) * scale[None, :]
            return tuple(tuple(rounded(float(value)) for value in row) for row in values)

        between = covariance.between_specimens
        covariance = covariance.model_copy(
            update={
                "matrix": scaled(covariance.matrix),
                "between_specimens": None if between is None else scaled(between),
            }
        )
    return family.model_copy(
        update={
            "H": family.H.model_copy(update={"value": rounded(law.H), "std": spread}),
            "n": family.n.model_copy(update={"value": rounded(law.n)}),
            "covariance": covariance,
            "source": f"{family.source}, refined by virtual coupons of {size}",
        }
    )
