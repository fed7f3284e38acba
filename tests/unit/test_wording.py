"""Numbers as they are read: no exponents, no false digits, a unit in which they have one to four figures."""

from __future__ import annotations

import pytest

from wires.wording import figures, quantity, spoken, unit_for


@pytest.mark.parametrize(
    ("value", "unit", "said"),
    [
        (422_800.0, "N mm", "423 N m"),
        (999.4, "N mm", "999 N mm"),
        (3773.11, "kPa", "3.77 MPa"),
        (6.12, "kPa", "6.12 kPa"),
        (-2500.0, "N mm", "-2.5 N m"),
        (1234.4, "N", "1234 N"),
        (123_456.0, "N", "123 kN"),
        (52.5, "mm", "52.5 mm"),
        (40_000.0, "mm", "40000 mm"),
        (0.0, "N", "0 N"),
        (None, "N", "- N"),
    ],
)
def test_a_quantity_has_the_unit_and_the_figures_it_is_read_with(value: float | None, unit: str, said: str) -> None:
    assert spoken(value, unit) == said
    assert " ".join(quantity(value, unit)) == said


def test_a_row_has_one_unit_that_of_its_largest_value() -> None:
    by, unit = unit_for([12.0, None, -4000.0], "N mm")
    assert (by, unit) == (1000.0, "N m")
    assert [figures(value / by, 4) for value in (12.0, -4000.0)] == ["0.012", "-4"]
    assert unit_for([], "kPa") == (1.0, "kPa")
