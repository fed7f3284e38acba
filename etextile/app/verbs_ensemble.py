"""Verbs that run many samples of a case: ensemble and compare-designs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

from etextile.app.options import CaseName, Output, Overrides, Quiet, Seed, Verbose


Samples = Annotated[
    int, Parameter(name=["--samples", "-n"], validator=Number(gte=1), help="Number of samples; a power of 2 is best.")
]
Jobs = Annotated[
    int | None,
    Parameter(validator=Number(gte=1), show_default=False, help="Worker processes on this machine [default: cores]."),
]
Scheduler = Annotated[
    str | None,
    Parameter(show_default=False, help="Address of a running dask scheduler, such as tcp://host:8786, with workers."),
]
MethodName = Annotated[
    Literal["sobol", "lhs"], Parameter(help="Scrambled Sobol points, or a Latin hypercube of just these samples.")
]
Resume = Annotated[
    bool,
    Parameter(
        negative="",
        show_default=False,
        help="Insist on going on: samples in the folder are always used again when they belong to the ensemble.",
    ),
]
Force = Annotated[
    bool, Parameter(negative="", show_default=False, help="Throw away the samples of another ensemble in the folder.")
]


def ensemble(
    case: CaseName,
    /,
    *,
    samples: Samples = 128,
    output: Output = None,
    overrides: Overrides = (),
    method: MethodName = "sobol",
    seed: Seed = 0,
    jobs: Jobs = None,
    scheduler: Scheduler = None,
    resume: Resume = False,
    force: Force = False,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> int:
    """Scatter fabric, wires, body and mounting; failure probability per wire and loop.

    What scatters, and how much, says the section `scatter` of the case. The numbers depend on the seed, not on the
    number of workers.
    """
    from loadcases.reader import load_case

    loaded = load_case(case, overrides=overrides)
    from etextile.app.ensemble import run_ensemble
    from etextile.app.progress import Progress

    folder = output or Path("out") / f"{loaded.path.stem if loaded.path else 'case'}_ensemble"
    with loaded.locating(), Progress(f"{loaded.case.title}, ensemble", total=samples, quiet=quiet) as progress:
        outcome = run_ensemble(
            loaded,
            folder,
            samples=samples,
            seed=seed,
            method=method,
            jobs=jobs,
            scheduler=scheduler,
            resume=resume,
            force=force,
            watch=lambda done, words: progress.advance(done, f"{done} of {samples} samples, {words}"),
        )
    if not quiet:
        print(outcome.text)
    return outcome.exit_code
