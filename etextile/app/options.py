"""Options that several verbs share, so that they read and behave the same everywhere."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, TypeAlias

from cyclopts import Parameter
from cyclopts.validators import Number


CaseName: TypeAlias = Annotated[str, Parameter(name="CASE", help="Case file, or the name of a shipped case.")]
Folder: TypeAlias = Annotated[Path, Parameter(name="DIR", help="Output folder of a run.")]
Output: TypeAlias = Annotated[
    Path | None, Parameter(name=["--output", "-o"], help="Output folder [default: out/CASE].", show_default=False)
]
Overrides: TypeAlias = Annotated[
    tuple[str, ...],
    Parameter(
        name="--set", negative="", show_default=False, help="Override a value of the case, KEY.PATH=VALUE; repeatable."
    ),
]
AllowCode: TypeAlias = Annotated[
    bool,
    Parameter(
        name="--allow-code", negative="", show_default=False,
        help="Run the Python files that the case or a patch names (effects, criteria, bodies).",
    ),
]  # fmt: skip
Jobs: TypeAlias = Annotated[
    int | None, Parameter(validator=Number(gte=1), show_default=False, help="Threads of the solver at most.")
]
Workers: TypeAlias = Annotated[
    int | None,
    Parameter(
        name="--jobs", validator=Number(gte=1), show_default=False,
        help="Worker processes on this machine [default: cores].",
    ),
]  # fmt: skip
Seed: TypeAlias = Annotated[int, Parameter(validator=Number(gte=0), help="Seed of all random numbers.")]
Verbose: TypeAlias = Annotated[
    bool,
    Parameter(name=["--verbose", "-v"], negative="", show_default=False, help="Say more; traceback of faults."),
]
Quiet: TypeAlias = Annotated[
    bool, Parameter(name="--quiet", negative="", show_default=False, help="No progress and no text, errors only.")
]


def warn(text: str) -> None:
    """Say on the standard error what is to be known before long work begins."""
    print(f"warning: {text}", file=sys.stderr)


def tell_reason(code: int, reasons: Iterable[str], *, quiet: bool) -> None:
    """Say in one line on the standard error why a quiet verb ends with 3 or 4; others have said it in their text."""
    if quiet and code in (3, 4):
        said = "; ".join(" ".join(str(reason).split()) for reason in reasons)
        print(f"etextile: {said or 'a trust limit was passed'}", file=sys.stderr)


@contextmanager
def told_how_to_go_on(what: str) -> Iterator[None]:
    """Say at Ctrl-C that nothing is lost; `what`: what is kept."""
    try:
        yield
    except KeyboardInterrupt:
        print(f"{what} that ended are kept, the same command goes on with them", file=sys.stderr)
        raise
