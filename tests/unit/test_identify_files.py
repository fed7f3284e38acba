"""Tensile files: what is read, and the one message each kind of bad file gets, with its line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.identify.coupon import pull
from etextile.identify.curves import CouponSize, read_curve
from etextile.identify.segments import split
from etextile.laws.powerlaw import PowerLaw


STRAIN, STRESS = pull(PowerLaw(3000.0, 0.2, 9960.0, 1.5), 0.12, area_ratio=3.62, loading=30, unloading=12)
ROWS = [f"{e:.6f},{s:.5f}" for e, s in zip(STRAIN, STRESS, strict=True)]
HEADER = "strain,stress_MPa"


def write(folder: Path, lines: list[str]) -> Path:
    path = folder / "curve.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def scaled(strain: float, stress: float) -> list[str]:
    return [HEADER, *(f"{strain * e:.8f},{stress * s:.8f}" for e, s in zip(STRAIN, STRESS, strict=True))]


def test_a_curve_is_read_with_the_line_of_every_point(tmp_path: Path) -> None:
    curve = read_curve(write(tmp_path, ["# tested dry", HEADER, *ROWS]))
    np.testing.assert_allclose(curve.strain, STRAIN, atol=1e-6)
    np.testing.assert_allclose(curve.stress, STRESS, atol=1e-5)
    assert curve.lines[0] == 3
    assert curve.name == "curve"


@pytest.mark.parametrize("header", [True, False])
def test_force_and_displacement_become_stress_and_strain(tmp_path: Path, header: bool) -> None:
    size = CouponSize(width=29.0, thickness=0.35, gauge_length=60.0)
    rows = [f"{60.0 * e:.6f},{29.0 * 0.35 * s:.6f}" for e, s in zip(STRAIN, STRESS, strict=True)]
    names = ("displacement_mm", "force_N")
    path = write(tmp_path, [",".join(names), *rows] if header else rows)
    curve = read_curve(path, size=size, columns=() if header else names)
    np.testing.assert_allclose(curve.strain, STRAIN, atol=1e-6)
    np.testing.assert_allclose(curve.stress, STRESS, atol=1e-5)
    assert curve.thickness == 0.35


def test_columns_may_stand_in_any_order_beside_others(tmp_path: Path) -> None:
    rows = [f"{i},{row.split(',')[1]},{row.split(',')[0]}" for i, row in enumerate(ROWS)]
    curve = read_curve(write(tmp_path, ["time_s,stress_MPa,strain", *rows]))
    np.testing.assert_allclose(curve.strain, STRAIN, atol=1e-6)


BAD = {
    "missing column": (["strain,energy_J", *ROWS], 1, "missing column 'stress_MPa'"),
    "both missing": (["a,b", *ROWS], 1, "missing columns 'strain', 'stress_MPa'"),
    "column twice": (["strain,strain", *ROWS], 1, "given twice"),
    "no header": (ROWS, 1, "no header"),
    "text": ([HEADER, *ROWS[:5], "0.02,abc", *ROWS[6:]], 7, "text in a column of numbers (got 'abc')"),
    "infinite": ([HEADER, *ROWS[:7], "inf,3", *ROWS[8:]], 9, "not a finite number (got inf)"),
    "ragged row": ([HEADER, *ROWS[:4], "0.1,2,3", *ROWS[5:]], 6, "3 values for the 2 columns"),
    "empty": ([], 1, "empty file"),
    "header only": ([HEADER], 1, "no data"),
    "one point": ([HEADER, ROWS[3]], 2, "only 1 point"),
    "few points": ([HEADER, *ROWS[:6]], 7, "only 6 points"),
    "percent": (scaled(100.0, 1.0), 32, "percent?"),
    "tiny strain": (scaled(1e-3, 1.0), 32, "strain is a fraction"),
    "kPa": (scaled(1.0, 1e3), 32, "kPa, Pa or psi?"),
    "GPa": (scaled(1.0, 1e-3), 32, "GPa?"),
    "begins far along": (["strain,stress_MPa", *ROWS[::-1]], 2, "zero: first"),
    "sizes unknown": (["displacement_mm,force_N", *ROWS], 2, "width, thickness and gauge_length"),
}


@pytest.mark.parametrize("kind", BAD)
def test_a_bad_file_gets_one_message_with_its_line(tmp_path: Path, kind: str) -> None:
    lines, line, message = BAD[kind]
    path = write(tmp_path, lines)
    with pytest.raises(BadInput) as caught:
        read_curve(path)
    (problem,) = caught.value.problems
    assert (problem.file, problem.line) == (str(path), line)
    assert message in problem.message


DISORDER = {
    "two rows swapped": ([*ROWS[:10], ROWS[11], ROWS[10], *ROWS[12:]], 13),
    "a step back": ([*ROWS[:10], *ROWS[8:]], 12),
    "last row lower": ([*ROWS[:31], ROWS[29]], 33),
}


@pytest.mark.parametrize("kind", DISORDER)
def test_strain_that_falls_outside_of_unloading_is_refused(tmp_path: Path, kind: str) -> None:
    rows, line = DISORDER[kind]
    curve = read_curve(write(tmp_path, [HEADER, *rows]))
    with pytest.raises(BadInput, match="outside of an unloading") as caught:
        split(curve)
    assert caught.value.problems[0].line == line


def test_a_curve_that_only_falls_or_stands_still_is_refused(tmp_path: Path) -> None:
    for rows in (ROWS[:31][::-1], [f"0.01,{i}" for i in range(20)]):
        with pytest.raises(BadInput, match="rows in time order"):
            split(read_curve(write(tmp_path, [HEADER, *rows])))


def test_a_file_that_is_no_text_or_not_there_is_named(tmp_path: Path) -> None:
    binary = tmp_path / "binary.csv"
    binary.write_bytes(bytes(range(256)))
    with pytest.raises(BadInput, match="not a text file"):
        read_curve(binary)
    with pytest.raises(BadInput, match=r"no such file, did you mean 'binary\.csv'"):
        read_curve(tmp_path / "binari.csv")
