"""The verb that answers the inverse question: how much slack do the loops need?"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

import etextile as et
from etextile.app.options import (
    AllowCode,
    CaseName,
    Overrides,
    Quiet,
    Verbose,
    tell_reason,
)


SizeFolder = Annotated[
    Path | None,
    Parameter(name=["--output", "-o"], help="Output folder [default: out/CASE_loops].", show_default=False),
]


def size_loops(
    case: CaseName,
    /,
    *,
    target: Annotated[float, Parameter(validator=Number(gt=0, lt=1))] = 0.01,
    per: Literal["garment", "net", "loop"] = "loop",
    output: SizeFolder = None,
    overrides: Overrides = (),
    allow_code: AllowCode = False,
    verify: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    force: Annotated[bool, Parameter(negative="", show_default=False)] = False,
    verbose: Verbose = False,
    quiet: Quiet = False,
) -> int:
    """Find the slack of loops, and the crimp of the weave, that keep the probability of a broken filament small.

    Parameters
    ----------
    target
        Probability that a filament breaks which is allowed.
    per
        To what: the whole garment, each net (each wire where none is named by its loops), or each loop and woven piece.
    verify
        Run the case once more with the slack found for all loops.
    force
        Overwrite the results of another case in the output folder.
    """
    loaded = et.load(case, overrides, allow_code=allow_code)
    from etextile.app.progress import Progress

    folder = output or Path("out") / f"{loaded.path.stem if loaded.path else 'case'}_loops"
    travel, unit = loaded.case.motion.travel, loaded.case.motion.unit
    with Progress(loaded.case.title, total=travel, unit=unit, quiet=quiet) as progress:
        sized = et.size_loops(loaded, folder, target=target, per=per, force=force, watch=progress.increment)
    if verify:
        from etextile.studies.sizing import verify_sizes

        with Progress(f"{loaded.case.title}, resized", total=travel, unit=unit, quiet=quiet) as progress:
            sized = verify_sizes(loaded, sized, watch=progress.increment)
    if not quiet:
        from etextile.app.show import show
        from etextile.text.summary import blocks

        show(blocks(sized, every=verbose))
    held = [sized.data["verdict"]["sentence"]] if sized.data["verdict"]["withheld"] else sized.data["notes"][:1]
    tell_reason(sized.exit_code, held, quiet=quiet)
    return sized.exit_code
