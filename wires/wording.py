"""How numbers and states of the report are written, on the terminal and on the page alike."""

from __future__ import annotations

import math
from collections.abc import Sequence

from etextile.units import probability as probability


LETTERS = {"intact": ".", "plastic": "~", "partial": "x", "open": "O"}
"""One letter per state, for strips of loops that must be readable without colours."""

FOLDED = "/"
"""The letter of a loop that lies in a fold of a worn piece and has not failed before: nothing is known of it."""


def number(value: float | None, form: str) -> str:
    """Format a number, `-` when there is none."""
    return "-" if value is None else form.format(value)


_LARGER = {"N": ("kN", 1e5), "N mm": ("N m", 1e3), "kPa": ("MPa", 1e3)}
"""The unit a thousand times as large, and from which value on it is used."""


def figures(value: float | None, digits: int = 3) -> str:
    """Format a number with so many significant digits, never with an exponent above 1e-4; `-` when there is none."""
    if value is None:
        return "-"
    return f"{value:.0f}" if abs(value) >= 10.0 ** (digits - 1) else f"{value:.{digits}g}"


def unit_for(values: Sequence[float | None], unit: str) -> tuple[float, str]:
    """Return what to divide values by, and the unit they are then in: the larger one where their largest asks for it.

    All of a row or a curve share one unit; N mm become N m from 1000 on, kPa MPa, N kN from 100 000 on.
    """
    larger, start = _LARGER.get(unit, (unit, math.inf))
    most = max((abs(value) for value in values if value is not None), default=0.0)
    return (1e3, larger) if most >= start else (1.0, unit)


def quantity(value: float | None, unit: str, *, digits: int = 3) -> tuple[str, str]:
    """Return a value and its unit as they are read best: 422 800 N mm as `423` and `N m`."""
    by, shown = unit_for([value], unit)
    return figures(None if value is None else value / by, digits), shown


def spoken(value: float | None, unit: str, *, digits: int = 3) -> str:
    """Return a value with its unit as `quantity` has them, as text."""
    return " ".join(quantity(value, unit, digits=digits))


def percent(value: float) -> str:
    """Format a share as a whole percentage, without calling a few `0 %` or a remainder `100 %`."""
    if 0.0 < value < 0.005:
        return "<1 %"
    return ">99 %" if 0.995 < value < 1.0 else f"{100 * value:.0f} %"


def chance(value: float) -> str:
    """Format a probability in per cent to a tenth, without claiming certainty."""
    if value < 0.001:
        return "<0.1 %"
    return ">99.9 %" if value > 0.999 else f"{100 * value:.1f} %"


def compact(value: float | str) -> str:
    """Return a number without needless digits, or text as it is."""
    return value if isinstance(value, str) else f"{value:g}"


def cycles(value: float) -> str:
    """Write a number of cycles with three digits, whole and with thin thousands up to a million."""
    if value == 0.0 or value >= 1e6 or value < 1.0:
        return f"{value:.3g}"
    digits = max(0, 2 - math.floor(math.log10(value)))
    rounded = float(f"{value:.3g}")
    return f"{rounded:,.{digits}f}".replace(",", " ")
