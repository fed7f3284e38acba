"""Numbers with units at the edge."""

from __future__ import annotations

import math
import subprocess
import sys

import pint
import pytest
from hypothesis import given
from hypothesis import strategies as st

from etextile.units import to_number


PINT = pint.UnitRegistry()
UNITS = ("mm", "N", "MPa", "s", "deg", "1/s", "mm/s", "N/mm", "1/mm", "mm**2")
finite = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e12, max_value=1e12)


@pytest.mark.parametrize(
    ("text", "unit", "number"),
    [
        ("30 mm", "mm", 30.0),
        ("30mm", "mm", 30.0),
        ("3 cm", "mm", 30.0),
        ("0.35 GPa", "MPa", 350.0),
        ("8.3e-3 1/s", "1/s", 8.3e-3),
        ("0.5 /s", "1/s", 0.5),
        ("7 %", "", 0.07),
        ("5 mm/m", "", 0.005),
        ("3 N/mm2", "MPa", 3.0),
        ("3 N/mm^2", "MPa", 3.0),
        ("3 N/mm²", "MPa", 3.0),
        ("1 mm²", "mm**2", 1.0),
        ("-2 N/cm", "N/mm", -0.2),
        ("90 °", "deg", 90.0),
        (f"{math.pi} rad", "deg", 180.0),
        ("11000 1/m", "1/mm", 11.0),
        ("60 mm/min", "mm/s", 1.0),
        (" 12 ", "mm", 12.0),
        ("1e3", "N", 1000.0),
        (3, "mm", 3.0),
    ],
)
def test_text_with_a_unit_is_converted(text: str, unit: str, number: float) -> None:
    assert to_number(text, unit) == pytest.approx(number, rel=1e-14)


@given(finite, st.sampled_from(UNITS))
def test_the_wanted_unit_is_what_pint_gives(number: float, unit: str) -> None:
    assert to_number(f"{number!r} {unit}", unit) == PINT.Quantity(number, unit).to(unit).magnitude


@given(finite)
def test_percent_is_what_pint_gives(number: float) -> None:
    assert to_number(f"{number!r} %", "") == PINT.Quantity(number, "%").to("").magnitude


@given(finite, st.sampled_from(["mm", "cm", "m", "um", "inch"]))
def test_lengths_are_what_pint_gives(number: float, unit: str) -> None:
    assert to_number(f"{number!r} {unit}", "mm") == PINT.Quantity(number, unit).to("mm").magnitude


@given(finite, st.sampled_from(UNITS))
def test_plain_numbers_stay_as_they_are(number: float, unit: str) -> None:
    assert to_number(number, unit) == number
    assert to_number(repr(number), unit) == number


@pytest.mark.parametrize(
    ("value", "unit", "parts"),
    [
        ("30 kg", "mm", ("the unit does not fit", "'30 kg'", "a length in mm")),
        ("30 mm mm", "mm", ("the unit does not fit",)),
        ("30 deg", "", ("the unit does not fit", "a plain number or a share such as '7 %'")),
        ("30 %", "deg", ("the unit does not fit", "an angle in deg")),
        ("1 rad/s", "1/s", ("the unit does not fit",)),
        ("2 mpa", "MPa", ("unknown unit", "did you mean MPa?")),
        ("2 parsnips", "mm", ("unknown unit", "'2 parsnips'")),
        ("2 mm(", "mm", ("unknown unit",)),
        ("1,5 mm", "mm", ("decimal comma", "'1.5 mm'")),
        ("3 mm 4", "mm", ("not a number followed by a unit",)),
        ("3 ± 1 mm", "mm", ("not a number followed by a unit",)),
        ("1/2 mm", "mm", ("not a number followed by a unit",)),
        ("9**9 mm", "mm", ("not a number followed by a unit",)),
        ("thirty", "mm", ("text, not a number", "'thirty'")),
        ("", "mm", ("text, not a number",)),
        ("nan", "mm", ("text, not a number",)),
        (math.nan, "s", ("not a finite number", "a time in s")),
        (math.inf, "s", ("not a finite number",)),
        ("1e999 mm", "mm", ("not a finite number",)),
        (10**400, "mm", ("not a finite number",)),
        (True, "", ("not a number (got true)",)),
        (None, "N", ("not a number (got null)", "a force in N")),
        ([1], "N", ("not a number (got [1])",)),
    ],
)
def test_anything_else_is_refused_with_what_is_allowed(value: object, unit: str, parts: tuple[str, ...]) -> None:
    with pytest.raises(ValueError, match=r"expected|write a point") as refused:
        to_number(value, unit)  # type: ignore[arg-type]
    for part in parts:
        assert part in str(refused.value)


def test_long_values_are_shortened_in_messages() -> None:
    with pytest.raises(ValueError, match=r"\.\.\.\)") as refused:
        to_number("x" * 10_000, "mm")
    assert len(str(refused.value)) < 250


def test_pint_is_loaded_only_when_it_is_needed() -> None:
    code = (
        "import sys; from etextile.units import to_number\n"
        "assert to_number('30 mm', 'mm') + to_number(2, 'N') + to_number('7 %', '') > 0\n"
        "assert 'pint' not in sys.modules\n"
        "assert to_number('3 cm', 'mm') == 30 and 'pint' in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
