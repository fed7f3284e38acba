"""Verbs that take a case and what was measured: compare and diagnose."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

import etextile as et
from etextile.app.options import (
    AllowCode,
    CaseName,
    Overrides,
    Quiet,
    Seed,
    Verbose,
    Workers,
    tell_reason,
    told_how_to_go_on,
)
from etextile.environment import one_thread_each


if TYPE_CHECKING:
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
        help="Effects that may be named, when others are ruled out by other means; A,B or repeated [default: all].",
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
    allow_code: AllowCode = False,
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
    from etextile.app.diagnose_stages import StageDisplay
    from etextile.studies.diagnose.question import question

    loaded, found = question(case, measured, overrides, allow_code=allow_code)
    folder = output or _default(loaded, "compared")
    with told_how_to_go_on("simulator runs"), StageDisplay(quiet=quiet) as show:
        outcome = et.compare(
            loaded, found, folder, own_fabric=fabric == "case", jobs=jobs, seed=seed, force=force, listener=show
        )
    if not quiet:
        print(et.summary(outcome))
    return 0


def diagnose(
    case: CaseName,
    /,
    *,
    measured: Measured,
    output: DiagnoseFolder = None,
    overrides: Overrides = (),
    allow_code: AllowCode = False,
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
    from etextile.app.diagnose_stages import StageDisplay
    from etextile.studies.diagnose.question import question

    loaded, found = question(case, measured, overrides, allow_code=allow_code)
    folder = output or _default(loaded, "diagnosis")
    with told_how_to_go_on("simulator runs"), StageDisplay(quiet=quiet) as show:
        outcome = et.diagnose(
            loaded,
            found,
            folder,
            effects=effect,
            among=[name.strip() for item in among for name in item.split(",")],
            own_fabric=fabric == "case",
            jobs=jobs,
            seed=seed,
            force=force,
            listener=show,
        )
    if not quiet:
        print(et.summary(outcome, every=verbose))
    tell_reason(outcome.exit_code, outcome.doubts, quiet=quiet)
    return outcome.exit_code


def _default(loaded: LoadedCase, what: str) -> Path:
    return Path("out") / f"{loaded.path.stem if loaded.path else 'case'}_{what}"
