"""Verbs that run many samples of a case: ensemble and compare-designs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

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


Samples = Annotated[
    int, Parameter(name=["--samples", "-n"], validator=Number(gte=1), help="Number of samples; a power of 2 is best.")
]
EnsembleFolder = Annotated[
    Path | None,
    Parameter(name=["--output", "-o"], help="Output folder [default: out/CASE_ensemble].", show_default=False),
]
CompareFolder = Annotated[
    Path | None,
    Parameter(name=["--output", "-o"], help="Output folder [default: out/compare_designs].", show_default=False),
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
    output: EnsembleFolder = None,
    overrides: Overrides = (),
    allow_code: AllowCode = False,
    method: MethodName = "sobol",
    seed: Seed = 0,
    jobs: Workers = None,
    scheduler: Scheduler = None,
    resume: Resume = False,
    force: Force = False,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> int:
    """Scatter fabric, wires, body and mounting: failure probability per wire and loop.

    The section `scatter` of the case says how much.
    """
    loaded = et.load(case, overrides, allow_code=allow_code)
    from etextile.app.progress import Progress

    folder = output or Path("out") / f"{loaded.path.stem if loaded.path else 'case'}_ensemble"
    show = Progress(f"{loaded.case.title}, ensemble", total=samples, quiet=quiet)
    with told_how_to_go_on("samples"), show as progress:
        outcome = et.ensemble(
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
        print(et.summary(outcome))
    tell_reason(outcome.exit_code, _reasons(outcome.data), quiet=quiet)
    return outcome.exit_code


def compare_designs(
    first: Annotated[str, Parameter(name="A", help="Case of the first design: file or shipped name.")],
    second: Annotated[str, Parameter(name="B", help="Case of the second design.")],
    /,
    *,
    samples: Samples = 128,
    output: CompareFolder = None,
    overrides: Overrides = (),
    allow_code: AllowCode = False,
    overrides_b: Annotated[
        tuple[str, ...],
        Parameter(name="--set-b", negative="", show_default=False, help="Override a value of B alone; repeatable."),
    ] = (),
    method: MethodName = "sobol",
    seed: Seed = 0,
    jobs: Workers = None,
    scheduler: Scheduler = None,
    force: Force = False,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> int:
    """Compare two layouts on the same random numbers: which is better, by how much, how sure.

    --set changes both designs, --set-b only B.
    """
    one = et.load(first, overrides, allow_code=allow_code)
    other = et.load(second, (*overrides, *overrides_b), allow_code=allow_code)
    from etextile.app.progress import Progress

    folder = output or Path("out") / "compare_designs"
    with told_how_to_go_on("samples"), Progress("two designs", total=2 * samples, quiet=quiet) as progress:
        outcome = et.compare_designs(
            one,
            other,
            folder,
            samples=samples,
            seed=seed,
            method=method,
            jobs=jobs,
            scheduler=scheduler,
            force=force,
            watch=lambda done, words: progress.advance(done, f"{done} of {2 * samples} samples, {words}"),
        )
    if not quiet:
        print(et.summary(outcome))
    tell_reason(outcome.exit_code, _reasons_of_designs(outcome.data), quiet=quiet)
    return outcome.exit_code


def _reasons(data: Mapping[str, Any]) -> list[str]:
    """Return why an ensemble cannot be relied on."""
    count, failed = data["samples"], data["failed_runs"]
    return [*([f"{failed} of {count} samples found no equilibrium"] if failed else []), *data["trust"]["exceeded"]]


def _reasons_of_designs(data: Mapping[str, Any]) -> list[str]:
    """Return why a comparison cannot be relied on."""
    failed = [
        f"{name}: {item['failed_runs']} of {data['samples']} samples found no equilibrium"
        for name, item in data["designs"].items()
        if item["failed_runs"]
    ]
    return [*failed, *([data["verdict"]["sentence"]] if data["verdict"]["withheld"] else [])]
