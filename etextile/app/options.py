"""Options that several verbs share, so that they read and behave the same everywhere."""

from __future__ import annotations

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
Jobs: TypeAlias = Annotated[
    int | None, Parameter(validator=Number(gte=1), show_default=False, help="Threads or processes to use at most.")
]
Seed: TypeAlias = Annotated[int, Parameter(validator=Number(gte=0), help="Seed of all random numbers.")]
Verbose: TypeAlias = Annotated[
    bool,
    Parameter(name=["--verbose", "-v"], negative="", show_default=False, help="Say more; traceback of faults."),
]
Quiet: TypeAlias = Annotated[
    bool, Parameter(name="--quiet", negative="", show_default=False, help="No progress and no text, errors only.")
]
