"""Strain of wires that slide, at the loops of the punch test: independent of the lattice and of the increments.

Loops of 5 % slack in wires of 2 % crimp at 0.1 N/mm: the loops are fed upon by the weave within some millimetres, so
that the wire's tension changes along less than a cell of the coarse lattice. Greatest changes at 25 mm, ten increments:
0.003 from coarsening 19.5 to 9.75, 0.001 on to 4.88, and 0.0015 from 9.75 to 2.44 (0.0014 at 0.01 N/mm, 0.0024 at 1
N/mm). From ten to twenty increments 0.004. With the shipped 2 % slack at 0.1 N/mm from 9.75 to 2.44: 0.001 at 25 mm,
0.003 at 40 mm, 0.008 at 50 mm and 0.012 at 52.5 mm, all at the apex, which is then strained by 0.70.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from etextile.solve.path import advance
from etextile.types import Array
from loadcases.build import build, settings
from loadcases.reader import load_case
from wires.strain import wire_strains


pytestmark = pytest.mark.slow

SLIDING = ("wires.bond={line_friction: 0.1}", "wires.loops.slack=5 %", "motion.total=25", "motion.steps=10")


@cache
def loop_strains(coarsening: float, *more: str) -> Array:
    """Return the wire strains (L,) of the loops of the quarter punch."""
    overrides = [*SLIDING, f"fabric.coarsening={coarsening}", *more]
    case = load_case("punch", overrides=overrides).case
    built = build(case)
    assert built.wires is not None
    *_, last = advance(built.model, settings(case))
    return wire_strains(built.wires, built.model, last)["wire_strain"]


def test_the_loops_are_strained_otherwise_than_where_the_bond_is_perfect() -> None:
    bonded = loop_strains(19.5, "wires.bond=perfect")
    assert (loop_strains(19.5) - bonded).max() > 0.015


@pytest.mark.parametrize(
    ("coarse", "fine", "slack"), [(19.5, 9.75, "5 %"), (9.75, 4.875, "5 %"), (9.75, 2.4375, "0 %")]
)
def test_refining_the_lattice_changes_them_by_less_than_a_hundredth(coarse: float, fine: float, slack: str) -> None:
    before, after = (loop_strains(coarsening, f"wires.loops.slack={slack}") for coarsening in (coarse, fine))
    assert np.abs(after - before).max() < 0.01
    assert after.max() > 0.09


def test_halving_the_increments_changes_them_by_less_than_a_hundredth() -> None:
    assert np.abs(loop_strains(19.5, "motion.steps=20") - loop_strains(19.5)).max() < 0.01
