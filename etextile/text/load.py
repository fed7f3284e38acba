"""Runs whose motion is a load, and the first rupture, on a terminal: in the quantities and words of their standards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rich.table import Table
from rich.text import Text

from etextile.text.plain import framed
from wires.wording import figures, unit_for


SETS = "run it with fabric.set=estimated_low and estimated_high too: strengths then differ by a factor of 3"
STRAINS = tuple((f"{family} strain, max", f"{family}_max") for family in ("warp", "weft", "diagonal"))


def load_table(report: Mapping[str, Any], steps: Sequence[int]) -> Table | None:
    """Return the table over pressure or weight at the given steps, None for other motions."""
    if "pressure" in report:
        block, title = report["pressure"], "Over pressure"
        rows: tuple[tuple[str, str, str], ...] = (
            ("pressure, bar", "pressure_bar", "{:.3f}"),
            ("height, mm", "height_mm", "{:.2f}"),
            ("volume, cm3", "volume_mm3", "{:.1f}"),
            ("diaphragm, bar", "diaphragm_bar", "{:.3f}"),
            ("gauge, bar", "gauge_bar", "{:.3f}"),
        )
        rows = tuple(row for row in rows if row[1] in block)
    elif "weight" in report:
        block, title = report["weight"], "Over the strip's own weight"
        rows = (
            ("mass, g/m2", "mass_g_m2", "{:.4g}"),
            ("drop of the end, mm", "drop_mm", "{:.2f}"),
            ("angle, deg", "angle_deg", "{:.1f}"),
        )
    else:
        return None
    table = framed(title)
    for number, (name, key, form) in enumerate(rows):
        values = [block[key][step] * (1e-3 if key == "volume_mm3" else 1.0) for step in steps]
        if number == 0:
            table.add_column(name, no_wrap=True)
            for value in values:
                table.add_column(form.format(value), justify="right")
        else:
            table.add_row(name, *(form.format(value) for value in values))
    for name, key in STRAINS if "pressure" in report else ():
        table.add_row(name, *(f"{report['strain'][key][step]:.3f}" for step in steps))
    return table


def load_lines(report: Mapping[str, Any]) -> list[Text]:
    """Return what a standard reads from the run: the bending stiffness of a cantilever, the first rupture."""
    lines = []
    weight = report.get("weight")
    if weight is not None:
        found = weight["at_standard_angle"]
        text = (
            f" 41.5 deg at {found['mass_g_m2']:.4g} g/m2: bending length {0.5 * weight['overhang_mm']:.3g} mm (half "
            f"the overhang), bending stiffness (flexural rigidity) {found['peirce_stiffness_Nmm']:.4g} N mm by the "
            "rule of the standard"
            if found is not None
            else " the strip does not come down to 41.5 deg: raise motion.total or lengthen fabric.size"
        )
        lines.append(Text(f"\n{text}"))
    rupture = report.get("rupture")
    if rupture is not None and weight is None:
        lines.append(Text(f"\n {rupture_line(rupture)}{_elongation(report)}"))
        lines += [Text(f" {SETS}", style="dim")] if _hangs_on_estimates(report) else []
    return lines


def _hangs_on_estimates(report: Mapping[str, Any]) -> bool:
    """Tell whether a test of fabric alone was run with one of the estimated sets."""
    return not report["wires"] and str(report["case"].get("fabric", "")).startswith("estimated_")


def _elongation(report: Mapping[str, Any]) -> str:
    """Return the elongation of a coupon at the first rupture, as standards of strips tell it."""
    coupon, first = report.get("coupon"), report["rupture"]["first"]
    if coupon is None or first is None:
        return ""
    return f"; elongation {100 * first['displacement_mm'] / coupon['gauge_length_mm']:.1f} %"


def rupture_line(rupture: Mapping[str, Any]) -> str:
    """Return the first rupture in words, with its interval."""
    first = rupture["first"]
    if first is None:
        worst = max(rupture["reached"], key=rupture["reached"].get)
        return f"no yarn breaks: {worst} comes to {100 * rupture['reached'][worst]:.0f} % of its rupture strain"
    inflated = "pressure_bar" in first
    units = (
        {"pressure_bar": "bar", "displacement_mm": "mm"}
        if inflated
        else {"displacement_mm": "mm", "force_N": "N", "angle_deg": "deg", "moment_Nmm": "N mm"}
    )
    named = {"pressure_bar": "bursting strength ", "displacement_mm": "bursting distension "} if inflated else {}
    beside = {"gauge_bar": "bar", "diaphragm_bar": "bar"}
    ends = [rupture["low"], rupture["high"]]

    def value(key: str) -> str:
        found = [first[key], *(None if end is None else end[key] for end in ends)]
        by, unit = unit_for(found, {**units, **beside}[key])
        middle, low, high = (figures(None if number is None else number / by) for number in found)
        return f"{middle} {unit} [{low}, {high}]"

    shown = ", ".join(named.get(key, "") + value(key) for key in units if key in first)
    if "gauge_bar" in first:
        shown += f" (the gauge shows {value('gauge_bar')}, the diaphragm takes {value('diaphragm_bar')})"
    guess = " (rupture strain estimated)" if rupture["strain"][first["family"]]["estimated"] else ""
    return f"first {first['family']} yarn breaks{':' if inflated else ' at'} {shown}{guess}"
