"""The shipped case with wires from a drawing: its report reads like a product's."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from etextile.app.cli import main
from etextile.effects.registry import EFFECTS
from etextile.results.reader import open_results
from etextile.studies.run.outcome import Run
from etextile.studies.run.run import run
from etextile.text.run import report_text
from loadcases.reader import as_loaded, load_case
from loadcases.schema_parts import Effect


@pytest.fixture(scope="module")
def pad(tmp_path_factory: pytest.TempPathFactory) -> Run:
    folder = tmp_path_factory.mktemp("pad") / "out"
    quick = ["fabric.coarsening=40", "motion.total=30 mm", "motion.steps=6", "outputs.maps=[failure, wire_strain]"]
    return run(load_case("knee_pad", overrides=quick), folder)


def test_wires_nets_and_parts_go_by_name_in_every_file(pad: Run) -> None:
    assert pad.exit_code == 0
    data = json.loads((pad.folder / "report.json").read_text())
    assert [wire["name"] for wire in data["wires"]] == ["GND", "VCC", "LED", "SDA", "SCL", "SHD", "RTN"]
    assert [net["name"] for net in data["nets"]] == ["supply", "data", "return"]
    assert [part["name"] for part in data["parts"]] == ["J1", *(f"LED{k}" for k in range(1, 6)),
                                                        *(f"S{k}" for k in range(1, 6)), "C1"]  # fmt: skip
    with (pad.folder / "wires.csv").open() as file:
        assert {row["name"] for row in csv.DictReader(file)} == {wire["name"] for wire in data["wires"]}
    text, page = report_text(data), (pad.folder / "report.html").read_text()
    for name in ("GND", "RTN", "supply", "return", "J1", "LED3", "S5"):
        assert name in text
        assert name in page


def test_the_strain_at_a_land_is_that_of_a_wire_it_connects(pad: Run) -> None:
    wires = {wire["name"]: wire for wire in pad.report["wires"]}
    for part in pad.report["parts"]:
        assert part["worst_wire"] in part["wires"]
        most = [piece["max_strain"] for name in part["wires"] for piece in wires[name]["woven"]]
        assert 0.0 < part["max_strain"] <= max(most) + 1e-6
    assert {part["name"]: part["nets"] for part in pad.report["parts"]}["J1"] == ["supply", "data", "return"]


def test_a_return_with_a_way_round_has_less_resistance_than_its_one_side(pad: Run) -> None:
    """Two wires of 200 mm in parallel beside one: more than half of it, since one end lies on the return across."""
    nets = {net["name"]: net for net in pad.report["nets"]}
    for net in nets.values():
        assert net["state"] == "connected"
        assert 1.0 <= net["resistance_ratio"] < 1.2
        assert net["low"] <= net["loss_probability"] <= net["high"] < 0.5
    assert 0.5 < nets["return"]["resistance_before_ohm"] / nets["supply"]["resistance_before_ohm"] < 1.0


def test_maps_are_drawn_from_the_result_file_alone_with_lands_and_names(pad: Run, tmp_path: Path) -> None:
    parts = open_results(pad.folder).parts
    assert parts is not None
    assert parts.names[0] == "J1"
    assert parts.size_mm[0].tolist() == [8.0, 24.0]
    moved = tmp_path / "moved"
    moved.mkdir()
    (moved / "results.vtkhdf").write_bytes((pad.folder / "results.vtkhdf").read_bytes())
    (moved / "report.json").write_bytes((pad.folder / "report.json").read_bytes())
    assert main(["map", str(moved), "--field", "wire_strain", "--quiet"]) == 0
    assert (pad.folder / "maps" / "failure_flat.png").stat().st_size > 10_000


def test_the_drawing_of_the_pad_reads_back_to_itself(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["layout", "knee_pad", "-o", str(tmp_path / "pad.csv")]) == 0
    assert "7 wires, 48 loops, 12 parts" in capsys.readouterr().out


COARSE = ["fabric.coarsening=60", "motion.total=20 mm", "motion.steps=2", "outputs.maps=[]"]


def test_drawn_wires_that_slide_run_beside_lands(tmp_path: Path) -> None:
    """The solver's subdomains leave wires alone that they do not touch."""
    bond = "wires.bond={line_friction: 0.1, tension_factor: 0.1}"
    report = run(load_case("knee_pad", overrides=[*COARSE, bond]), tmp_path / "out").report
    assert report["solver"]["all_converged"]
    assert report["punch"]["force_N"][-1] == pytest.approx(14.0, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(EFFECTS))
def test_every_effect_works_on_drawn_wires_and_lands(name: str, tmp_path: Path) -> None:
    loaded = load_case("knee_pad", overrides=COARSE)
    card = EFFECTS[name].card
    effect = Effect(id=name, **card.example.parameters)
    with_effect = as_loaded(loaded.case.model_copy(update={"effects": (effect,)}))
    report = run(with_effect, tmp_path / "out").report
    assert report["solver"]["all_converged"]
    assert report["parts"][0]["name"] == "J1"
