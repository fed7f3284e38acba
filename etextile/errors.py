"""Errors a person can act on, each with the exit code the command line returns for it.

Every refusal of input is a `BadInput` that carries all problems found, not only the first one.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass


class EtextileError(Exception):
    """Base of all errors raised on purpose; `exit_code` is what the command line returns."""

    exit_code = 1


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong with the input: where it stands and what to do about it."""

    message: str
    file: str = ""
    line: int | None = None
    column: int | None = None
    key: str = ""

    def __str__(self) -> str:
        """`file:line:column: key: message`, leaving out what is not known."""
        place = ":".join(str(part) for part in (self.file, self.line, self.column) if part not in ("", None))
        return ": ".join(part for part in (place, self.key, self.message) if part)


class BadInput(EtextileError):
    """Input that cannot be used (exit code 2); `problems` lists everything that was found."""

    exit_code = 2

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))

    def __reduce__(self) -> tuple[type[BadInput], tuple[tuple[Problem, ...]]]:
        """Keep the problems apart when the error comes from another process."""
        return type(self), (self.problems,)

    @classmethod
    def of(
        cls, message: str, *, file: str = "", line: int | None = None, column: int | None = None, key: str = ""
    ) -> BadInput:
        """Return the error for a single problem."""
        return cls([Problem(message, file, line, column, key)])


class NotPositiveDefinite(EtextileError):
    """The matrix has a pivot that is not positive; add damping and try again."""


class NoEquilibrium(EtextileError):
    """The solver found no equilibrium (exit code 3); converged increments are kept in the result file."""

    exit_code = 3


class NoSpace(EtextileError):
    """The disk took no more (exit code 1); what was finished before is kept."""

    exit_code = 1


def nearest(name: str, known: Iterable[str]) -> str:
    """Return `, did you mean 'x'?` for the known name closest to `name`, or an empty string."""
    match = difflib.get_close_matches(name, list(known), n=1, cutoff=0.6)
    return f", did you mean {match[0]!r}?" if match else ""
