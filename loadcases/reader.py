"""Case files read strictly: path or name in, one frozen `Case` out, or every problem at once.

loaded = load_case("punch", overrides=["contact.friction=0.3"])
loaded.case.motion.total
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from etextile import foreign_code
from etextile.errors import BadInput, Problem
from etextile.files import too_long
from loadcases import catalogue
from loadcases.dump import dump
from loadcases.merge import override, read_extended, said
from loadcases.messages import problem_at
from loadcases.names import by_content, code_files, resolve_names
from loadcases.schema import Case
from loadcases.validate import checked, in_order
from loadcases.yaml_text import Document, Route, parse_document


NAMING = ("set", "file", "rig", "weights", "material", "layout", "history", "diaphragm")
"""Keys whose values may be paths."""


@dataclass(frozen=True)
class LoadedCase:
    """A case as it will be run: `case` after extends and overrides, and the text it was read from.

    `sha256` identifies the effective case with the contents of the files it names, wherever they lie.
    """

    case: Case
    source_text: str
    sha256: str
    path: Path | None = None
    overrides: tuple[str, ...] = ()
    document: Document | None = field(default=None, repr=False, compare=False)

    @contextmanager
    def locating(self) -> Iterator[None]:
        """Give file, line and column to the problems raised inside that name a key of the case but no file."""
        try:
            yield
        except BadInput as error:
            raise BadInput(self._located(problem) for problem in error.problems) from error

    def _located(self, problem: Problem) -> Problem:
        """Return a problem at the place of its key."""
        if problem.file or not problem.key or problem.key.startswith("--") or self.document is None:
            return problem
        route = tuple(int(part) if part.isdecimal() else part for part in problem.key.split("."))
        return problem_at(route, problem.message, self.document)


def load_case(name: str | Path, *, overrides: Sequence[str] = ()) -> LoadedCase:
    """Return the shipped case of that name or the one in a file, with `key.path=value` overrides laid over it.

    Raises BadInput with everything that is wrong in the case, the files it extends and the overrides.
    """
    path = catalogue.find("case", str(name))
    document, text = read_extended(path)
    return _loaded(document, text, path=path, overrides=tuple(overrides))


def read_case(text: str, *, overrides: Sequence[str] = (), file: str = "case") -> LoadedCase:
    """Return the case written in `text` (for cases made by programs); `extends` needs a file and is refused."""
    return _loaded(parse_document(text, file), text, path=None, overrides=tuple(overrides))


@lru_cache(maxsize=8)
def stored_case(text: str, file: str) -> Case:
    """Return the case in a result file as it was checked then: files and code that it names are not looked at."""
    case, problems = checked(parse_document(text, file), Case)
    if case is None or problems:
        raise BadInput(in_order(problems))
    return case


def as_loaded(case: Case) -> LoadedCase:
    """Return a case made or changed in Python in the form that runs take."""
    text = dump_case(case)
    return LoadedCase(case, text, case_sha256(case))


def dump_case(case: Case) -> str:
    """Return the canonical YAML of a case, all defaults written out; reads back to the same case."""
    return dump(case)


def case_sha256(case: Case) -> str:
    """Return the hash of the canonical YAML, in which the contents of files stand for their paths."""
    return hashlib.sha256(dump_case(by_content(case)).encode()).hexdigest()


def _loaded(document: Document, text: str, *, path: Path | None, overrides: tuple[str, ...]) -> LoadedCase:
    """Apply overrides, check everything and return the loaded case; raises BadInput with all problems."""
    problems: list[Problem] = _apply(document, overrides)
    _require_paths(document)
    _allow_named(document, overrides)
    case, found = checked(document, Case)
    problems.extend(found)
    if case is not None:
        case, found = resolve_names(case, document)
        problems.extend(found)
    if case is None or problems:
        raise BadInput(in_order(problems))
    return LoadedCase(case, text, case_sha256(case), path, overrides, document)


def _require_paths(document: Document) -> None:
    """Raise BadInput for paths that are longer than any file's."""
    problems = [
        problem_at(route, found, document) for route, name in _paths(document.data) if (found := too_long(name))
    ]
    if problems:
        raise BadInput(problems)


def _paths(data: Any, route: Route = ()) -> Iterator[tuple[Route, str]]:
    """Yield what may be a path anywhere in a document, with its route."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        if key in NAMING and isinstance(value, str):
            yield (*route, key), value
        yield from _paths(value, (*route, key))


def _allow_named(document: Document, overrides: Iterable[str]) -> None:
    """Let Python files run that an override names: they are the user's own."""
    named = {said(option) for option in overrides}
    for route, name in code_files(document.data):
        place = document.values.get(route)
        if place is not None and place.file in named:
            foreign_code.allow_file(name)


def _apply(document: Document, overrides: Iterable[str]) -> list[Problem]:
    """Apply overrides in turn and return what is wrong with them."""
    problems: list[Problem] = []
    for option in overrides:
        try:
            override(document, option)
        except BadInput as error:
            problems.extend(error.problems)
    return problems
