"""Tables as machines write them: one curve in every dialect reads to the same numbers, or a question is asked."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.identify.coupon import pull
from etextile.identify.curves import CouponSize, read_curve
from etextile.importers.labels import label_of
from etextile.importers.numerals import column_of, value_of
from etextile.importers.options import PLAIN, Options, Source
from etextile.importers.sheet import read_sheet
from etextile.importers.table import read_table, table_of
from etextile.laws.powerlaw import PowerLaw


SIZE = CouponSize(width=29.0, thickness=0.35, gauge_length=60.0)
STRAIN, STRESS = pull(PowerLaw(3000.0, 0.2, 9960.0, 1.5), 0.12, area_ratio=3.62, loading=60, unloading=20)
MM, NEWTON = 60.0 * STRAIN, 29.0 * 0.35 * STRESS
TIME = 0.1 * np.arange(len(STRAIN))


def rows(*columns: np.ndarray, mark: str = ",", write: Callable[[float], str] = "{:.6f}".format) -> str:
    return "".join(mark.join(write(float(value)) for value in line) + "\n" for line in zip(*columns, strict=True))


def comma(value: float) -> str:
    return f"{value:.6f}".replace(".", ",")


def thousands(group: str, decimal: str) -> Callable[[float], str]:
    swap = str.maketrans({",": group, ".": decimal})
    return lambda value: f"{value:,.4f}".translate(swap)


PLAIN_ROWS = rows(MM, NEWTON)
SEMICOLONS = rows(MM, NEWTON, mark=";", write=comma)
TIMED = rows(TIME, MM, NEWTON, mark=";", write=comma)
FRENCH = rows(MM, 1e3 * NEWTON, mark=";", write=thousands("\xa0", ","))
DATED = "".join(f"12.03.2020 10:14;{line}\n" for line in SEMICOLONS.splitlines())
TABS = rows(MM, NEWTON, mark="\t")
HEAD = "displacement_mm,force_N\n"
BLOCK = 'Specimen number (included),2\nLength,"60.00000",mm\nThickness,"0.35000",mm\nWidth,"29.00000",mm\n\n'
BLUEHILL = f"{BLOCK}Time,Extension,Load,Tensile strain (Strain 1)\n(s),(mm),(N),(%)\n" + rows(
    TIME, MM, NEWTON, 100.0 * STRAIN, write='"{:.5f}"'.format
)
DIALECTS: dict[str, tuple[bytes, str]] = {
    "plain": ((HEAD + PLAIN_ROWS).encode(), ""),
    "Instron block, units row, quotes": (BLUEHILL.encode(), "lines 1 to 4 before the table passed over, units in"),
    "semicolons, decimal commas, mark, CRLF": (
        ("displacement_mm;force_N\n" + SEMICOLONS).replace("\n", "\r\n").encode("utf-8-sig"),
        "UTF-8 with byte order mark, semicolon, decimal comma",
    ),
    "sep= line": (
        ("sep=;\ndisplacement_mm;force_N\n" + SEMICOLONS).encode(),
        "semicolon, decimal comma",
    ),
    "quoted sep= line behind a mark": (
        ('"sep=\t"\ndisplacement_mm\tforce_N\n' + rows(MM, NEWTON, mark="\t")).encode("utf-8-sig"),
        "tab, decimal point",
    ),
    "UTF-16 with tabs": (("displacement_mm\tforce_N\n" + rows(MM, NEWTON, mark="\t")).encode("utf-16"), "UTF-16, tab"),
    "UTF-16 big end first without mark": (
        ("displacement_mm;force_N\n" + SEMICOLONS).encode("utf-16-be"),
        "no byte order mark, taken as UTF-16-BE",
    ),
    "old Macintosh line ends": ((HEAD + PLAIN_ROWS).replace("\n", "\r").encode(), ""),
    "Latin-1 with umlauts": (
        ("Prüfzeit;Traversenweg;Standardkraft\ns;mm;N\n" + TIMED).encode("latin-1"),
        "byte 3 (0xfc, line 1) is not UTF-8",
    ),
    "aligned with spaces": (
        ("  displacement_mm    force_N\n" + rows(MM, NEWTON, mark="   ", write="{:12.6f}".format)).encode(),
        "spaces, decimal point",
    ),
    "quoted decimal commas": (
        (HEAD + rows(MM, NEWTON, write=lambda value: f'"{comma(value)}"')).encode(),
        "comma, decimal comma",
    ),
    "thousands, German": (
        ("Weg;Kraft\nmm;mN\n" + rows(MM, 1e3 * NEWTON, mark=";", write=thousands(".", ","))).encode(),
        "force_N from 'Kraft' in mN",
    ),
    "thousands, French": (
        ("Déplacement;Force\nmm;mN\n" + FRENCH).encode("cp1252"),
        "force_N from 'Force' in mN",
    ),
    "thousands, US, quoted": (
        ("Extension (mm),Load (mN)\n" + rows(MM, 1e3 * NEWTON, write=lambda value: f'"{value:,.4f}"')).encode(),
        "comma, decimal point",
    ),
    "other units in the names": (
        ("Displacement [in],Load [kN]\n" + rows(MM / 25.4, 1e-3 * NEWTON, write="{:.10f}".format)).encode(),
        "force_N from 'Load' in kN",
    ),
    "dates beside": (
        ("Datum;Weg [mm];Kraft [N]\n" + DATED).encode(),
        "semicolon, decimal comma",
    ),
    "a summary below the table": (
        (HEAD + PLAIN_ROWS + "\nMaximum force,405.5,N\nEnd of test\n").encode(),
        "after the table passed over",
    ),
    "a mark at every line's end": (
        ("displacement_mm;force_N\n" + SEMICOLONS.replace("\n", ";\n")).encode(),
        "semicolon, decimal comma",
    ),
    "numpy's commented names": (("# displacement_mm force_N\n" + rows(MM, NEWTON, mark=" ")).encode(), "spaces"),
    "a name over two lines": (
        ('"Extension\n(mm)","Load\n(N)"\n' + PLAIN_ROWS).encode(),
        "displacement_mm from 'Extension' in mm",
    ),
    "sentences above the table": (
        ("Speed: 60 mm/min\nDate: 12.03.2020 10:14\n\nDisplacement\tForce\nmm\tN\n" + TABS).encode(),
        "lines 1 to 2 before the table passed over",
    ),
}  # fmt: skip


def write(folder: Path, content: bytes | str) -> Path:
    path = folder / "export.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


@pytest.mark.parametrize("kind", DIALECTS)
def test_every_way_to_write_a_curve_reads_to_the_same_numbers_and_says_how(tmp_path: Path, kind: str) -> None:
    content, said = DIALECTS[kind]
    curve = read_curve(write(tmp_path, content), size=SIZE)
    np.testing.assert_allclose(curve.strain, STRAIN, atol=1e-6)
    np.testing.assert_allclose(curve.stress, STRESS, atol=1e-4)
    if said:
        assert said in curve.notes[0]
    else:
        assert curve.notes == ()


def test_strain_in_per_cent_beside_force_is_read_by_its_unit(tmp_path: Path) -> None:
    text = "Dehnung;Standardkraft\n%;N\n" + rows(100.0 * STRAIN, NEWTON, mark=";", write=comma)
    np.testing.assert_allclose(read_curve(write(tmp_path, text), size=SIZE).strain, STRAIN, atol=1e-6)


THREE_PLACES = "".join(f"{1.0 + 0.1 * i:.3f};{1.5 + i:.3f}\n" for i in range(20)).replace(".", ",")
ASKED: dict[str, tuple[str, int, str]] = {
    "three decimals or thousands": (
        f"displacement_mm;force_N\n{THREE_PLACES}",
        2,
        "decimal point gives 1000 and 1500; semicolon, decimal comma gives 1 and 1.5",
    ),
    "two displacements": (
        "Temps,Traverse absolue,Force standard,Course standard\ns,mm,N,mm\n" + rows(TIME, MM - 700.0, NEWTON, MM),
        1,
        "'Traverse absolue' in mm and 'Course standard' in mm may both be displacement_mm",
    ),
    "two specimens side by side": (
        "Extension,Load,Extension,Load\nmm,N,mm,N\n" + rows(MM, NEWTON, MM, NEWTON),
        1,
        "columns of 2 specimens side by side; say which: --columns displacement_mm=1,force_N=2 or displacement_mm=3",
    ),
    "no unit": ("Extension,force_N\n" + PLAIN_ROWS, 1, "column 'Extension' has no unit"),
    "strain in two ways that differ": (
        "Extension (mm),Load (N),Tensile strain (%)\n" + rows(MM, NEWTON, 150.0 * STRAIN),
        None,
        "two readings are possible: strain",
    ),
    "no names": (PLAIN_ROWS, 1, "no header"),
    "compression positive": (HEAD + rows(-MM, -NEWTON), None, "set sign: -1 (--sign -1)"),
    "absolute position": (HEAD + rows(MM - 700.0, NEWTON), 2, "set zero: first (--zero first)"),
}  # type: ignore[dict-item]


@pytest.mark.parametrize("kind", ASKED)
def test_two_readings_or_none_make_a_question_with_the_key_to_set(tmp_path: Path, kind: str) -> None:
    text, line, message = ASKED[kind]
    with pytest.raises(BadInput) as caught:
        read_curve(write(tmp_path, text), size=SIZE)
    (problem,) = caught.value.problems
    assert message in problem.message
    assert line is None or problem.line == line


ANSWERED: dict[str, tuple[str, Options]] = {
    "column by name": (
        ASKED["two displacements"][0],
        Options(sources={"displacement_mm": Source("Course standard"), "force_N": Source("Force standard")}),
    ),
    "absolute column, zero at its first reading": (
        ASKED["two displacements"][0],
        Options(sources={"displacement_mm": Source("Traverse absolue")}, zero={"displacement": "first"}),
    ),
    "column by number": (
        ASKED["two specimens side by side"][0],
        Options(sources={"displacement_mm": Source(3), "force_N": Source(4)}),
    ),
    "unit": (ASKED["no unit"][0], Options(sources={"displacement_mm": Source("Extension", "mm")})),
    "names": (PLAIN_ROWS, Options(names=("displacement_mm", "force_N"))),
    "names in other units": (rows(0.1 * MM, 1e3 * NEWTON), Options(names=("displacement_cm", "force_mN"))),
    "sign": (HEAD + rows(-MM, -NEWTON), Options(sign={"": -1})),
    "zero": (HEAD + rows(MM - 700.0, NEWTON), Options(zero={"": -700.0})),
    "lines to pass over": ("1,2\n3,4\n" + HEAD + PLAIN_ROWS, Options(skip_rows=2)),
}


@pytest.mark.parametrize("kind", ANSWERED)
def test_what_a_person_says_answers_the_question(tmp_path: Path, kind: str) -> None:
    text, options = ANSWERED[kind]
    curve = read_curve(write(tmp_path, text), size=SIZE, options=options)
    np.testing.assert_allclose(curve.strain, STRAIN, atol=1e-6)
    np.testing.assert_allclose(curve.stress, STRESS, atol=1e-4)


def test_the_decimal_mark_that_is_said_decides(tmp_path: Path) -> None:
    path = write(tmp_path, f"displacement_mm;force_N\n{THREE_PLACES}")
    for mark, first in ((",", 1.5), (".", 1500.0)):
        table = read_table(path, ("displacement_mm", "force_N"), options=Options(decimal=mark))
        assert table.numbers["force_N"][0] == first


LINES = PLAIN_ROWS.splitlines()
ARABIC = "".join(chr(0x660 + i) for i in range(10))


def with_row(row: str) -> str:
    return HEAD + "\n".join([*LINES[:30], row, *LINES[30:]]) + "\n"


HOSTILE: dict[str, tuple[bytes | str, int | None, str]] = {
    "a cell without end": (with_row('"' + "9" * 140_000 + '",5'), 32, "more than 131072 characters"),
    "a line without end": (with_row("9" * 300_000 + ",5"), 32, "no table of numbers"),
    "an open quote": (with_row('"1.2,5'), 32, "a quote that is not closed"),
    "NUL": (with_row("1\x00,5"), 32, "NUL characters"),
    "underscore": (with_row("1_000,5"), 32, "underscores in a number (got '1_000')"),
    "digits of another script": (with_row(f"{ARABIC[1:3]},5"), 32, "digits of another script"),
    "infinity": (with_row("inf,5"), 32, "not a finite number (got inf)"),
    "another decimal mark": (
        "displacement_mm;force_N\n" + "0.1;0.2\n0.2;0.3\n" + SEMICOLONS,
        2,
        "another decimal mark than in the rest of the file",
    ),
    "decimal commas between commas": (HEAD + rows(MM, NEWTON, write=comma), 2, "decimal commas between commas?"),
    "web page": (b"<!DOCTYPE html><html><body>404</body></html>", 1, "a web page (HTML)"),
    "LFS": (b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 5\n", 1, "pointer of Git LFS"),
    "workbook": (b"PK\x03\x04" + b"x" * 300, 1, "Excel workbook"),
    "zipped": (b"\x1f\x8b" + b"x" * 300, 1, "gzip"),
    "mostly missing": (HEAD + PLAIN_ROWS + "nan,nan\n" * 90, None, "too few are left"),
}  # fmt: skip


@pytest.mark.parametrize("kind", HOSTILE)
def test_what_is_no_table_of_numbers_gets_one_message_with_its_line(tmp_path: Path, kind: str) -> None:
    content, line, message = HOSTILE[kind]
    with pytest.raises(BadInput) as caught:
        read_curve(write(tmp_path, content), size=SIZE)
    (problem,) = caught.value.problems
    assert message in problem.message
    assert line is None or problem.line == line


def test_rows_without_a_reading_are_left_out_and_counted(tmp_path: Path) -> None:
    curve = read_curve(write(tmp_path, with_row("NaN,5\n,\n0.1,#N/A")), size=SIZE)
    np.testing.assert_allclose(curve.strain, STRAIN, atol=1e-6)
    assert curve.notes == ("3 of 84 rows (3.6%) have no reading of displacement_mm and force_N: left out",)


def test_an_encoding_that_is_said_wrongly_names_the_byte(tmp_path: Path) -> None:
    path = write(tmp_path, DIALECTS["Latin-1 with umlauts"][0])
    with pytest.raises(BadInput, match=r"is not utf-8: byte 3 \(0xfc\)"):
        read_curve(path, size=SIZE, options=Options(encoding="utf-8"))


def test_fifty_thousand_rows_are_read_whole(tmp_path: Path) -> None:
    """What the time does is measured in tests/benchmarks: a clock in a shared machine proves nothing here."""
    strain = np.linspace(0.0, 0.1, 50_000)
    path = write(tmp_path, "strain;stress_MPa\n" + rows(strain, 100.0 * strain, mark=";", write=comma))
    curve = read_curve(path, options=PLAIN)
    assert len(curve.strain) == 50_000
    np.testing.assert_allclose(curve.stress, 100.0 * curve.strain, rtol=1e-4, atol=1e-4)


@pytest.mark.parametrize(
    ("head", "name", "unit"),
    [
        ("Weg/mm", "Weg", "mm"), ("F/N", "F", "N"), ("Displacement mm", "Displacement", "mm"),
        ("Strain %", "Strain", "%"),
        ("Force 1", "Force 1", None), ("mm/mm", "mm/mm", None), ("Kraft N/mm", "Kraft N/mm", None),
        ("Zoom in", "Zoom in", None), ("Time (Sec)", "Time", "Sec"),
    ],
)  # fmt: skip
def test_a_unit_stands_behind_a_slash_or_as_the_last_word(head: str, name: str, unit: str | None) -> None:
    label = label_of(head)
    assert (label.name, label.unit) == (name, unit)


def test_fortran_exponents_are_numbers_and_labels_are_not() -> None:
    assert value_of("4.05D+01", ".") == 40.5
    assert value_of("1D2", ".") is None
    values, wrong = column_of(["1.0D+00", "2.5d-01"], ".")
    assert (values.tolist(), wrong) == ([1.0, 0.25], [])


RESULTS = '"Results"\n,"Maximum Load","Extension"\n,"(N)","(mm)"\n1,"350.1","40.0"\n\n"Raw Data"\n'
RAW = '"Time","Extension","Load"\n"(s)","(mm)","(N)"\n'


@pytest.mark.parametrize(("rows", "read"), [(30, True), (5, False)])
def test_a_table_of_results_before_a_long_table_is_passed_over(rows: int, read: bool, tmp_path: Path) -> None:
    """Where neither table is much longer than the other the file is asked about, not guessed."""
    path = tmp_path / "export.csv"
    path.write_text(RESULTS + RAW + "".join(f"{i},{0.5 * i},{7.0 * i}\n" for i in range(1, rows + 1)))
    sheet = read_sheet(path)
    if not read:
        with pytest.raises(BadInput):
            table_of(sheet, ("displacement_mm", "force_N"))
        return
    table = table_of(sheet, ("displacement_mm", "force_N"))
    assert table.numbers["force_N"].tolist() == [7.0 * i for i in range(1, rows + 1)]
    assert "lines 1 to 6 before the table passed over" in sheet.found
