"""The two sides of a diagnosis, case and measurement, from whatever a caller names them by; who hears of progress."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol, TypeAlias

from etextile.diagnose.data.measured import Measurements
from etextile.errors import BadInput, Problem
from etextile.studies.cases import AnyCase, load, loaded_case
from loadcases.measurements import load_measurements
from loadcases.reader import LoadedCase
from loadcases.shipped import measured_folder


AnyMeasured: TypeAlias = Measurements | str | Path
"""What studies take for measurements: as read, or a folder, its yaml file, the name of a shipped one."""


class Listener(Protocol):
    """Who hears how a diagnosis comes on."""

    def tell(self, stage: str, text: str) -> None:
        """Hear what a stage found."""

    def watch(self, done: int, total: int) -> None:
        """Hear that `done` of `total` simulator runs of a stage have ended."""

    def advance(self, done: float, total: float, text: str) -> None:
        """Hear how far a single run has come."""


class Silence:
    """Nobody listens."""

    def tell(self, stage: str, text: str) -> None:
        """Drop what a stage found."""

    def watch(self, done: int, total: int) -> None:
        """Drop how many runs have ended."""

    def advance(self, done: float, total: float, text: str) -> None:
        """Drop how far a run has come."""


def question(
    case: AnyCase,
    measured: AnyMeasured,
    changes: Mapping[str, Any] | Sequence[str] = (),
    *,
    allow_code: bool = False,
) -> tuple[LoadedCase, Measurements]:
    """Return case and measurements; raises BadInput with the problems of both.

    `changes` and `allow_code`: of a case given by name, as in `load`.
    """
    problems: list[Problem] = []
    loaded, found = None, None
    try:
        loaded = load(case, changes, allow_code=allow_code) if isinstance(case, str | Path) else loaded_case(case)
    except BadInput as error:
        problems += error.problems
    try:
        found = measured if isinstance(measured, Measurements) else load_measurements(measured_folder(str(measured)))
    except BadInput as error:
        problems += error.problems
    if loaded is None or found is None:
        raise BadInput(problems)
    return loaded, found
