"""Units at the edge: text such as `30 mm` or `7 %` becomes a plain number in mm, N, MPa, s here and nowhere else.

pint needs half a second to start, so it is loaded only for text whose unit is not the wanted one (or `%`).
"""

from __future__ import annotations

import math
import re
from functools import lru_cache
from typing import TYPE_CHECKING


if TYPE_CHECKING:
    import pint

_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_QUANTITY = re.compile(rf"\s*(?P<number>{_NUMBER})\s*(?P<unit>.*?)\s*", re.DOTALL)
_DECIMAL_COMMA = re.compile(r"\s*[+-]?[0-9]+,[0-9]+")
_THOUSANDS = re.compile(r"\s*[+-]?[1-9][0-9]{0,2}(?:,[0-9]{3})+(?![0-9])")
_UNIT_TEXT = re.compile(r"[A-Za-zµμΩ°%²³0-9*/^()·._ -]+")
_UNIT_NUMBERS = re.compile(r"(?<![A-Za-z0-9_.])\d[\d.]*")
_BARE_POWER = re.compile(r"(?<![A-Za-z])([mcdkµu]?m|s)([23])(?!\d)")

_ANGLES = ("degree", "radian", "milliradian", "arcminute", "arcsecond", "gradian", "turn")
_WORDS = {
    "": "a plain number or a share such as '7 %'",
    "mm": "a length in mm",
    "N": "a force in N",
    "MPa": "a stress in MPa",
    "s": "a time in s",
    "deg": "an angle in deg",
    "mm/s": "a speed in mm/s",
}
_EXAMPLES = {"": "7 %", "mm": "30 mm", "MPa": "0.35 GPa", "deg": "45 deg", "1/s": "8.3e-3 1/s", "mm/s": "60 mm/min"}


_SELDOM, _CERTAIN = 0.0005, 0.9995

LOAD_DIGITS = {"mm": 1, "bar": 2, "deg": 1, "1/m": 2}
"""Digits that the load of a test is told with: a travel, a pressure, an angle, a curvature."""


def load_text(value: float, unit: str, *, whole: bool = False) -> str:
    """Return the load of a test as text, without its unit; `whole`: travel and angle without digits."""
    return f"{value:.{0 if whole and unit != 'bar' else LOAD_DIGITS[unit]}f}"


def probability(value: float) -> str:
    """Return a probability as text that claims no certainty and shows no meaningless digits."""
    if value < _SELDOM:
        return "<0.001"
    return ">0.999" if value > _CERTAIN else f"{value:.3f}"


def to_number(value: float | str, unit: str) -> float:
    """Return `value` as a plain float in `unit` ('' for plain numbers, shares and strains).

    Plain numbers, also written as text, are in `unit` already; text may carry any unit that converts to it.
    Raises ValueError, with what is allowed, for anything else (also for booleans, NaN and infinity).
    """
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        raise refusal("not a number", value, unit)
    number = _from_text(value, unit) if isinstance(value, str) else _as_float(value)
    if not math.isfinite(number):
        raise refusal("not a finite number", value, unit)
    return number


def describe(unit: str) -> str:
    """Say in words what is expected for `unit`, with an example of text that carries a unit."""
    words = _WORDS.get(unit, f"a number in {unit}")
    example = _EXAMPLES.get(unit, f"3 {unit}")
    return words if not unit else f"{words}, plain or with a unit such as '{example}'"


def refusal(wrong: str, value: object, unit: str, *, hint: str = "") -> ValueError:
    """Return the error `wrong (got value), expected ...` for a number in `unit`."""
    return ValueError(f"{wrong} (got {shorten(value)}), expected {describe(unit)}{hint}")


def shorten(value: object) -> str:
    """Return a value as it is shown in messages, cut to 60 characters."""
    text = "null" if value is None else str(value).lower() if isinstance(value, bool) else repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _as_float(value: float) -> float:
    """Return an int or float as float; an int beyond the range of floats becomes infinity."""
    try:
        return float(value)
    except OverflowError:
        return math.inf


def _from_text(text: str, unit: str) -> float:
    """Split text into number and unit and convert it; the wanted unit itself and `%` need no pint."""
    if match := _THOUSANDS.match(text):
        plain = text.strip().replace(",", "")
        point = text.strip().replace(",", ".", 1)
        raise ValueError(f"a comma for thousands or decimals (got {shorten(text)}), write {plain!r} or {point!r}")
    if _DECIMAL_COMMA.match(text):
        raise ValueError(f"decimal comma (got {text!r}), write a point: {text.strip().replace(',', '.', 1)!r}")
    match = _QUANTITY.fullmatch(text)
    if match is None and any(char.isdecimal() and not char.isascii() for char in text):
        raise refusal("digits of another script", text, unit)
    if match is None:
        raise refusal("text, not a number", text, unit)
    if re.match(r"_[0-9]", match["unit"]):
        raise refusal("underscores in a number", text, unit)
    number, given = float(match["number"]), match["unit"]
    if given in ("", unit):
        return number
    if given == "%" and unit == "":
        return number * 0.01
    return _convert(text, number, given, unit=unit)


def _convert(text: str, number: float, given: str, *, unit: str) -> float:
    """Convert with pint; angles and plain numbers are kept apart although pint calls both dimensionless."""
    source = _parse(text, given, unit=unit)
    target = _registry().parse_units(unit)
    if source.dimensionality != target.dimensionality or _angle_power(source) != _angle_power(target):
        raise refusal("the unit does not fit", text, unit)
    return _registry().Quantity(number, source).to(target).magnitude


def _parse(whole: str, given: str, *, unit: str) -> pint.Unit:
    """Return the pint unit for `given`; numbers are allowed in it only as `1/...` and as small powers."""
    text = _BARE_POWER.sub(r"\1**\2", given)
    plain = re.sub(r"(\*\*|\^)\s*-?\s*[1-4](?![\d.])", "", re.sub(r"^\(?\s*1\s*(?=/)", "", text))
    if not _UNIT_TEXT.fullmatch(text) or _UNIT_NUMBERS.search(plain):
        raise refusal("not a number followed by a unit", whole, unit)
    try:
        parsed = _registry().parse_units(f"1{text}" if text.startswith("/") else text)
        _registry().Quantity(1.0, parsed).to_base_units()
    except Exception as error:  # pint raises many kinds, AssertionError and TokenError among them
        raise refusal("unknown unit", whole, unit, hint=_nearest_unit(given)) from error
    return parsed


def _nearest_unit(given: str) -> str:
    """Suggest the usual unit that differs from `given` in upper and lower case only."""
    usual = ("mm", "cm", "m", "um", "N", "kN", "MPa", "GPa", "kPa", "Pa", "s", "min", "deg", "rad", "mm/s", "N/mm")
    match = next((name for name in usual if name.lower() == given.lower()), None)
    return f", did you mean {match}?" if match else ""


def _angle_power(unit: pint.Unit) -> float:
    """Return the power of angle in a unit (1 for deg and rad), which pint takes for dimensionless."""
    items = _registry().Quantity(1.0, unit).unit_items()
    return sum(float(str(power)) for name, power in items if name in _ANGLES)


@lru_cache(maxsize=1)
def _registry() -> pint.UnitRegistry[float]:
    """Return the one pint registry, loaded at first use."""
    import pint

    return pint.UnitRegistry()
