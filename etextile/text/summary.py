"""What any study leaves, or a case, in words of 80 columns: what its verb prints, as a text.

print(et.summary(et.run("punch", "out")))
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from importlib import import_module
from typing import TYPE_CHECKING, Any

from etextile.errors import BadInput
from etextile.text.columns import Columns


if TYPE_CHECKING:
    from etextile.studies.calibrate.study import Calibration
    from etextile.studies.diagnose.compare import Compared
    from etextile.studies.diagnose.run import DiagnosisOutcome
    from etextile.studies.ensemble.run import EnsembleOutcome
    from etextile.studies.identify.bias import BiasIdentification
    from etextile.studies.identify.found import Identification
    from etextile.studies.inspect import InspectedMesh, Inspection
    from etextile.studies.inspect_folder import InspectedFolder
    from etextile.studies.life import Study
    from etextile.studies.run.outcome import Run
    from etextile.studies.sizing import Sized
    from loadcases.reader import LoadedCase
    from wires.drawing import Drawing

Blocks = Iterable[str | Columns]


def summary(found: object, *, every: bool = False) -> str:
    """Return what a study found, or what a case would run, as text.

    `found`: what `et.load`, `et.run`, `et.open`, `et.identify`, `et.calibrate`, `et.compare`, `et.diagnose`,
    `et.ensemble`, `et.compare_designs`, `et.size_loops`, `et.inspect`, `et.inspect_folder`, `et.layout` or `et.life`
    returned. `every`: all rows of tables that are cut to the worst, all candidates, all defaults of a case. Raises
    BadInput for anything else.
    """
    return "\n".join(str(block) for block in blocks(found, every=every)).rstrip("\n")


def blocks(found: object, *, every: bool = False) -> Blocks:
    """Return the same as lines and tables, one after the other."""
    for kind in type(found).__mro__:
        words = WORDS.get(kind.__name__)
        if words is not None and kind.__module__.partition(".")[0] in ("etextile", "loadcases", "wires"):
            return words(found, every)
    raise BadInput.of(f"no summary of this (got {type(found).__name__}), give what a function of etextile returned")


def _of(module: str, name: str) -> Callable[..., Any]:
    """Return a function of this room, loaded when it is first used."""
    return getattr(import_module(f"etextile.text.{module}"), name)  # type: ignore[no-any-return]


def _case(found: LoadedCase, every: bool) -> Blocks:
    from loadcases.build import plan

    return [_of("case", "case_text")(found, plan(found.case), every=every)]


def _run(found: Run, every: bool) -> Blocks:
    return [_of("run", "report_text")(found.report, folder=found.folder), *found.remarks]


def _identification(found: Identification, every: bool) -> Blocks:
    return [_of("identify", "identification_text")(found), *_written(found)]


def _bias(found: BiasIdentification, every: bool) -> Blocks:
    return [_of("bias", "bias_text")(found), *_written(found)]


def _written(found: Identification | BiasIdentification) -> list[str]:
    return [f"wrote {path}" for path in (found.fabric_file, *found.figures) if path is not None]


def _calibrated(found: Calibration, every: bool) -> Blocks:
    return [_of("calibrate", "calibration_text")(found.data, found.files)]


def _compared(found: Compared, every: bool) -> Blocks:
    if found.data.get("surface"):
        return [_of("calibrate", "surface_text")(found.data, found.folder)]
    return [_of("diagnose", "compare_text")(found.data, folder=found.folder)]


def _diagnosis(found: DiagnosisOutcome, every: bool) -> Blocks:
    return [_of("diagnose", "diagnosis_text")(found.data, folder=found.folder, every=every)]


def _ensemble(found: EnsembleOutcome, every: bool) -> Blocks:
    if "designs" in found.data:
        return [_of("designs", "compare_text")(found.data, folder=found.folder)]
    return [_of("ensemble", "ensemble_text")(found.data, folder=found.folder)]


def _sized(found: Sized, every: bool) -> Blocks:
    return _of("sizing", "sizing")(found.data, found.folder, every=every)  # type: ignore[no-any-return]


def _life(found: Study, every: bool) -> Blocks:
    return [_of("life", "life_text")(found.data, folder=found.folder)]


def _inspection(found: Inspection | InspectedMesh, every: bool) -> Blocks:
    return [*_of("inspect", "inspection")(found), *map(str, found.problems)]


def _folder(found: InspectedFolder, every: bool) -> Blocks:
    return [*_of("inspect", "folder_inspection")(found), *map(str, found.problems)]


def _layout(found: Drawing, every: bool) -> Blocks:
    return _of("layout", "layout")(found)  # type: ignore[no-any-return]


WORDS: dict[str, Callable[[Any, bool], Blocks]] = {
    "LoadedCase": _case,
    "Run": _run,
    "Identification": _identification,
    "BiasIdentification": _bias,
    "Calibration": _calibrated,
    "Compared": _compared,
    "DiagnosisOutcome": _diagnosis,
    "EnsembleOutcome": _ensemble,
    "Sized": _sized,
    "Study": _life,
    "Inspection": _inspection,
    "InspectedMesh": _inspection,
    "InspectedFolder": _folder,
    "Drawing": _layout,
}
"""By the name of a class of ours: its words; a further study is one function and one line here."""
