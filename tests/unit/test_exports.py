"""Exports with units in their cells or their header block, other scripts, repeated names, several specimens."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from etextile.errors import BadInput
from etextile.importers.labels import WORDS, means
from etextile.importers.table import FileTable, read_table


N = 24
TIME = 0.1 * np.arange(N)
MM = 0.25 * np.arange(N) + 0.0125
NEWTON = 3.0 * np.arange(N) ** 1.5 + 0.4325
WANTED = ("displacement_mm", "force_N")
Write = Callable[[float], str]


def rows(*columns: np.ndarray, mark: str = ",", write: Write | tuple[Write, ...] = "{:.4f}".format) -> str:
    each = write if isinstance(write, tuple) else (write,) * len(columns)
    lines = zip(*columns, strict=True)
    cells = ([way(float(value)) for way, value in zip(each, line, strict=True)] for line in lines)
    return "".join(f"{mark.join(line)}\n" for line in cells)


def comma(value: float) -> str:
    return f"{value:.4f}".replace(".", ",")


def german(text: str) -> str:
    return text.replace(",", ";").replace(".", ",")


def every(count: int, words: str, lines: str) -> str:
    return "".join((words if i % count == 0 else "") + f"{line}\n" for i, line in enumerate(lines.splitlines()))


WITH_UNITS = rows(MM, NEWTON, write=("{:.4f} mm".format, "{:.4f} N".format))
LABVIEW = (
    "LabVIEW Measurement\t\nSeparator\tTab\nX_Columns\tOne\nTime\t10:14:01.5\n***End_of_Header***\t\t\t\n\t\t\t\n"
    "Channels\t2\t\t\nSamples\t24\t24\t\nY_Unit_Label\tmm\tN\t\nX_Dimension\tTime\tTime\t\nX0\t0.0\t0.0\t\n"
    "Delta_X\t0.1\t0.1\t\n***End_of_Header***\t\t\t\nX_Value\tDisplacement\tForce\tComment\n"
)
READ: dict[str, tuple[str, str]] = {
    "units in every cell": (f"displacement,force\n{WITH_UNITS}", "utf-8"),
    "units in every cell, German": (f"Weg;Kraft\n{german(WITH_UNITS)}", "utf-8"),
    "units in cells and name": (f"displacement_mm,force_N\n{WITH_UNITS.replace(' ', '')}", "utf-8"),
    "units of LabVIEW": (LABVIEW + rows(TIME, MM, NEWTON, mark="\t").replace("\n", "\t\n"), "utf-8"),
    "units of LabVIEW, no comments": (LABVIEW + rows(TIME, MM, NEWTON, mark="\t"), "utf-8"),
    "units of LabVIEW, spelled": (
        LABVIEW.replace("mm\tN", "Millimeters\tNewtons") + rows(TIME, MM, NEWTON, mark="\t", write=comma), "utf-8",
    ),
    "MTS with counts": (
        "Acquisition\tTimed\n\nCount\tAxial Displacement\tAxial Force\nsegments\tmm\tkN\n"
        + rows(TIME, MM, NEWTON / 1000.0, mark="\t", write="{:.8f}".format), "utf-8",
    ),
    "names on every page": (every(8, "Weg [mm];Kraft [N]\n", rows(MM, NEWTON, mark=";", write=comma)), "utf-16"),
    "units again": ("Weg;Kraft\n" + every(9, "mm;N\n", rows(MM, NEWTON, mark=";", write=comma)), "cp1252"),
    "Chinese": ("时间,位移,力\n(s),(mm),(N)\n" + rows(TIME, MM, NEWTON), "gb18030"),
    "Chinese with wide brackets": ("时间（s）,位移（mm）,载荷（牛）\n" + rows(TIME, MM, NEWTON), "utf-8"),
    "Japanese": ('"試験力","変位(ストローク)"\n"N","mm"\n' + rows(NEWTON, MM), "shift_jis"),
    "Russian": ("Перемещение, мм;Нагрузка, Н\n" + rows(MM, NEWTON, mark=";", write=comma), "cp1251"),
    "French": ("Flèche (mm);Effort (daN)\n" + rows(MM, NEWTON / 10.0, mark=";", write="{:.6f}".format), "cp1252"),
    "compound words": ("Stempelweg in mm;Stempelkraft in N\n" + rows(MM, NEWTON, mark=";", write=comma), "utf-8"),
    "spelled units": ("Displacement (millimeters),Force (Newtons)\n" + rows(MM, NEWTON), "utf-8"),
    "Polish": ("Przemieszczenie [mm];Siła [N]\n" + rows(MM, NEWTON, mark=";", write=comma), "cp1250"),
    "Portuguese": ("Deslocamento (mm);Força (N)\n" + rows(MM, NEWTON, mark=";", write=comma), "utf-8"),
    "Swedish": ("Förskjutning (mm);Kraft (N)\n" + rows(MM, NEWTON, mark=";", write=comma), "utf-8"),
    "Turkish": ("Uzama (mm);Kuvvet (N)\n" + rows(MM, NEWTON, mark=";", write=comma), "utf-8"),
    "Korean": ("변위(mm),하중(N)\n" + rows(MM, NEWTON), "cp949"),
    "names in a comment of Matlab": ("% displacement_mm force_N\n" + rows(MM, NEWTON, mark=" "), "utf-8"),
    "words below the table": ("displacement_mm,force_N\n" + rows(MM, NEWTON) + "End of test\nMax,1359\n", "utf-8"),
    "a remark of the machine": (
        "displacement_mm,force_N\n" + rows(MM[:9], NEWTON[:9]) + "Hold 10 s\n" + rows(MM[9:], NEWTON[9:]), "utf-8",
    ),
    "a last line that was not written whole": ("displacement_mm,force_N\n" + rows(MM, NEWTON) + "6.2", "utf-8"),
    "zero bytes after a loss of power": ("displacement_mm,force_N\n" + rows(MM, NEWTON) + "\0" * 90, "utf-8"),
    "numbers that stand for none": ("displacement_mm,force_N\n" + rows(MM, NEWTON) + "6.3,-9999\n", "utf-8"),
    "words of C for none": (
        "displacement_mm,force_N\n" + rows(MM, NEWTON) + "6.3,-1.#IND\n6.4,1.#QNAN\n6.5,#N/A\n6.6,9.9E37\n", "utf-8",
    ),
    "points that were not correlated": (
        "displacement_mm,force_N,sigma\n" + rows(MM, NEWTON, 0.0 * MM + 0.01) + "0,0,-1\n" * 3, "utf-8",
    ),
    "formulas of a spreadsheet": ("displacement_mm,force_N\n" + rows(MM, NEWTON, write='="{:.4f}"'.format), "utf-8"),
}  # fmt: skip


def read(folder: Path, content: str, encoding: str = "utf-8") -> FileTable:
    path = folder / "export.csv"
    path.write_bytes(content.encode(encoding))
    return read_table(path, WANTED)


@pytest.mark.parametrize("kind", READ)
def test_an_export_reads_to_the_numbers_that_were_written(tmp_path: Path, kind: str) -> None:
    table = read(tmp_path, *READ[kind])
    np.testing.assert_allclose(table.numbers["displacement_mm"], MM, atol=1e-4)
    np.testing.assert_allclose(table.numbers["force_N"], NEWTON, atol=1e-4)


CELLS = WITH_UNITS.splitlines(keepends=True)
PLAIN = rows(MM, NEWTON).splitlines(keepends=True)
ASKED: dict[str, tuple[str, int, str]] = {
    "another unit in one cell": (
        "displacement,force\n" + "".join([*CELLS[:5], "1262.5 um,34 N\n", *CELLS[6:]]), 7,
        "the unit in the cell is 'um', most others of the column have 'mm'",
    ),
    "no unit in one cell": (
        "displacement,force\n" + "".join([*CELLS[:5], "1.2625,34 N\n", *CELLS[6:]]), 7, "there is no unit in the cell",
    ),
    "a unit in one cell": (
        "displacement_mm,force_N\n" + "".join([*PLAIN[:5], "1.2625 mm,34\n", *PLAIN[6:]]), 7,
        "a unit in the cell (got '1.2625 mm'), most others have none",
    ),
    "a name that contradicts": (f"displacement_cm,force_N\n{WITH_UNITS}", 2, "the name says 'cm', the cells 'mm'"),
    "two specimens, one below the other": (
        "Extension,Load\nmm,N\n" + "".join(PLAIN) + "Specimen 2\nExtension,Load\nmm,N\n" + "".join(PLAIN), N + 3,
        "another table with the same names begins here",
    ),
    "two specimens side by side": (
        "Weg;Kraft;Weg;Kraft\nmm;N;mm;N\n" + rows(MM, NEWTON, MM, NEWTON, mark=";", write=comma), 1,
        "columns of 2 specimens side by side; say which: --columns displacement_mm=1,force_N=2 or displacement_mm=3",
    ),
    "no numbers": ("displacement_mm,force_N\n'0.1,'0.2\n'0.2,'0.3\n", 3, "no row of numbers: line 3 holds"),
    "on its side": (
        "displacement_mm,0.1,0.2,0.3,0.4\nforce_N,1.1,1.2,1.3,1.4\n", 1, "the names stand at the start of the lines",
    ),
    "names for all columns but the first": (
        "displacement_mm force_N\n" + "".join(f'"{i}" 0.{i} {i}\n' for i in range(9)), 1, "3 columns under 2 names",
    ),
    "a mark that is said wrongly": ("sep=;\ndisplacement_mm,force_N\n" + "".join(PLAIN), 2, "says sep=; but its lines"),
    "another test behind a remark": (
        "displacement_mm,force_N\n" + "".join(PLAIN) + "Specimen 2\n" + "".join(PLAIN), N + 2, "another table begins",
    ),
    "a page with a remark before it": ("<!-- saved -->\n<html><body>Sign in</body></html>", 1, "a web page (HTML)"),
    "a pointer of git-annex": ("/annex/objects/SHA256E-s164--00.csv\n", 1, "git annex get"),
    "a link of git-annex": ("../.git/annex/objects/x/y/SHA256E-s12--00\n", 1, "git annex get"),
    "a shortcut": ("[InternetShortcut]\nURL=https://example.org/x.csv\n", 1, "a shortcut to a web address"),
    "a drawing": ('<svg xmlns="http://www.w3.org/2000/svg"></svg>', 1, "a drawing (SVG)"),
    "JSON": ('{"displacement_mm": [1, 2], "force_N": [1, 2]}', 1, "a JSON document"),
    "an error of a spreadsheet": (
        "displacement_mm,force_N\n" + "".join([*PLAIN[:5], "#DIV/0!,3\n", *PLAIN[5:]]), 7, "an error of a spreadsheet",
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", ASKED)
def test_what_cannot_be_read_gets_one_message_with_line_and_remedy(tmp_path: Path, kind: str) -> None:
    text, line, message = ASKED[kind]
    with pytest.raises(BadInput) as caught:
        read(tmp_path, text)
    (problem,) = caught.value.problems
    assert message in problem.message
    assert problem.line == line


@pytest.mark.parametrize(
    ("name", "quantities"),
    [
        ("Standardkraft", {"force"}), ("Vorkraft", set()), ("Traversenweg", {"displacement"}), ("应力", {"stress"}),
        ("力", {"force"}), ("位移速度", set()), ("Nenndehnung", {"strain"}), ("Elongation", {"displacement", "strain"}),
        ("Verlängerung", {"displacement"}), ("Максимальная нагрузка", set()), ("Strain rate", set()),
    ],
)  # fmt: skip
def test_a_name_means_what_its_language_says(name: str, quantities: set[str]) -> None:
    assert {quantity for quantity in WORDS if means(name, quantity)} == quantities
