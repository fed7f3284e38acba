"""Cases with an outline or a load: what is read, and what is refused with its remedy."""

from __future__ import annotations

from pathlib import Path

import pytest

from etextile.errors import BadInput
from loadcases.build import build, plan
from loadcases.reader import dump_case, load_case


CASE = """\
schema_version: 1
title: A bulge
fabric: {set: estimated_mid, coarsening: 30, outline: {circle: 39.9 mm}, portion: quarter}
supports: {clamped: [outline]}
motion: {target: pressure, total: 200 kPa, steps: 4}
"""


def read(folder: Path, old: str = "", new: str = "") -> object:
    assert old in CASE
    (folder / "case.yaml").write_text(CASE.replace(old, new) if old else CASE)
    return load_case(folder / "case.yaml").case


def test_a_circle_has_its_size_and_a_pressure_its_unit(tmp_path: Path) -> None:
    case = load_case(_written(tmp_path)).case
    assert case.fabric.size == pytest.approx((79.8, 79.8))
    assert case.motion.total == pytest.approx(2.0)
    assert case.motion.unit == "bar"
    (tmp_path / "again.yaml").write_text(dump_case(case))
    assert load_case(tmp_path / "again.yaml").case == case
    built = build(case)
    held = built.model.lattice.edges["outline"]
    assert held.any()
    assert built.model.fixed[held].all()
    assert plan(case)["nodes"] == len(built.model.points)


def _written(folder: Path) -> Path:
    (folder / "case.yaml").write_text(CASE)
    return folder / "case.yaml"


MISTAKES = {
    "not clamped": ("[outline]", "[x_min, x_max]", "write [outline]"),
    "outline beside an edge": ("[outline]", "[outline, x_min]", "write [outline] alone"),
    "wires": ("supports", "wires: {}\nsupports", "use wires: null"),
    "a body in the gas": ("supports", "body: {type: sphere, radius: 5}\nsupports", "use body: null"),
    "other size": ("circle: 39.9 mm}", "circle: 39.9 mm}, size: [80, 80]", "leave the size away"),
    "not convex": ("{circle: 39.9 mm}", "{polygon: [[-9, -9], [9, -9], [0, 0], [9, 9], [-9, 9]]}", "not a convex"),
    "not about the centre": ("{circle: 39.9 mm}", "{polygon: [[1, 1], [9, 1], [9, 9]]}", "shift the polygon"),
    "not symmetric": ("{circle: 39.9 mm}", "{polygon: [[-9, -9], [12, -9], [0, 12]]}", "set fabric.portion to whole"),
    "length for a pressure": ("200 kPa", "20 mm", "expected bar"),
    "turned quarter": ("portion: quarter", "portion: quarter, warp_angle: 20", "fabric.portion to whole"),
}


@pytest.mark.parametrize(("old", "new", "remedy"), MISTAKES.values(), ids=MISTAKES)
def test_what_does_not_fit_is_refused_with_its_remedy(old: str, new: str, remedy: str, tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"case\.yaml:") as found:
        read(tmp_path, old, new)
    assert remedy in str(found.value)


def test_a_rectangle_is_clamped_all_round_too(tmp_path: Path) -> None:
    read(tmp_path, "outline: {circle: 39.9 mm}", "size: [60, 60]")
    path = _written(tmp_path)
    path.write_text(CASE.replace("outline: {circle: 39.9 mm}", "size: [60, 60]").replace("[outline]", "[x_min, x_max]"))
    with pytest.raises(BadInput, match="clamped all round"):
        load_case(path)


@pytest.mark.parametrize("value", ["x", "[1, 2]", "3", "true", "[[0, 0], [1, 1]]"])
def test_an_outline_that_is_no_section_is_refused_where_it_stands(value: str) -> None:
    with pytest.raises(BadInput, match=r"fabric\.outline"):
        load_case("burst_7cm2", overrides=[f"fabric.outline={value}"])


@pytest.mark.parametrize(
    ("overrides", "hangs"),
    [
        ([], True), (["supports.clamped=[x_min, y_min]"], True), (["supports.clamped=[x_min, x_max]"], False),
        (["effects=[{id: shear_locking, angle: 30}]"], True),
    ],
)  # fmt: skip
def test_a_flap_without_bending_stiffness_is_no_case(overrides: list[str], hangs: bool) -> None:
    """A membrane held on one side has no equilibrium near the flat one; between opposite clamps it sags."""
    overrides = ["effects=[]", *overrides]
    if not hangs:
        assert load_case("cantilever_d1388", overrides=overrides).case.effects == ()
        return
    with pytest.raises(BadInput, match=r"motion\.target: .*effects: \[\{id: bending_stiffness"):
        load_case("cantilever_d1388", overrides=overrides)
