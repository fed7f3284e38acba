"""Drawn wires against the comb, mirror images and closed forms of fabrics that are deformed evenly."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.embedding import embedded

from etextile.errors import BadInput
from etextile.lattice.piece import divide, weave_piece
from etextile.lattice.weave import Weave
from etextile.laws.powerlaw import PowerLaw
from etextile.mechanics.model import Model
from etextile.mechanics.truss import TrussBlock
from etextile.results.wire_layout import ALONG_WARP, ALONG_WEFT, LAID
from etextile.solve.path import advance
from etextile.studies.run.run import run
from etextile.types import Array
from loadcases.build_paths import drawn_wires
from loadcases.build_wires import wire_layout
from loadcases.fabric import load_fabric
from loadcases.judging import judge_for
from loadcases.reader import load_case, read_case
from wires.drawn import LoopSpec, PathSpec
from wires.embed_slip import WeaveHold
from wires.layout import Portion
from wires.paths import lay_paths
from wires.strain import wire_strains


FABRIC = PowerLaw(3000.0, 0.2, 9960.0, 1.5)
COPPER = PowerLaw(1e5, 79.0, 600.0, 0.5)
SQUARE = Weave(0.2, 0.2, 0.35, 0.0155, 11.0, 11.0)
PUNCH = Weave(0.2849, 0.1603, 0.35, 0.0155, 11.0, 8.9)


def comb_as_paths(portion: Portion) -> str:
    """Return a case whose paths are the wires and loops of the comb, written out for the whole specimen."""
    case = load_case("punch", overrides=["fabric.portion=whole"]).case
    layout = wire_layout(case, load_fabric(case.fabric.set))
    assert layout is not None
    lines = ["schema_version: 1", "extends: punch", "title: Punch", "wires:", "  paths:"]
    for wire in range(layout.n_wires):
        loops = [repr(float(layout.loop_warp_mm[k])) for k in np.flatnonzero(layout.loop_wire == wire)]
        number = wire if portion == "whole" else wire - layout.n_wires // 2
        name = str(number) if number >= 0 else f"below {wire}"
        at = repr(float(layout.weft_mm[wire]))
        lines.append(f"    - {{name: '{name}', along: warp, at: {at}, loops: [{', '.join(loops)}]}}")
    return "\n".join(lines)


def report(text: str, folder: Path, *overrides: str) -> dict[str, Any]:
    quick = ["motion.total=15", "motion.steps=2", "outputs.maps=[]", "title=Punch", *overrides]
    path = folder / "case.yaml"
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    found = run(load_case(path, overrides=quick), folder / "out").report
    for key in ("wall_s", "solve_s"):
        found["solver"].pop(key)
    found["case"] = {"title": found["case"]["title"]}
    return found


@pytest.mark.parametrize("portion", ["quarter", "whole"])
def test_the_comb_written_as_paths_gives_the_same_report_to_the_last_digit(portion: Portion, tmp_path: Path) -> None:
    short = report("schema_version: 1\nextends: punch\n", tmp_path / "comb", f"fabric.portion={portion}")
    drawn = report(comb_as_paths(portion), tmp_path / "paths", f"fabric.portion={portion}")
    assert drawn["wires"]
    assert drawn == short


def moved(gradient: Array, specs: list[PathSpec], *, weave: Weave, coarsening: float, channel: WeaveHold | None) -> Any:
    """Return strains of perfectly bonded (None) or sliding wires in a square of 40 mm that is deformed evenly."""
    lattice = weave_piece(weave, divide(weave, (40.0, 40.0), coarsening, "whole"))
    trusses = TrussBlock.between_nodes(
        "lattice",
        lattice.trusses,
        length=lattice.rest_length,
        area=lattice.area,
        family=lattice.family,
        laws=(FABRIC, FABRIC, FABRIC),
    )
    carried = np.zeros_like(lattice.points)
    carried[:, :2] = lattice.points[:, :2] @ (gradient - np.eye(2)).T
    fixed = np.ones(lattice.points.shape, dtype=bool)
    steps = np.linspace(0.1, 1.0, 10)
    model = Model(lattice, lattice.points, fixed, carried, (trusses,), steps, np.array([1.0, 0.0, 0.0]))
    layout, _ = lay_paths(specs, length_mm=40.0, width_mm=40.0)
    model, wires = embedded(model, layout, COPPER, area_mm2=0.005, crimp=0.0, channel=channel)
    *_, last = advance(model)
    return wires, wire_strains(wires, model, last)


def test_a_wire_turned_from_warp_to_weft_sees_the_mirrored_strains() -> None:
    """Equal families, square cells: exchanging warp and weft exchanges the strains."""
    rng = np.random.default_rng(3)
    gradient = np.eye(2) + 0.05 * rng.normal(size=(2, 2))
    found = []
    for kind, turned in ((ALONG_WARP, gradient), (ALONG_WEFT, gradient[::-1, ::-1])):
        ends = ((-20.0, 3.3), (20.0, 3.3)) if kind == ALONG_WARP else ((3.3, -20.0), (3.3, 20.0))
        spec = PathSpec("a", kind, ends, (LoopSpec(-7.0, 4.0, 0.01), LoopSpec(5.5, 6.0, 0.0)))
        found.append(moved(turned, [spec], weave=SQUARE, coarsening=13.0, channel=None)[1])
    warp, weft = found
    assert np.ptp(warp["element_strain"]) < 1e-6
    for name in ("element_strain", "span_strain", "wire_strain"):
        assert weft[name] == pytest.approx(warp[name], abs=1e-9)


@pytest.mark.parametrize("coarsening", [5.0, 19.5, 40.0])
def test_a_line_at_45_degrees_under_trellis_shear_stretches_as_the_diagonal_of_a_rhombus(coarsening: float) -> None:
    """Yarns keep their length and turn by half the shear angle g each: stretch of the bisector sqrt(1 + sin g)."""
    shear = np.radians(10.0)
    c, s = np.cos(shear / 2), np.sin(shear / 2)
    line = PathSpec("d", LAID, ((-15.0, -15.0), (15.0, 15.0)))
    wires, found = moved(np.array([[c, s], [s, c]]), [line], weave=PUNCH, coarsening=coarsening, channel=None)
    assert wires.element_length_mm.sum() == pytest.approx(30.0 * np.sqrt(2.0))
    assert found["element_strain"] == pytest.approx(np.sqrt(1.0 + np.sin(shear)) - 1.0, rel=0.01)


def meander(pitch: float, amplitude: float) -> PathSpec:
    """Return a rectangular meander along the warp: half a pitch on either side, legs of the amplitude across."""
    points = [(-20.0, 0.0)]
    x, up = -20.0, False
    while x < 20.0 - 1e-9:
        y = amplitude if up else 0.0
        points.append((x + pitch / 2, y))
        if x + pitch / 2 < 20.0 - 1e-9:
            points.append((x + pitch / 2, 0.0 if up else amplitude))
        x, up = x + pitch / 2, not up
    return PathSpec("m", LAID, tuple(points))


@pytest.mark.parametrize("bond", ["perfect", pytest.param("free", marks=pytest.mark.slow)])
def test_a_meander_relieves_a_wire_that_is_free_to_slide_and_no_other(bond: str) -> None:
    """Fabric stretched by e along the warp alone. Length per pitch p + 2 a: an inextensible wire would need e p of
    feed there, so between held ends a free one takes e p / (p + 2 a); a bonded one has e wherever it runs along.

    The last leg is missing: 8 stretches of p / 2 and 7 legs of a.
    """
    strain, pitch, amplitude = 0.04, 10.0, 5.0
    free = WeaveHold(line_friction=0.0)
    gradient = np.diag([1.0 + strain, 1.0])
    spec = meander(pitch, amplitude)
    channel = None if bond == "perfect" else free
    _, found = moved(gradient, [spec], weave=PUNCH, coarsening=19.5, channel=channel)
    along, legs = 40.0, 7 * amplitude
    expected = strain if bond == "perfect" else strain * along / (along + legs)
    assert found["element_strain"].max() == pytest.approx(expected, rel=0.01)
    if bond == "free":
        assert np.ptp(found["element_strain"]) < 0.01 * expected


def test_a_drawing_that_is_no_mirror_image_is_refused_on_a_half_with_the_remedy() -> None:
    text = (
        "schema_version: 1\ntitle: x\nfabric: {set: estimated_mid, coarsening: 19.5, size: [100, 100], portion: half}"
    )
    text += "\nwires:\n  paths:\n    - {name: A, along: weft, at: 12}\nbody: {type: sphere, radius: 15}"
    text += "\nmotion: {total: 5, steps: 1}\n"
    case = read_case(text).case
    with pytest.raises(BadInput, match="mirror image too, or set fabric"):
        wire_layout(case, load_fabric(case.fabric.set))


def test_wires_of_different_filaments_are_each_judged_by_their_own_limit(tmp_path: Path) -> None:
    """One wire of 14 filaments of 0.05 mm among others: each comes out as in a run where all are of its make."""
    make = {"filaments": 14, "filament_diameter": 0.05, "material": "copper_drawn"}
    text = comb_as_paths("quarter")
    own = ", ".join(f"{key}: {value}" for key, value in make.items())
    (tmp_path / "mixed.yaml").write_text(text.replace("name: '0',", f"name: '0', {own},", 1))
    (tmp_path / "plain.yaml").write_text(text)
    quick = ["motion.total=20", "motion.steps=2", "outputs.maps=[]", "failure.criterion=calibrated"]
    done = run(load_case(tmp_path / "mixed.yaml", overrides=quick), tmp_path / "mixed")
    assert any("wires 0: 14 filaments of 0.05 mm copper_drawn" in note for note in done.report["notes"])
    history = done.results.wires
    all_thick = [f"wires.{key}={value}" for key, value in make.items()]
    damage = [
        judge_for(load_case(tmp_path / file, overrides=[*more, "failure.criterion=calibrated"]).case).judge(history)
        for file, more in (("mixed.yaml", []), ("plain.yaml", []), ("plain.yaml", all_thick))
    ]
    mixed, plain, thick = damage
    first = mixed.layout.names.index("0")
    of_first = mixed.layout.loop_wire == first
    for name in ("failure_probability", "open_probability", "first_failure_mm"):
        found = getattr(mixed, name)
        np.testing.assert_array_equal(found[~of_first], getattr(plain, name)[~of_first])
        np.testing.assert_array_equal(found[of_first], getattr(thick, name)[of_first])
    assert mixed.wire_failure_probability[first] == pytest.approx(thick.wire_failure_probability[first], rel=1e-9)
    assert np.abs(thick.failure_probability - plain.failure_probability)[of_first].max() > 0.01
    assert sorted(set(mixed.loop_filaments)) == [7.0, 14.0]


@pytest.mark.parametrize("criterion", ["calibrated", "filament_bundle", "wire_strain", "span_strain"])
def test_every_criterion_judges_a_mixture_of_makes(criterion: str, tmp_path: Path) -> None:
    text = comb_as_paths("quarter").replace("name: '0',", "name: '0', filaments: 19,", 1)
    (tmp_path / "case.yaml").write_text(f"{text}\nfailure: {{criterion: {criterion}}}\n")
    quick = ["motion.total=20", "motion.steps=1", "outputs.maps=[]"]
    report = run(load_case(tmp_path / "case.yaml", overrides=quick), tmp_path / "out").report
    assert report["failure"]["criterion"] == criterion
    assert all(0.0 <= wire["failure_probability"] <= 1.0 for wire in report["wires"])


def test_a_drawing_is_shifted_with_its_parts_and_a_wire_to_the_edge_stays_in_the_piece(tmp_path: Path) -> None:
    text = (
        "schema_version: 1\nextends: punch\ntitle: x\nfabric: {portion: whole}\nwires:\n  first_offset: 0.7\n  paths:\n"
        "    - {name: A, along: warp, at: 12, loops: [3]}\n    - {name: B, along: weft, at: 12, loops: [5]}\n"
        "    - {name: C, path: [[-20, -20], [-10, -25]], loops: [[-15, -22.5]]}\n"
        "  components: [{name: P, at: [30, 12]}]\n"
    )
    (tmp_path / "case.yaml").write_text(text)
    drawn = [
        drawn_wires(load_case(tmp_path / "case.yaml", overrides=more).case) for more in ([], ["wires.first_offset=0"])
    ]
    shifted, plain = (item.layout for item in drawn)
    assert shifted.loop_weft_mm == pytest.approx(plain.loop_weft_mm + 0.7)
    assert shifted.loop_warp_mm == pytest.approx(plain.loop_warp_mm)
    assert shifted.end_mm[1] == plain.end_mm[1] == -plain.start_mm[1]
    assert drawn[0].parts[0].at == pytest.approx((30.0, 12.7))
    assert drawn[0].terminals[0].along_mm == pytest.approx(drawn[1].terminals[0].along_mm)
