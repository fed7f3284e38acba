"""The coupons beside the law that a comparison simulates with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from etextile.studies.diagnose.compare import tensile_rows
from etextile.studies.diagnose.setting import assemble
from loadcases.measurements import load_measurements
from loadcases.reader import load_case
from loadcases.shipped import measured_folder


MEASURED = load_measurements(measured_folder("hidden_clamp"))


def gaps(*, own_fabric: bool) -> dict[str, float]:
    rows = tensile_rows(assemble(load_case("punch"), MEASURED, name_effects=False, own_fabric=own_fabric))
    assert [row["specimens"] for row in rows] == [3, 3, 3]
    return {row["direction"]: row["percent"] for row in rows}


def test_a_fabric_is_nearest_to_the_coupons_it_was_identified_from() -> None:
    """The coupons scatter by 1 %; the case's own fabric is another one."""
    identified, own = gaps(own_fabric=False), gaps(own_fabric=True)
    assert max(identified.values()) < 2.0
    assert all(identified[name] < own[name] for name in identified)


def test_coupons_that_carry_a_tenth_more_show_it() -> None:
    stiffer = {
        name: tuple(replace(curve, stress=1.1 * curve.stress) for curve in curves)
        for name, curves in MEASURED.tensile.items()
    }
    task = assemble(load_case("punch"), MEASURED, name_effects=False)
    rows = tensile_rows(replace(task, measured=replace(MEASURED, tensile=stiffer)))
    assert [row["percent"] for row in rows] == pytest.approx(np.full(3, 100.0 * 0.1 / 1.1), abs=1.0)
