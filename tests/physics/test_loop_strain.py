"""Strain at a loop belongs to the fabric: not to lattice lines, not to the portion that is modelled."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.solve.path import advance
from loadcases.build import build, settings
from loadcases.reader import load_case
from wires.strain import wire_strains


QUICK = ("motion.total=25", "motion.steps=4")


def apex_strains(*overrides: str) -> dict[float, float]:
    """Return the span strain of the loops nearest to the apex by weft place."""
    case = load_case("punch", overrides=[*QUICK, *overrides]).case
    built = build(case)
    assert built.wires is not None
    *_, last = advance(built.model, settings(case))
    layout = built.wires.layout
    strain = wire_strains(built.wires, built.model, last)["span_strain"]
    near = (np.abs(layout.loop_warp_mm) < 3.0) & (np.abs(layout.loop_weft_mm - 9.0) < 10.0)
    return {round(float(layout.loop_weft_mm[k]), 2): float(strain[k]) for k in np.flatnonzero(near)}


@pytest.fixture(scope="module")
def quarter() -> dict[float, float]:
    return apex_strains()


def test_quarter_and_whole_find_the_same_strain(quarter: dict[float, float]) -> None:
    assert apex_strains("fabric.portion=whole") == pytest.approx(quarter, abs=2e-4)


@pytest.mark.parametrize("offset", [-1.0, 2.8])
def test_place_of_the_lattice_lines_does_not_matter(offset: float, quarter: dict[float, float]) -> None:
    assert apex_strains("fabric.portion=whole", f"wires.loops.offset={offset}") == pytest.approx(quarter, abs=5e-4)


def test_refining_the_lattice_changes_the_strain_by_less_than_a_hundredth(quarter: dict[float, float]) -> None:
    assert apex_strains("fabric.coarsening=9.75") == pytest.approx(quarter, abs=0.01)


@pytest.mark.parametrize("coarsening", [40.0, 25.0])
def test_a_part_in_a_loop_never_relieves_it_however_coarse_the_lattice(coarsening: float) -> None:
    """What the span of 4 mm grows by goes into 3.5 mm of free wire instead of 4.

    Over a bent elbow a chord cuts the kinks of a coarse lattice and would lose more than the part takes.
    """
    found = []
    for part in (0.0, 0.5):
        bent = ["motion.total=25", "motion.steps=3", f"fabric.coarsening={coarsening}", f"wires.loops.component={part}"]
        case = load_case("elbow", overrides=bent).case
        built = build(case)
        assert built.wires is not None
        *_, last = advance(built.model, settings(case))
        found.append(wire_strains(built.wires, built.model, last)["wire_strain"])
    empty, filled = found
    taut = empty > 0.01
    assert taut.any()
    expected = (4.08 * (1.0 + empty[taut]) - 0.5) / (4.08 - 0.5) - 1.0
    assert filled[taut] == pytest.approx(expected, rel=0.02)
