"""What a run leaves, to look into: report, tables of wires and loops, histories, arrays with units, maps."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from etextile.errors import BadInput
from etextile.results.layout import FILE_NAME
from etextile.results.reader import Results, open_results
from etextile.studies.run.drawing import draw_failure
from etextile.studies.run.judged import Judged, judged
from etextile.studies.table import Table
from etextile.visible import visible_data
from wires.axis import axis_of
from wires.report_files import curve_columns, curve_rows, loop_columns, loop_rows
from wires.seal import SEAL, broken


if TYPE_CHECKING:
    from pandas import DataFrame

REPORT = "report.json"


@dataclass(frozen=True)
class Run:
    """A run in its output folder.

    `exit_code`: 0 done, 3 no equilibrium (what converged is kept), 4 a trust limit was passed. `report`: as
    report.json. `results`: the result file, whose arrays are read when asked for. `remarks`: what could not be done.
    Tables are pandas frames where pandas is installed and `Table`s of arrays elsewhere; `tables` are always the latter.
    """

    exit_code: int
    folder: Path
    report: dict[str, Any] = field(repr=False)
    results: Results = field(repr=False)
    remarks: tuple[str, ...] = ()

    @property
    def reasons(self) -> list[str]:
        """Why the run is not to be trusted as it stands: where the path ended, else the limits that were passed."""
        if self.exit_code == 3:
            return [self.results.ending]
        return [item["sentence"] for item in self.report["trust"]["limits"]]

    @property
    def loops(self) -> DataFrame | Table:
        """One row per loop, columns as in wires.csv."""
        return self.tables["loops"].labelled()

    @property
    def wires(self) -> DataFrame | Table:
        """One row per wire."""
        return self.tables["wires"].labelled()

    @property
    def curves(self) -> DataFrame | Table:
        """One row per output step, columns as in force_displacement.csv (moment_angle.csv)."""
        return self.tables["curves"].labelled()

    @cached_property
    def tables(self) -> Mapping[str, Table]:
        """The tables `loops`, `wires` and `curves` as plain arrays."""
        rows = self.report["wires"]
        columns = [name for name, value in (rows[0] if rows else {}).items() if not isinstance(value, list | dict)]
        curves = curve_columns(self.report)
        return {
            "loops": Table.of_rows([row for row in loop_rows(self.report) if "loop" in row], loop_columns(self.report)),
            "wires": Table.of_rows(rows, columns),
            "curves": Table.of_rows([dict(zip(curves, row, strict=True)) for row in curve_rows(self.report)], curves),
        }  # fmt: skip

    def loop(self, wire: int, loop: int) -> DataFrame | Table:
        """Return what a loop went through, flat fabric first, numbers as in `loops`; raises BadInput for another one.

        Columns: displacement_mm (angle_deg of a joint, below 0 mm to go while the piece is put on), span_strain (fabric
        under the loop), wire_strain (free wire, slack taken up), and filaments_broken as a share.
        """
        damage = self._judged.damage
        if damage is None or self.results.wires is None:
            raise BadInput.of("the case has no wires", file=str(self.folder))
        history, layout = self.results.wires, damage.layout
        found = np.flatnonzero((layout.loop_wire == wire) & (layout.loop_index == loop))
        if not len(found):
            raise BadInput.of(f"no loop {loop} on a wire {wire}, there are {layout.n_loops}: see `loops`")
        at = int(found[0])
        columns = {
            axis_of(self.report).key: history.displacement_mm,
            "span_strain": history.span_strain[:, at],
            "wire_strain": history.wire_strain[:, at],
            "filaments_broken": damage.filaments_broken[:, at],
        }
        return Table(columns).labelled()

    def array(self, name: str, step: int = -1) -> Any:
        """Return a field of the result file at an output step; `unit(name)` says in what unit."""
        return self.results.array(name, step)

    def unit(self, name: str) -> str:
        """Return the unit of a field; raises BadInput that lists the fields for another name."""
        return self.results.unit(name)

    def failure_map(self, path: str | Path, step: int = -1, *, flat: bool = False) -> Path:
        """Draw the state of every loop at an output step into a .png and return its path.

        `flat`: on the flat fabric, which needs no OpenGL. Raises BadInput for a step or a suffix that is none, and
        NoGraphics with the remedy where nothing deformed can be drawn.
        """
        found = self._judged
        return draw_failure(
            self.results,
            Path(path),
            damage=found.damage,
            title=found.case.title,
            provisional=self.report["verdict"]["withheld"],
            step=step,
            flat=flat,
        )

    @cached_property
    def _judged(self) -> Judged:
        return judged(self.results)


def open_run(folder: str | Path) -> Run:
    """Open the output folder of a run; raises BadInput that says what is missing in it and what to do."""
    place = Path(folder)
    report = read_report(place)
    results = open_results(place)
    with as_written(place / REPORT):
        code = 3 if not results.completed else 0 if report["trust"]["ok"] else 4
    return Run(code, place, report, results)


def read_report(folder: Path) -> dict[str, Any]:
    """Return report.json of an output folder without its seal; raises BadInput: missing, changed, of other results."""
    path = existing(folder, REPORT)
    try:
        found: dict[str, Any] = visible_data(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, RecursionError) as error:
        raise BadInput.of(f"not a report, the file is damaged ({error}), run the case again", file=str(path)) from error
    if not isinstance(found, dict):
        raise BadInput.of("not a report, the file is damaged (no mapping), run the case again", file=str(path))
    if why := unfit(folder):
        raise BadInput.of(f"{why}; without this file `report` makes it again from the result file", file=str(path))
    return {key: value for key, value in found.items() if key != SEAL}


def unfit(folder: Path) -> str:
    """Say why the report of a folder is not to be relied on: changed, or of other results than those beside it.

    '' for one that is as the run wrote it, and where there is none.
    """
    path = folder / REPORT
    if not path.is_file():
        return ""
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError):
        return "it is damaged"
    if not isinstance(found, dict) or broken(found):
        return "it was changed after the run wrote it"
    named = found.get("results_sha256")
    return "it is of other results than those beside it" if named and _others(folder, str(named)) else ""


def _others(folder: Path, named: str) -> bool:
    """Tell whether a folder holds results that can be read and are not those named."""
    try:
        return (folder / FILE_NAME).is_file() and open_results(folder).fingerprint != named
    except BadInput:
        return False


def is_withheld(folder: Path) -> bool:
    """Tell whether the report in a folder withholds its verdict; False where there is none to be relied on."""
    if not (folder / REPORT).is_file() or unfit(folder):
        return False
    with as_written(folder / REPORT):
        return bool(read_report(folder)["verdict"]["withheld"])


@contextmanager
def as_written(path: Path) -> Iterator[None]:
    """Take it for a damaged report when what is read from it in this context is not there or of another type."""
    try:
        yield
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        what = " ".join(str(error).split())[:80]
        raise BadInput.of(f"not a report as a run writes it ({what}), run the case again", file=str(path)) from error


def existing(folder: Path, name: str) -> Path:
    """Return a file of an output folder; raises BadInput that says what is missing and what to do."""
    path = folder / name
    if path.is_file():
        return path
    if not folder.is_dir():
        what = "this is a file" if folder.is_file() else "no such folder"
        raise BadInput.of(f"{what}, give the output folder of a run", file=str(folder))
    if (folder / FILE_NAME).is_file():
        whole = _completed(folder)
        words = (
            "the run ended elsewhere and its result file came alone: copy the file too, or run the case again (map and "
            "report --measured need the result file alone)"
            if whole
            else "the run did not end, go on with run --resume"
        )
        raise BadInput.of(f"no {name} in it: {words}", file=str(folder))
    raise BadInput.of(f"no {name} in it: not the output folder of a run", file=str(folder))


def _completed(folder: Path) -> bool:
    """Tell whether the result file of a folder is that of a run that ended; False for one that cannot be read."""
    try:
        return open_results(folder).completed
    except BadInput:
        return False
