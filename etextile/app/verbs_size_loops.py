"""The verb that answers the inverse question: how much slack do the loops need?"""

from __future__ import annotations

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
    Verbose,
    tell_reason,
)


SizeFolder = Annotated[
    Path | None,
    Parameter(name=["--output", "-o"], help="Output folder [default: out/CASE_loops].", show_default=False),
]
MOST_ROWS = 20


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
        To what: the whole garment, each net (each wire where the case names none), or each loop and woven piece.
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
        _print(sized.data, folder, every=verbose)
    held = [sized.data["verdict"]["sentence"]] if sized.data["verdict"]["withheld"] else sized.data["notes"][:1]
    tell_reason(sized.exit_code, held, quiet=quiet)
    return sized.exit_code


def _print(data: dict[str, Any], folder: Path, *, every: bool) -> None:
    """Print the sizes, those of the worst loops first."""
    from etextile.app.tables import print_table
    from wires.sizing_words import sentences
    from wires.trust import as_provisional
    from wires.wording import number, probability

    rows = sorted(data["loops"], key=lambda row: -row["span_strain"])
    shown = rows if every else rows[:MOST_ROWS]
    title = (
        f"Slack for a probability of at most {data['target']:g} per {data['per']} that a filament breaks, by "
        f"{data['criterion']} ({len(shown)} of {len(rows)} loops, worst first)"
    )
    print_table(
        as_provisional(title, passed=data["verdict"]["withheld"]),
        ("wire", "loop", "weft, mm", "warp, mm", "fabric strain", "slack now", "P now", "slack", "P then"),
        [
            (
                str(row["name"]),
                str(row["loop"]),
                f"{row['weft_mm']:.1f}",
                f"{row['warp_mm']:.1f}",
                f"{row['span_strain']:.3f}",
                f"{row['slack_now']:.3f}",
                probability(row["probability_now"]),
                number(row["slack"], "{:.3f}"),
                probability(row["probability"]),
            )
            for row in shown
        ],
    )
    print("\n".join(sentences(data)))
    for note in data["notes"]:
        print(f"note: {note}")
    print(f"Files in {folder}")
