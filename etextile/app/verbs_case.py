"""Verbs that take a case: check and run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

import etextile as et
from etextile import foreign_code
from etextile.app.options import AllowCode, CaseName, Jobs, Output, Overrides, Quiet, Seed, Verbose, tell_reason, warn
from etextile.environment import use_threads


if TYPE_CHECKING:
    from etextile.studies.run.outcome import Run


def check(
    case: CaseName,
    /,
    *,
    overrides: Overrides = (),
    allow_code: AllowCode = False,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> int:
    """Validate a case and say what would be run."""
    loaded = et.load(case, overrides, allow_code=allow_code)
    from etextile.collisions import shared_with
    from etextile.studies.run.rehearsal import rehearse
    from etextile.text.case import case_text
    from loadcases.build import plan

    with foreign_code.trusting(allow_code), loaded.locating():
        counts = plan(loaded.case)
        rehearse(loaded.case)
    if not quiet:
        print(case_text(loaded, counts, every=verbose))
    if remark := shared_with():
        warn(remark)
    return 0


def run(
    case: CaseName,
    /,
    *,
    output: Output = None,
    overrides: Overrides = (),
    allow_code: AllowCode = False,
    resume: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    force: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    patch: Annotated[Path | None, Parameter(show_default=False)] = None,
    estimate_error: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    extrapolate: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    advise: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    open_: Annotated[bool, Parameter(name="--open", negative="", show_default=False)] = False,
    jobs: Jobs = None,
    seed: Seed = 0,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> int:
    """Simulate a case, judge its wires, write report and maps.

    Parameters
    ----------
    resume
        Go on from the last converged increment in the output folder.
    force
        Overwrite the results of another case in the output folder.
    estimate_error
        Repeat the case on a coarser and a finer lattice and say what changes.
    extrapolate
        Run two finer lattices too and say where force, loops and verdicts go on ever finer ones.
    advise
        Try by up to three more runs what to change: slack, position of the wires, depth.
    patch
        Patch file with further effects, as written by diagnose.
    open_
        Open the page in the browser when it is done.
    """
    if jobs is not None:
        use_threads(jobs)
    loaded = et.load(case, overrides, allow_code=allow_code)
    from etextile.app.progress import Progress
    from etextile.compiled import announcing
    from etextile.text.run import report_text

    folder = output or Path("out") / (loaded.path.stem if loaded.path else "case")
    total = loaded.case.motion.travel * (5.0 if extrapolate else 1.0)  # three lattices, and twice back to the start
    show = Progress(loaded.case.title, total=total, unit=loaded.case.motion.unit, quiet=quiet)

    def tell_verdict(found: Run) -> None:
        """Print the report as soon as it is known: maps and page take longer than a small case."""
        show.stop()
        if not quiet:
            print(report_text(found.report, folder=folder), flush=True)
        if advise and found.exit_code != 3 and found.report["wires"]:
            _advise(found, travel=loaded.case.motion.travel, quiet=quiet)

    with show as progress, announcing(progress.compiling):
        done = et.run(
            loaded,
            folder,
            resume=resume,
            force=force,
            patch=patch,
            estimate_error=estimate_error,
            extrapolate=extrapolate,
            allow_code=allow_code,
            seed=seed,
            watch=progress.increment,
            tell=warn,
            judged=tell_verdict,
        )
    if done.remarks and not quiet:
        print("\n".join(done.remarks))
    if open_:
        from etextile.app.verbs_show import tell_page

        tell_page(folder / "report.html")
    tell_reason(done.exit_code, done.reasons, quiet=quiet)
    return done.exit_code


def _advise(found: Run, *, travel: float, quiet: bool) -> None:
    """Try what to change and print it."""
    from etextile.app.progress import Progress
    from etextile.text.plain import as_text
    from etextile.text.run import advice

    with Progress("what to change", total=3.0 * travel, quiet=quiet) as trials:
        et.advise(found, watch=trials.increment)
    if not quiet:
        print(as_text(advice(found.report)), flush=True)
