"""The coupon on a terminal: nominal curve, the single element it stands for, the centre, the zones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.table import Table

from etextile.text.plain import framed


def coupon_table(coupon: Mapping[str, Any], steps: Sequence[int]) -> Table:
    """Return the table of a coupon at the given steps, readable at 80 columns."""
    size = f"{coupon['gauge_length_mm']:g} x {coupon['width_mm']:g} mm"
    title = f"Coupon of {size}, warp at {coupon['warp_angle_deg']:g} deg to the pull"
    table = framed(title)
    table.add_column("nominal strain", no_wrap=True)
    for step in steps:
        table.add_column(_share(coupon["strain"][step]), justify="right")
    for name, values, form in _rows(coupon):
        table.add_row(name, *("-" if values[step] is None else form(values[step]) for step in steps))
    return table


def _rows(coupon: Mapping[str, Any]) -> list[tuple[str, Sequence[float | None], Any]]:
    """Return name, values and format of every row there is something to say in."""
    centre, zones, trellis = coupon["centre"], coupon["zones"], coupon.get("trellis")
    rows: list[tuple[str, Sequence[float | None] | None, Any]] = [
        ("stress, MPa", coupon["stress_MPa"], _digits),
        ("single element, MPa", coupon["single_element_MPa"], _digits),
    ]
    if centre is not None:
        rows += [("centre strain", centre["strain"], _share), ("  across", centre["strain_across"], _share)]
    if centre is not None and zones is not None:
        rows += [("  shear angle, deg", centre["shear_angle_deg"], _degrees)]
    if trellis is not None:
        rows += [("  of a trellis, deg", trellis["shear_angle_deg"], _degrees)]
    normalised = coupon.get("normalised_shear")
    if normalised is not None:
        rows += [("as a test: shear, deg", normalised["shear_angle_deg"], _degrees)]
        rows += [("  shear force, N/mm", normalised["shear_force_N_mm"], _digits)]
    rows += [(f"zone {name}, mean, deg", zone["shear_angle_deg"], _degrees) for name, zone in (zones or {}).items()]
    return [(name, values, form) for name, values, form in rows if values is not None]


def _share(value: float) -> str:
    return f"{100.0 * value:.1f} %"


def _digits(value: float) -> str:
    return f"{value:.4g}"


def _degrees(value: float) -> str:
    return f"{value:.1f}"
