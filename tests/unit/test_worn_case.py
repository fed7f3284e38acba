"""Worn cases in files: what they say, what does not fit together, and how large the pieces are."""

from __future__ import annotations

import numpy as np
import pytest

from etextile.contact.joints import JOINTS, limb
from etextile.errors import BadInput, NoEquilibrium
from etextile.solve.path import advance
from loadcases.build import _weave, build, plan, settings, travel_points
from loadcases.build_wires import wire_layout
from loadcases.build_worn import put_on
from loadcases.fabric import load_fabric
from loadcases.reader import LoadedCase, dump_case, load_case, read_case


def sleeve(*overrides: str) -> LoadedCase:
    return load_case("elbow_sleeve", overrides=overrides)


def refused(*overrides: str, of: str = "elbow_sleeve") -> str:
    with pytest.raises(BadInput) as caught:
        load_case(of, overrides=overrides)
    return str(caught.value)


def test_the_girth_of_a_tube_follows_from_its_ease() -> None:
    case = sleeve("fabric.ease=10 %").case
    assert case.pattern == pytest.approx((240.0, 1.1 * JOINTS["elbow"].joint_girth))
    assert sleeve("fabric.ease=null", "fabric.size=[240, 230]").case.pattern == (240.0, 230.0)


def test_a_worn_case_survives_being_written_and_read() -> None:
    loaded = sleeve("motion.path=[120 deg, 0, 60]", "supports.ends=[band, free]")
    again = read_case(dump_case(loaded.case))
    assert again.case == loaded.case
    assert again.sha256 == loaded.sha256


def test_the_path_of_a_joint_is_in_degrees() -> None:
    case = sleeve("motion.path=[120, 0]").case
    assert travel_points(case)[[23, 47]] == pytest.approx([120.0, 0.0], abs=1e-9)
    assert "expected deg" in refused("motion.path=[120 mm]")
    assert "expected a length in mm" in refused("motion.path=[25 deg]", "motion.total=25", of="punch")


@pytest.mark.parametrize(
    ("override", "says"),
    [
        ("fabric.shape=flat", "a limb bends inside of a worn piece"),
        ("fabric.portion=quarter", "a joint bends in one plane only"),
        ("fabric.size=[240, 250]", "either from ease"),
        ("fabric.size=[400, null]", "longer than the limb"),
        ("fabric.warp_angle=10", "runs along the limb"),
        ("motion.total=30", "give flexion instead"),
        ("motion.flexion=null", "this key is missing"),
        ("supports.clamped=[x_min]", "supports.ends"),
        ("supports.sides=held", "only a panel has sides"),
        ("effects=[{id: bending_stiffness}]", "written for a flat piece"),
        ("body.upper_girth=900 mm", ""),
    ],
)
def test_what_does_not_fit_is_refused_with_the_remedy(override: str, says: str) -> None:
    if says:
        assert says in refused(override)
        return
    with pytest.raises(BadInput, match="widens or tapers too much"):
        plan(sleeve(override).case)


def test_keys_of_a_worn_piece_are_refused_on_a_flat_one() -> None:
    assert "only a tube" in refused("fabric.ease=5 %", of="punch")
    assert "only a worn piece" in refused("supports.ends=[free, free]", of="punch")
    assert "worn on it" in refused("motion.target=joint", "motion.flexion=90", "motion.total=null", of="punch")


def test_half_of_a_sleeve_has_its_wires_on_one_side_and_stands_for_all() -> None:
    fabric = load_fabric("estimated_mid")
    half, whole = (wire_layout(sleeve(f"fabric.portion={part}").case, fabric) for part in ("half", "whole"))
    assert half is not None
    assert whole is not None
    assert (half.weft_mm >= 0.0).all()
    assert half.wire_copies.sum() == whole.n_wires
    assert half.share[0] == 0.5  # on the plane of flexion
    assert half.loop_copies.max() == 1
    assert half.symmetric


def test_a_loose_sleeve_starts_on_its_limb_and_a_tight_one_around_a_thinner_one() -> None:
    weave = _weave(load_fabric("estimated_mid"))
    assert put_on(sleeve("fabric.ease=10 %").case, weave).donning == 0.0
    tight = put_on(sleeve("fabric.ease=-10 %").case, weave)
    radius = 251.0 / (2.0 * np.pi)
    assert tight.donning == pytest.approx(0.1 * 344.0 / (2.0 * np.pi), rel=0.2)
    assert tight.donning > 0.1 * radius


def test_the_tip_of_a_straight_arm_lies_in_its_groove_and_leads_when_bent() -> None:
    arm = limb("elbow")
    top = np.array([[0.0, 0.0, arm.joint_radius]])
    bent = limb("elbow").__class__(**{**vars(arm), "flexion": np.radians(120.0)})
    assert float(arm.distance(top).gap[0]) == pytest.approx(0.0, abs=0.3)
    assert float(bent.distance(top).gap[0]) == pytest.approx(-JOINTS["elbow"].tip_height, abs=1.0)


def test_a_path_that_ends_says_at_how_many_degrees() -> None:
    case = sleeve(
        "fabric.coarsening=78",
        "motion.flexion=40",
        "motion.steps=2",
        "solver.max_iterations=3",
        "solver.max_cut_backs=0",
    ).case
    with pytest.raises(NoEquilibrium, match=r"no equilibrium at \S+ deg after .* increment is at \S+ deg\."):
        list(advance(build(case).model, settings(case)))
