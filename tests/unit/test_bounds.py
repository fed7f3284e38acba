"""Sizes are bounded before anything is allocated, and files that never end are not opened."""

import os
from pathlib import Path

import numpy as np
import pytest

from etextile import files
from etextile.app.cli import main
from etextile.errors import BadInput
from loadcases import bounds
from loadcases.build import build, plan, travel_points
from loadcases.fabric import load_fabric
from loadcases.reader import load_case
from wires.layout import comb


DIGITS = "9" * 4300


@pytest.fixture
def no_allocation(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lattices and paths may not be made at all."""

    def made(*_: object, **__: object) -> None:
        raise AssertionError("something was allocated")

    for name in ("_lattice", "travel_points", "wire_layout"):
        monkeypatch.setattr(f"loadcases.build.{name}", made)


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ("fabric.size=[50 m, 50 m]", ["50000 x 50000 mm", "nodes", "GB", "coarsening"]),
        ("fabric.size=[1e300, 100]", ["1e+300", "GB"]),
        ("fabric.size=[1e300, 1e300]", ["1e+300", "GB"]),
        ("motion.total=1e9", ["1e+09 mm", "at most 300 mm", "3 times the longest side"]),
        ("body.radius=1e9", ["body.radius", "1e+09 mm", "100 times the longest side"]),
        ("body.radius=1e-9", ["body.radius", "1e-09 mm", "from 0.001 mm"]),
        ("contact.friction=1e9", ["1000000000", "up to 10"]),
        ("contact.max_penetration=1e9", ["at most 1 mm"]),
        ("wires.filament_diameter=1e9", ["at most 5 mm"]),
        ("motion.speed=1e9", ["at most 1e+06 mm/s"]),
        ("motion.speed=1e-9", ["at least 1e-06 mm/s"]),
        ("motion.total=1e-9", ["1e-09 mm, at least 0.001 mm"]),
        ("wires.first_offset=-1e9", ["1e+09 mm from the centre", "at most 100 mm (the longest side"]),
        ("wires.every_warp_yarns=1e9", ["mm apart", "at most 10000 mm (100 times the"]),
        ("wires.loops.spacing=1e9", ["1e+09 mm apart", "at most 10000 mm (100 times the"]),
        ("wires.loops.offset=1e9", ["1e+09 mm from the centre"]),
        ("wires.loops.length=1e-9", ["at least 0.01 mm"]),
        ("wires.bond={line_friction: 1e9}", ["at most 10000 N/mm"]),
        ("failure.onset=1e-9", ["at least 0.0001"]),
        ("contact.stick_stiffness=1e-9", ["at least 0.001 N/mm**3"]),
        ("body.rotation=[1e9, 0, 0]", ["at most 360 deg"]),
        ("motion.steps=1000000000", ["1000000000", "100000 or less"]),
        ("motion.steps=1e9", ["1000000000", "100000 or less"]),
        (f"motion.steps={DIGITS}", ["4300 digits", "at most 400"]),
        (f"title={DIGITS}", ["4300 digits", "at most 400"]),
        (f"body.radius='{DIGITS}'", ["not a finite number"]),
        ("wires.filaments=1000000000000", ["1000000000000", "10000 or less"]),
        (f"motion.path=[{', '.join(['52.5, 0'] * 3000 + ['52.5'])}]", ["steps", "100000"]),
        (f"fabric.set={'a' * 5000}.yaml", ["a path of 50", "at most 4095 and 255"]),
        (f"wires.material={'a/' * 2500}x.yaml", ["a path of 50", "at most 4095 and 255"]),
        (f"motion.history={'a' * 5000}.csv", ["a path of 50", "at most 4095 and 255"]),
    ],
)
@pytest.mark.usefixtures("no_allocation")
def test_what_is_too_large_is_refused_with_number_and_bound(
    option: str, words: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    for verb in (["check"], ["run", "-o", str(tmp_path / "out")]):
        assert main([verb[0], "punch", *verb[1:], "--set", option]) == 2
        said = capsys.readouterr().err
        assert all(word in said for word in words), said
        assert len(said) < 1200
        assert len(said.splitlines()) == 1
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["wires.loops.spacing=0.011", "wires.loops.length=0.01"], "loops each are too many"),
    ],
)
def test_loops_are_counted_before_they_are_laid_out(
    options: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", "punch", *[part for option in options for part in ("--set", option)]]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert "at most 100000" in said


def test_a_row_of_places_is_bounded_where_it_is_made() -> None:
    assert len(comb(0.0, 1.0, 10.0, key="x")) == 21
    with pytest.raises(BadInput, match="at most 100000"):
        comb(0.0, 1e-300, 1.0, key="x")


def test_memory_asked_is_set_against_what_the_machine_has(monkeypatch: pytest.MonkeyPatch) -> None:
    case = load_case("punch").case
    nodes = plan(case)["nodes"]
    seen = {}
    for had in (1e9, 1e5):
        monkeypatch.setattr(bounds, "memory_bytes", lambda had=had: had)
        seen[had] = bounds._too_much_memory(case, load_fabric(case.fabric.set))
    assert not seen[1e9]
    (problem,) = seen[1e5]
    counted = float(problem.message.split(" nodes")[0].split()[-1])
    assert counted == pytest.approx(nodes, rel=0.15)
    with pytest.raises(BadInput, match="may be asked for"):
        build(case)


@pytest.mark.parametrize("name", ["punch", "elbow", "elbow_sleeve", "burst_50cm2", "knee_pad"])
def test_steps_are_counted_as_they_are_made(name: str) -> None:
    case = load_case(name).case
    counted, made = bounds._steps(case), len(travel_points(case))
    stations = len(case.motion.path or (1,))
    assert abs(counted - made) <= 0.5 * stations + 1e-9


@pytest.mark.parametrize("kind", ["pipe", "device", "folder"])
def test_files_that_are_none_are_not_opened(tmp_path: Path, kind: str) -> None:
    path = Path("/dev/zero") if kind == "device" else tmp_path / kind
    if kind == "pipe":
        os.mkfifo(path)
    if kind == "folder":
        path.mkdir()
    with pytest.raises(BadInput, match="ordinary file"):
        files.read_bounded(path, 1000)


def test_a_file_beyond_its_bound_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "large.yaml"
    with path.open("wb") as file:
        file.truncate(10**12)
    with pytest.raises(BadInput, match="1000000000000 bytes are too many for such a file, at most 1000000"):
        load_case(path)


@pytest.mark.parametrize("text", ["x: " + "[" * 100_000 + "]" * 100_000, "a: {" * 100_000, "- [" * 300])
def test_deep_nesting_is_refused_without_parsing(tmp_path: Path, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "deep.yaml"
    path.write_text(text)
    monkeypatch.setattr("loadcases.yaml_text.YAML", None)
    with pytest.raises(BadInput, match="nested too deeply, at most 30"):
        load_case(path)


@pytest.mark.parametrize("verb", ["map", "report", "show", "life", "identify"])
def test_no_verb_falls_over_a_path_that_is_too_long(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([verb, "a" * 5000]) == 2
    said = capsys.readouterr().err
    assert "too long, at most 4095 and 255" in said
    assert len(said) < 600


def test_samples_are_bounded(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ensemble", "punch", "-n", "1000000000", "-o", str(tmp_path / "out")]) == 2
    assert "from 1 to 100000 samples can be run (got 1000000000)" in capsys.readouterr().err
    assert np.isfinite(bounds.memory_bytes())
