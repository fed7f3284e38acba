"""A specimen mounted taut stretches the wires that were woven in before: strains multiply, in loops and weave."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.lattice.weave import WIRE
from etextile.solve.path import advance
from loadcases.build import build, settings
from loadcases.reader import load_case
from wires.strain import wire_strains


BOND = {"perfect": "perfect", "slipping": "{line_friction: 1000}"}


@pytest.mark.parametrize("bond", list(BOND))
def test_three_per_cent_on_mounting_and_five_and_a_half_after_are_eight_point_seven(bond: str) -> None:
    """A strip along the warp: 100 mm between clamps, pulled by 5.5 mm after it was mounted at 3 %."""
    case = load_case(
        "tension_warp",
        overrides=[
            "fabric.coarsening=60", "fabric.size=[100, 29]", "motion.total=5.5 mm", "motion.steps=2",
            f"wires.bond={BOND[bond]}", "effects=[{id: pretension, strain: 0.03}]",
        ],
    ).case  # fmt: skip
    built = build(case)
    assert built.wires is not None
    last = list(advance(built.model, settings(case)))[-1]
    found = wire_strains(built.wires, built.model, last)
    fabric = 1.03 * 1.055 - 1.0
    assert fabric == pytest.approx(0.08665)
    own = (1.0 + fabric) / 1.02 - 1.0
    assert found["span_strain"].mean() == pytest.approx(fabric, abs=5e-4)
    assert found["wire_strain"].mean() == pytest.approx(own, abs=5e-4)
    assert found["element_strain"].mean() == pytest.approx(own, abs=2e-3)
    if bond == "perfect":
        woven = np.concatenate([block.span for block in built.model.truss_blocks if block.family[0] == WIRE])
        taut = np.concatenate([found["element_strain"], found["wire_strain"]])
        assert woven.sum() * 1.03 == pytest.approx(100.0 * built.wires.layout.n_wires)
        assert (woven * 1.02 * (1.0 + taut)).sum() / woven.sum() == pytest.approx(
            1.0 + fabric, abs=3e-4
        )  # outer ones bow
