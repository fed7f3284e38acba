"""Measured channels: arrays with the right columns, and one message with its line for each kind of bad file."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from etextile.diagnose.data.measured import STATES, read_clamp_line, read_free_edge, read_strain_field, read_wires
from etextile.diagnose.data.punched import PunchForce, read_punch_force
from etextile.diagnose.data.specimens import odd_specimens
from etextile.errors import BadInput


FORCE = ["displacement_mm,force_N", *(f"{d},{0.4 * d**2:.3f}" for d in range(0, 30, 2))]
EDGE = [
    "displacement_mm,warp0_mm,warp_mm,weft_mm,height_mm",
    *(f"{d},{w},{1.01 * w},{50 - 0.1 * d},{0.2 * d}" for d in (0, 10, 20) for w in (0, 20, 40)),
]
FIELD = [
    "displacement_mm,warp0_mm,weft0_mm,strain_warp,strain_weft",
    *(f"{d},{w},{t},{0.004 * d},{-0.001 * d}" for d in (10, 20) for w in (0, 20) for t in (0, 20)),
]
SLIP = ["displacement_mm,weft0_mm,slip_mm", *(f"{d},{t},{0.01 * d}" for d in (0, 20, 40) for t in (0, 25, 50))]
WIRES = [
    "displacement_mm,wire,warp0_mm,state",
    "20,0,0,intact", "20,1,0,plastic", "40,0,0,partial", "40,1,0,plastic", "52.5,0,0,open",
]  # fmt: skip


def write(folder: Path, lines: list[str]) -> Path:
    path = folder / "channel.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def with_row(lines: list[str], line: int, row: str) -> list[str]:
    """Replace the row that stands in `line` of the file."""
    return [*lines[: line - 1], row, *lines[line:]]


def test_punch_force_keeps_its_noise(tmp_path: Path) -> None:
    found = read_punch_force(write(tmp_path, FORCE), noise=2.0)
    np.testing.assert_array_equal(found.displacement, np.arange(0.0, 30.0, 2.0))
    assert found.force[5] == pytest.approx(40.0)
    assert found.noise == 2.0


def test_free_edge_columns_are_current_positions(tmp_path: Path) -> None:
    found = read_free_edge(write(tmp_path, EDGE), noise=0.2)
    assert (found.warp0[-1], found.warp[-1], found.weft[-1], found.height[-1]) == pytest.approx((40.0, 40.4, 48.0, 4.0))


def test_strain_field_clamp_line_and_wires(tmp_path: Path) -> None:
    field = read_strain_field(write(tmp_path, FIELD))
    assert (field.strain_warp[-1], field.strain_weft[-1]) == pytest.approx((0.08, -0.02))
    assert read_clamp_line(write(tmp_path, SLIP)).slip[-1] == pytest.approx(0.4)
    wires = read_wires(write(tmp_path, WIRES))
    assert [STATES[state] for state in wires.state] == ["intact", "plastic", "partial", "plastic", "open"]
    assert wires.wire.tolist() == [0, 1, 0, 1, 0]


BAD: dict[str, tuple[Callable[..., object], list[str], int, str]] = {
    "missing column": (read_punch_force, ["displacement_mm,time_s", *FORCE[1:]], 1, "missing column 'force_N'"),
    "text": (read_punch_force, with_row(FORCE, 5, "6,high"), 5, "text in a column of numbers"),
    "empty": (read_punch_force, [], 1, "empty file"),
    "one point": (read_punch_force, FORCE[:2], 2, "only 1 point"),
    "falling": (read_punch_force, with_row(FORCE, 6, "3,5"), 6, "falls from 6 to 3"),
    "repeated": (read_punch_force, with_row(FORCE, 6, "6,50"), 6, "repeats 6 with another force"),
    "kN": (read_punch_force, [FORCE[0], *(f"{d},{4e-4 * d}" for d in range(8))], 9, "kN? convert to N"),
    "tension": (
        read_punch_force,
        [FORCE[0], *(f"{d},{-0.4 * d**2}" for d in range(8))],
        9,
        "positive against the punch",
    ),
    "m": (read_punch_force, [FORCE[0], *(f"{d / 1000},{d}" for d in range(8))], 9, "m? convert to mm"),
    "um": (read_punch_force, [FORCE[0], *(f"{d * 1000},{d}" for d in range(8))], 9, "um? convert to mm"),
    "late datum": (read_punch_force, with_row(FORCE, 2, "-30,0"), 2, "set it to 0 where contact starts"),
    "edge in m": (read_free_edge, [EDGE[0], *(f"{d / 1000},0,0,50,0" for d in range(8))], 9, "m? convert to mm"),
    "slip in m": (read_clamp_line, [SLIP[0], *(f"{d / 1000},0,0" for d in range(8))], 9, "m? convert to mm"),
    "field in m": (read_strain_field, [FIELD[0], *(f"{d / 1000},0,0,0,0" for d in range(8))], 9, "m? convert to mm"),
    "wires in m": (read_wires, [WIRES[0], "0.02,0,0,intact", "0.04,0,0,open"], 3, "m? convert to mm"),
    "downwards": (
        read_free_edge,
        [EDGE[0], *(f"{d},0,0,49,{-0.2 * d}" for d in range(0, 40, 5))],
        9,
        "change the sign",
    ),
    "edge twice": (read_free_edge, with_row(EDGE, 6, "10,0,0,50,2"), 6, "measured twice at displacement 10"),
    "edge disorder": (read_free_edge, with_row(EDGE, 8, "5,0,0,50,2"), 8, "ordered by displacement"),
    "percent": (read_strain_field, with_row(FIELD, 4, "10,20,0,4.1,-1"), 4, "percent?"),
    "impossible": (read_strain_field, with_row(FIELD, 4, "10,20,0,0.1,-1.2"), 4, "stays above -1"),
    "slip in um": (read_clamp_line, with_row(SLIP, 9, "40,25,4000"), 9, "um? convert to mm"),
    "unknown state": (
        read_wires,
        with_row(WIRES, 3, "20,1,0,broken"),
        3,
        "must be one of intact, plastic, partial, open",
    ),
    "healing": (read_wires, with_row(WIRES, 5, "40,1,0,intact"), 5, "intact after plastic at wire 1"),
    "half a wire": (read_wires, with_row(WIRES, 3, "20,1.5,0,plastic"), 3, "not a whole number"),
}


@pytest.mark.parametrize("kind", BAD)
def test_a_bad_channel_gets_one_message_with_its_line(tmp_path: Path, kind: str) -> None:
    reader, lines, line, message = BAD[kind]
    path = write(tmp_path, lines)
    with pytest.raises(BadInput) as caught:
        reader(path)
    (problem,) = caught.value.problems
    assert (problem.file, problem.line) == (str(path), line)
    assert message in problem.message


def specimen(name: str, *, force: float = 1.0, length: float = 1.0, end: int = 40) -> PunchForce:
    """A cubic record of one row per mm in other units, its first row in line 2."""
    travel = np.arange(1.0, end + 1.0)
    return PunchForce(name, length * travel, force * 0.02 * travel**3, lines=tuple(range(2, end + 2)))


@pytest.mark.parametrize(
    ("odd", "line", "key", "words"),
    [
        ({"force": 1e-3}, 41, "force_N", "peaks at 1.28, the median of the specimens at 1280; kN? convert to N"),
        ({"force": 102.0}, 41, "force_N", "mN? gf? convert to N"),
        ({"length": 0.1}, 41, "displacement_mm", "ends at 4, the median of the specimens at 40; m? cm? convert to mm"),
        ({"length": 1e3}, 41, "displacement_mm", "um? convert to mm"),
    ],
)
def test_one_specimen_in_another_unit_is_named(odd: dict[str, float], line: int, key: str, words: str) -> None:
    (problem,) = odd_specimens([specimen("1"), specimen("2", **odd), specimen("3")])  # type: ignore[arg-type]
    assert (problem.file, problem.line, problem.key) == ("2", line, key)
    assert words in problem.message


def test_of_two_specimens_both_are_named() -> None:
    (problem,) = odd_specimens([specimen("1", force=1e-3), specimen("2")])
    assert (problem.file, problem.line) == ("2", 41)
    assert "peaks at 1280, 1 at 1.28; one of the two is in another unit, convert to N" in problem.message


def test_a_specimen_that_gave_way_early_is_none_of_another_unit() -> None:
    """At half the displacement it carries an eighth of the force, which is what the others carry there."""
    assert list(odd_specimens([specimen("1", end=20), specimen("2"), specimen("3", force=1.2)])) == []
    assert list(odd_specimens([specimen("1", end=20), specimen("2")])) == []
    assert list(odd_specimens([specimen("1")])) == []


def test_an_edge_may_dip_beside_the_punch(tmp_path: Path) -> None:
    """A stiff fabric lifts its edge in the middle and dips by half of that further out."""
    rows = [f"{d},{w},{w},49,{h * d:.3f}" for d in (10, 20, 30) for w, h in ((0, 0.2), (15, 0.05), (30, -0.1))]
    assert read_free_edge(write(tmp_path, [EDGE[0], *rows])).height.min() == -3.0


def logged(travel: np.ndarray, force: np.ndarray) -> list[str]:
    return ["displacement_mm,force_N", *(f"{d:.4f},{f:.4f}" for d, f in zip(travel, force, strict=True))]


TRAVEL = np.linspace(0.0, 40.0, 401)
CUBE = 0.02 * TRAVEL**3


def test_a_punch_record_with_jitter_is_put_in_order_and_keeps_its_curve(tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    seen = TRAVEL + rng.normal(0.0, 0.03, len(TRAVEL))
    found = read_punch_force(write(tmp_path, logged(seen, CUBE)))
    assert np.all(np.diff(found.displacement) > 0.0)
    assert np.abs(found.force - 0.02 * found.displacement**3).max() < 3.0 * 0.03 * 0.06 * 40.0**2
    assert any("jitters" in note for note in found.notes)


@pytest.mark.parametrize("back", [0.0, 35.0])
def test_the_unloading_of_a_punch_record_is_left_out_and_said(tmp_path: Path, back: float) -> None:
    down = np.linspace(39.8, back, 40)
    lines = logged(np.r_[TRAVEL, down], np.r_[CUBE, 0.3 * 0.02 * down**3])
    found = read_punch_force(write(tmp_path, lines))
    np.testing.assert_allclose(found.displacement, TRAVEL, atol=1e-4)
    np.testing.assert_allclose(found.force, CUBE, atol=1e-4)
    assert found.notes == (
        "40 rows of unloading and reloading from line 402 on (displacement 40 mm) left out: the case only loads",
    )


def test_forces_that_relax_while_the_punch_is_held_are_left_out(tmp_path: Path) -> None:
    """At the top, where the way back follows, and on the way."""
    fall = 1.0 - 0.1 * (1.0 - np.exp(-np.linspace(0.5, 5.0, 80)))
    for at in (250, 400):
        travel = np.r_[TRAVEL[: at + 1], np.full(80, TRAVEL[at]), TRAVEL[at + 5 :]]
        found = read_punch_force(
            write(tmp_path, logged(travel, np.r_[CUBE[: at + 1], CUBE[at] * fall, CUBE[at + 5 :]]))
        )
        assert any(f"held at {TRAVEL[at]:g} mm" in note and "relaxed" in note for note in found.notes)
        assert np.abs(found.force - 0.02 * found.displacement**3).max() < 0.005 * CUBE[-1]


@pytest.mark.parametrize("after", [np.linspace(30.1, 40.0, 99), np.linspace(30.0, 0.0, 60)])
def test_what_follows_a_puncture_is_left_out_and_said(tmp_path: Path, after: np.ndarray) -> None:
    found = read_punch_force(write(tmp_path, logged(np.r_[TRAVEL[:301], after], np.r_[CUBE[:301], 0.0 * after + 9.0])))
    assert found.displacement[-1] == pytest.approx(30.0)
    assert "the specimen broke at 30 mm" in found.notes[0]


def test_a_single_reading_of_a_punch_far_from_its_neighbours_is_left_out(tmp_path: Path) -> None:
    for value in (0.0, 9e3):
        found = read_punch_force(write(tmp_path, logged(TRAVEL, np.where(np.arange(401) == 300, value, CUBE))))
        assert found.notes == ("a single reading far from the neighbours left out (line 302)",)
        np.testing.assert_allclose(found.force, np.delete(CUBE, 300), atol=1e-4)


def test_repeated_displacements_are_averaged_and_counted(tmp_path: Path) -> None:
    lines = logged(np.repeat(TRAVEL, 2), np.repeat(CUBE, 2) + np.tile([1.0, -1.0], len(CUBE)))
    found = read_punch_force(write(tmp_path, lines))
    np.testing.assert_allclose(found.force, CUBE, atol=1e-4)
    assert found.notes == ("401 rows repeat a displacement: forces averaged",)


def test_shuffled_rows_are_refused_with_one_message(tmp_path: Path) -> None:
    order = np.random.default_rng(8).permutation(len(TRAVEL))
    with pytest.raises(BadInput, match="rows must be ordered by displacement"):
        read_punch_force(write(tmp_path, logged(TRAVEL[order], CUBE[order])))


def test_points_without_a_reading_are_left_out_of_a_field_with_their_share(tmp_path: Path) -> None:
    found = read_strain_field(write(tmp_path, [FIELD[0], *FIELD[1:], "40,50,0,NaN,NaN", "40,60,0,,"]))
    assert len(found.displacement) == len(FIELD) - 1
    assert found.notes[0].startswith(f"2 of {len(FIELD) + 1} rows (")
