"""Compression ratios: one for all or one per family, by case or by fabric, and what is said against wrong ones."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.laws.powerlaw import PowerLaw, respond
from loadcases.build import build
from loadcases.compression import PerFamily, ratios
from loadcases.fabric import load_fabric
from loadcases.reader import dump_case, load_case


COARSE = ("fabric.coarsening=14", "motion.steps=1")


def built_ratios(*overrides: str, case: str = "tension_warp") -> tuple[float, ...]:
    model = build(load_case(case, overrides=[*COARSE, *overrides]).case).model
    return tuple(law.compression_ratio for law in model.lattice_block.laws)


def test_a_number_holds_for_all_families_and_a_mapping_for_each() -> None:
    assert ratios(0.1) == (0.1, 0.1, 0.1)
    assert ratios(PerFamily(warp=1.0, weft=0.5)) == (1.0, 0.5, 0.0)
    assert built_ratios() == (0.0, 0.0, 0.0)
    assert built_ratios("fabric.compression_ratio=0.1") == (0.1, 0.1, 0.1)
    assert built_ratios(case="bias_extension") == (1.0, 1.0, 0.0)
    assert built_ratios("fabric.compression_ratio.weft=0.3", case="bias_extension") == (1.0, 0.3, 0.0)


def test_the_larger_of_case_and_fabric_counts() -> None:
    assert {getattr(load_fabric("nylon_woven"), name).compression_ratio for name in ("warp", "weft", "diagonal")} == {
        1.0
    }
    nylon = ("fabric.set=nylon_woven", "fabric.coarsening=10")
    assert built_ratios(*nylon) == (1.0, 1.0, 1.0)
    assert built_ratios(*nylon, case="bias_extension") == (1.0, 1.0, 1.0)


def test_both_forms_are_written_back_as_they_were_read() -> None:
    for case in ("bias_extension", "tension_warp"):
        loaded = load_case(case)
        assert "compression_ratio" in dump_case(loaded.case)
    assert "diagonal: 0.0" in dump_case(load_case("bias_extension").case)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("2", r"compression_ratio: out of range \(got 2\), must be at least 0 and at most 1"),
        ("{warp: 1, wefft: 0.1}", r"compression_ratio\.wefft: unknown key, .*, did you mean 'weft'"),
        ("{diagonal: -1}", r"compression_ratio\.diagonal: out of range \(got -1\)"),
        ("[1, 1, 0]", "compression_ratio: not a number"),
        ("half", r"compression_ratio: text, not a number \(got 'half'\)"),
    ],
)  # fmt: skip
def test_wrong_ratios_get_one_clear_message(value: str, message: str) -> None:
    with pytest.raises(BadInput, match=message) as caught:
        load_case("bias_extension", overrides=[f"fabric.compression_ratio={value}"])
    assert len(caught.value.problems) == 1


def test_a_truss_that_starts_at_rest_has_a_finite_tangent_for_every_exponent() -> None:
    for n in (0.8, 1.0, 1.5):
        row = PowerLaw(1500.0, 0.2, 1550.0, n, compression_ratio=1.0).row()
        tau, slope, plastic = respond(row, 0.0, 0.0)
        assert (tau, plastic) == (0.0, 0.0)
        assert np.isfinite(slope)
        assert respond(row, -0.01, 0.0)[0] < 0.0
