"""Bias coupons without curves of warp and weft: a shear law, what it foretells of other sizes, and a fabric file.

Nothing is known of the yarns then, so they are taken as near inextensible, and that is said. The fabric's diagonals
have the power law nearest to the shear law; the law itself stands in a table beside the file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from etextile.errors import BadInput
from etextile.files import write_table, write_whole
from etextile.identify.bias_extension import (
    BiasCoupon,
    ForetoldCoupon,
    ShearLaw,
    diagonal_law,
    fit_law,
    foretold,
    inextensible,
)
from etextile.identify.curves import TensileCurve
from etextile.identify.result import FAMILY_OF, area_ratios
from etextile.identify.shear_force import LEAST_RATIO
from etextile.laws.powerlaw import PowerLaw
from etextile.studies.identify.identify import HEADER, check_output, rounded, weave_of
from loadcases.fabric import Fabric, Family, dump_fabric, load_base
from loadcases.measured import Measured


YARNS = "not measured: near inextensible, 0.1 % under the largest stress of the bias coupons"


@dataclass(frozen=True)
class BiasIdentification:
    """What bias coupons alone gave: the shear law, the coupons, what other sizes foretell of each, and the fabric.

    missed: root mean square difference of the diagonals' power law to the shear law, over its largest moment.
    """

    law: ShearLaw
    coupons: tuple[BiasCoupon, ...]
    foretold: tuple[ForetoldCoupon, ...]
    fabric: Fabric
    missed: float
    title: str
    base: str
    fabric_file: Path | None = None
    figures: tuple[Path, ...] = ()


def bias_alone(curves: Mapping[str, Sequence[TensileCurve]]) -> bool:
    """Tell whether there are bias coupons alone, of known size and long enough to have a middle in pure shear."""
    specimens = curves.get("bias", ())
    sizes = [curve.size for curve in specimens]
    alone = bool(specimens) and not any(curves.get(name) for name in FAMILY_OF if name != "bias")
    return alone and all(size is not None and size.gauge_length >= LEAST_RATIO * size.width for size in sizes)


def identify_bias(curves: Sequence[TensileCurve], *, title: str, fabric: str | Path) -> BiasIdentification:
    """Return what bias coupons tell; `fabric` lends the weave. Raises BadInput where they are not sheared."""
    base = load_base(fabric)
    coupons = tuple(_coupon(curve) for curve in curves)
    sizes = [curve.size for curve in curves if curve.size is not None]
    thickness = float(np.mean([size.thickness for size in sizes]))
    try:
        law = fit_law(coupons)
    except ValueError as error:
        raise BadInput.of(str(error), file=curves[0].file) from error
    weave = replace(weave_of(base), thickness=thickness)
    start = PowerLaw(1.0, 0.0, 1.0, 1.0, base.diagonal.e0)
    diagonal, missed = diagonal_law(law, weave, start)
    a, b = weave.cell_warp, weave.cell_weft
    stretch = float(np.sqrt(1.0 + 2.0 * a * b * np.sin(law.angle[-1]) / (a**2 + b**2))) - 1.0
    ratios, names = area_ratios(weave), ", ".join(item.name for item in coupons)
    families = {
        name: _family(inextensible(coupons, thickness, start, ratios[name]), (0.0, 0.01), YARNS, estimated=True)
        for name in ("warp", "weft")
    }
    families["diagonal"] = _family(diagonal, (0.0, stretch), f"shear law of bias coupons {names}", estimated=False)
    found = base.model_copy(
        update={
            "title": f"Identified: {title}", "thickness": thickness,
            "description": f"Shear from bias coupons alone; weave from {Path(fabric).stem}.", **families,
        }
    )  # fmt: skip
    return BiasIdentification(law, coupons, foretold(coupons), found, missed, title, Path(fabric).stem)


def write_bias(found: BiasIdentification, output: Path, *, force: bool = False) -> BiasIdentification:
    """Write the fabric file, the shear law as a table (_shear.csv) and a picture (_shear.png) beside it."""
    from viz.shear_plots import save_shear

    check_output(output, force=force)
    output.parent.mkdir(parents=True, exist_ok=True)
    write_whole(output, f"{HEADER}\n{dump_fabric(found.fabric)}")
    angle = np.linspace(0.0, found.law.angle[-1], 91)
    columns = (np.degrees(angle), found.law.at(angle), found.law.shear_force(angle))
    table = output.parent / f"{output.stem}_shear.csv"
    rows = ([f"{value:.6g}" for value in row] for row in zip(*columns, strict=True))
    write_table(table, [("shear_angle_deg", "moment_N_per_mm", "shear_force_N_per_mm"), *rows])
    picture = save_shear(found.law, found.coupons, output.parent / f"{output.stem}_shear.png", title=found.title)
    return replace(found, fabric_file=output, figures=(table, picture))


def _coupon(curve: TensileCurve) -> BiasCoupon:
    """Return the loading of a coupon, up to its largest extension, as displacement and force."""
    size = curve.size
    if size is None:
        raise BadInput.of("give width, thickness and gauge_length", file=curve.file)
    end = int(np.argmax(curve.strain)) + 1
    force = curve.stress[:end] * size.width * size.thickness
    return BiasCoupon(curve.name, curve.strain[:end] * size.gauge_length, force, (size.gauge_length, size.width))


def _family(law: PowerLaw, span: tuple[float, float], source: str, *, estimated: bool) -> Family:
    """Return a family as it stands in a fabric file."""
    return Family(
        E=Measured(value=rounded(law.E), source="high: loading is all hardening, no unloading is used", estimated=True),
        sigma_y0=Measured(value=rounded(law.sigma_y0)),
        H=Measured(value=rounded(law.H)),
        n=Measured(value=rounded(law.n)),
        e0=law.e0,
        strain_range=(span[0], rounded(span[1])),
        estimated=estimated,
        source=source,
    )
