"""A document checked against its model: everything that is wrong at once, with the places of the keys."""

from __future__ import annotations

import copy
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from etextile.errors import BadInput, Problem
from loadcases.messages import problems_of
from loadcases.yaml_text import Document, Route


ModelT = TypeVar("ModelT", bound=BaseModel)


def validated(document: Document, model: type[ModelT]) -> ModelT:
    """Return the model read from a document; raises BadInput with all problems, in the order of the file."""
    item, problems = checked(document, model)
    if item is None or problems:
        raise BadInput(in_order(problems))
    return item


def checked(document: Document, model: type[ModelT]) -> tuple[ModelT | None, list[Problem]]:
    """Return the model, if what is right in the document makes one, and all problems found.

    Values that are wrong by themselves are taken out (their defaults stand in) so that what does not fit together
    among the others is found in the same pass.
    """
    problems = list(document.problems)
    try:
        return model.model_validate(document.data), problems
    except ValidationError as error:
        found = problems_of(error, document, model)
    problems.extend(problem for _, problem in found if _place(problem) not in map(_place, document.problems))
    wrong = [route for route, _ in found]
    try:
        return model.model_validate(_without(document.data, wrong)), problems
    except ValidationError as error:
        if any(detail["type"] == "conflicts" for detail in error.errors()):
            found = problems_of(error, document, model)
            problems.extend(problem for route, problem in found if route not in wrong)
    return None, problems


def _place(problem: Problem) -> tuple[str, int | None, int | None]:
    """Return where a problem stands; at one place the first message says it."""
    return (problem.file, problem.line, problem.column)


def in_order(problems: list[Problem]) -> list[Problem]:
    """Return problems by file, line and column, without repeats; files keep the order in which they came up."""
    files = list(dict.fromkeys(problem.file for problem in problems))
    unique = list(dict.fromkeys(problems))
    return sorted(unique, key=lambda item: (files.index(item.file), item.line or 0, item.column or 0))


def _without(data: dict[str, Any], routes: list[Route]) -> dict[str, Any]:
    """Return a copy of nested data without the keys at `routes` (a list item takes its whole list with it)."""
    result = copy.deepcopy(data)
    for route in routes:
        target: Any = result
        for index, part in enumerate(route):
            last = index == len(route) - 1 or isinstance(route[index + 1], int)
            if not isinstance(target, dict) or part not in target:
                break
            if last:
                del target[part]
                break
            target = target[part]
    return result
