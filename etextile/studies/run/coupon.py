"""What the report of a coupon says beside force and displacement: nominal stress and strain, the centre, the zones."""

from __future__ import annotations

from typing import Any

import numpy as np

from etextile.identify.coupon import loading_curve
from etextile.identify.shear_force import LEAST_RATIO, normalised_shear_force
from etextile.identify.virtual import ZONES, at_centre, cell_motion, ideal_centre_strain, trellis_angle, zone_of_cells
from etextile.lattice.piece import Lattice
from etextile.lattice.weave import DIAGONAL, WARP, WEFT
from etextile.results.reader import Results
from etextile.types import Array, IntArray
from loadcases.build import Built
from loadcases.schema import Case


def is_coupon(case: Case) -> bool:
    """Tell whether a case pulls a whole flat piece along x between its two clamps."""
    return (
        case.body is None
        and case.motion.target in ("x_min", "x_max")
        and set(case.supports.clamped) == {"x_min", "x_max"}
        and case.fabric.portion == "whole"
    )


def coupon_block(results: Results, built: Built) -> dict[str, Any]:
    """Return the `coupon` block of report.json over the steps; angles in degrees, strains and stresses engineering.

    `single_element_MPa`: what the direct identification takes for this curve (null at angles without a family);
    `normalised_shear`: angle and force free of the coupon's size (45 deg); `zones`: mean shear angles in the zones A,
    B and C (null for a coupon along a yarn, and for a zone without cells).
    """
    length, width = built.case.pattern
    angle = built.case.fabric.warp_angle
    strain = results.displacement_mm / length
    block: dict[str, Any] = {
        "gauge_length_mm": length,
        "width_mm": width,
        "thickness_mm": built.fabric.thickness,
        "warp_angle_deg": angle,
        "strain": strain,
        "stress_MPa": results.curves.punch_force_N / (width * built.fabric.thickness),
        "single_element_MPa": _single_element(built, strain),
        "centre": None,
        "zones": None,
    }
    lattice = built.model.lattice
    if results.steps and len(lattice.quads):
        block |= _motion(results, lattice, (length, width))
        if angle % 90.0 == 45.0:
            centre = block["centre"]
            block["trellis"] = {
                "shear_angle_deg": np.degrees(trellis_angle(centre["strain"])),
                "ideal_centre_strain": ideal_centre_strain(strain, (length, width)) if length > width else None,
            }
            block["normalised_shear"] = _normalised_shear(results, (length, width))
    return block


def _normalised_shear(results: Results, size: tuple[float, float]) -> dict[str, Array] | None:
    """Return shear angle (deg) and force per width (N/mm) as a test is evaluated; None for short coupons."""
    if size[0] <= LEAST_RATIO * size[1]:
        return None
    angle, force = normalised_shear_force(results.displacement_mm, results.curves.punch_force_N, size)
    return {"shear_angle_deg": np.degrees(angle), "shear_force_N_mm": force}


def _motion(results: Results, lattice: Lattice, size: tuple[float, float]) -> dict[str, Any]:
    """Return the blocks `centre` and `zones` over the steps."""
    nodes = len(lattice.points)
    motions = [cell_motion(lattice, results.points(step)[:nodes]) for step in range(results.steps)]
    middle = at_centre(lattice, size)

    def mean(name: str, cells: IntArray) -> Array | None:
        return np.array([getattr(item, name)[cells].mean() for item in motions]) if len(cells) else None

    def degrees(cells: IntArray) -> Array | None:
        value = mean("shear", cells)
        return None if value is None else np.degrees(value)

    centre = {
        "strain": mean("along", middle),
        "strain_across": mean("across", middle),
        "warp_strain": mean("warp", middle),
        "weft_strain": mean("weft", middle),
        "shear_angle_deg": degrees(middle),
    }
    if lattice.warp_angle % 90.0 == 0.0:
        return {"centre": centre}
    held = zone_of_cells(lattice, size)
    zones = {name: {"shear_angle_deg": degrees(np.flatnonzero(held == count))} for count, name in enumerate(ZONES)}
    return {"centre": centre, "zones": dict(sorted(zones.items()))}


def _single_element(built: Built, strain: Array) -> Array | None:
    """Return the stress of a single element of the family that this coupon identifies, None at other angles."""
    family = {0.0: WARP, 45.0: DIAGONAL, 90.0: WEFT, 135.0: DIAGONAL}.get(built.case.fabric.warp_angle % 180.0)
    if family is None:
        return None
    fabric = built.fabric
    law = built.model.lattice_block.laws[family]
    cell = (fabric.cell[1], fabric.cell[0], fabric.cell[0] * fabric.cell[1] / np.hypot(*fabric.cell))
    area_ratio = cell[family] * fabric.thickness / fabric.truss_area
    return loading_curve(law, np.log1p(strain)).stress / area_ratio
