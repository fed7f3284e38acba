"""Verbs that take a case and what was measured: compare and diagnose."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from etextile.app.options import CaseName, Overrides, Quiet, Seed, Verbose, Workers, told_how_to_go_on


if TYPE_CHECKING:
    from etextile.diagnose.data.measured import Measurements
    from loadcases.reader import LoadedCase

Measured = Annotated[
    str,
    Parameter(name="--measured", help="Folder with a measured.yaml, or the name of a shipped one."),
]
CompareFolder = Annotated[
    Path | None,
    Parameter(name=["--output", "-o"], help="Output folder [default: out/CASE_compared].", show_default=False),
]
DiagnoseFolder = Annotated[
    Path | None,
    Parameter(name=["--output", "-o"], help="Output folder [default: out/CASE_diagnosis].", show_default=False),
]
Effects = Annotated[
    tuple[Path, ...],
    Parameter(
        name="--effect", negative="", show_default=False,
        help="Python file with effects of your own that take part; repeatable.",
    ),
]  # fmt: skip
Among = Annotated[
    tuple[str, ...],
    Parameter(
        name="--among", negative="", show_default=False,
        help="Effect that may be named, when others are ruled out by other means; repeatable [default: all].",
    ),
]  # fmt: skip
FabricFrom = Annotated[
    Literal["coupons", "case"],
    Parameter(name="--fabric", help="Fabric parameters: from the tensile channel if there is one, or the case's own."),
]
Force = Annotated[
    bool,
    Parameter(negative="", show_default=False, help="Overwrite files of another case or measurement in the folder."),
]


def compare(
    case: CaseName,
    /,
    *,
    measured: Measured,
    output: CompareFolder = None,
    overrides: Overrides = (),
    fabric: FabricFrom = "coupons",
    jobs: Workers = None,
    seed: Seed = 0,
    force: Force = False,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> int:
    """Say how far a case is from a measurement, per channel, and where it begins.

    No diagnosis. Fabric, lattice error and noise are treated as in diagnose.
    """
    one_thread_each()
    loaded, found = _read(case, measured, overrides)
    from etextile.app.diagnose_stages import StageDisplay
    from etextile.diagnose.predict.simulate import Runner
    from etextile.studies.diagnose.compare import FILES, compare
    from etextile.studies.diagnose.folder import claim
    from etextile.studies.diagnose.setting import assemble

    with loaded.locating():
        task = assemble(loaded, found, name_effects=False, own_fabric=fabric == "case", seed=seed)
    folder = claim(output or _default(loaded, "compared"), task, FILES, verb="compare", force=force)
    with told_how_to_go_on("simulator runs"), StageDisplay(quiet=quiet) as show:
        runner = Runner(task.simulator, folder.cache, workers=jobs or cores(), watch=show.watch)
        try:
            outcome = compare(task, folder, runner, tell=show.tell)
        finally:
            runner.close()
    if not quiet:
        print(outcome.text, end="")
    return 0


def diagnose(
    case: CaseName,
    /,
    *,
    measured: Measured,
    output: DiagnoseFolder = None,
    overrides: Overrides = (),
    effect: Effects = (),
    among: Among = (),
    fabric: FabricFrom = "coupons",
    jobs: Workers = None,
    seed: Seed = 0,
    force: Force = False,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> int:
    """Find where simulation and measurement part, and name the missing effect.

    Verdicts: no_gap, named, ambiguous, unexplained. Writes diagnosis.json,
    report.html, pictures and, for a named effect, patch.yaml for `etextile run
    --patch`; for the best of several provisional.yaml. An interrupted call is
    repeated as it is: the runs in the folder's cache are used again.
    """
    one_thread_each()
    loaded, found = _read(case, measured, overrides)
    from etextile.app.diagnose_stages import StageDisplay
    from etextile.diagnose.predict.simulate import Runner
    from etextile.studies.diagnose.folder import claim
    from etextile.studies.diagnose.run import FILES, diagnose_task
    from etextile.studies.diagnose.setting import assemble

    with loaded.locating():
        task = assemble(loaded, found, effects=effect, among=among, own_fabric=fabric == "case", seed=seed)
    folder = claim(output or _default(loaded, "diagnosis"), task, FILES, verb="diagnose", force=force)
    with told_how_to_go_on("simulator runs"), StageDisplay(quiet=quiet) as show:
        runner = Runner(task.simulator, folder.cache, workers=jobs or cores(), watch=show.watch)
        try:
            outcome = diagnose_task(task, folder, runner, show=show, every=verbose)
        finally:
            runner.close()
    if not quiet:
        print(outcome.text, end="")
    return outcome.exit_code


def _read(case: str, measured: str, overrides: tuple[str, ...]) -> tuple[LoadedCase, Measurements]:
    """Return case and measurements; raises BadInput with the problems of both."""
    from etextile.errors import BadInput, Problem
    from loadcases.measurements import load_measurements
    from loadcases.reader import load_case
    from loadcases.shipped import measured_folder

    problems: list[Problem] = []
    loaded, found = None, None
    try:
        loaded = load_case(case, overrides=overrides)
    except BadInput as error:
        problems += error.problems
    try:
        found = load_measurements(measured_folder(measured))
    except BadInput as error:
        problems += error.problems
    if loaded is None or found is None:
        raise BadInput(problems)
    return loaded, found


def _default(loaded: LoadedCase, what: str) -> Path:
    return Path("out") / f"{loaded.path.stem if loaded.path else 'case'}_{what}"


def one_thread_each() -> None:
    """Let linear algebra use one thread per process, unless the user has set another number.

    Matrices here have some hundred rows: threads that wait for each other cost more than they bring, ten times as much
    on a machine that is busy. It has to be said before numpy is loaded.
    """
    import os

    for name in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(name, "1")


def cores() -> int:
    """Return how many processes the machine can run at the same time."""
    import os

    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
