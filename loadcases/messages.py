"""pydantic's complaints turned into problems with file, line, key, what was found and what is allowed."""

from __future__ import annotations

import difflib
import types
from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from etextile.errors import Problem, nearest
from etextile.units import shorten
from loadcases.yaml_text import Document, Route, YamlPlace, spell


def problems_of(error: ValidationError, document: Document, model: type[BaseModel]) -> list[tuple[Route, Problem]]:
    """Return one problem per complaint, with the route it belongs to."""
    found: list[tuple[Route, Problem]] = []
    details = _short_lists(error.errors())
    strange = [item for item in details if item["type"] == "extra_forbidden" and len(item["loc"]) == 1]
    if len(strange) == len(document.data):
        keys = f"{', '.join(str(key)[:20] for key in list(document.data)[:3])}{', ...' * (len(strange) > 3)}"
        message = f"not such a file: no key is known (got {keys}), expected {', '.join(model.model_fields)}"
        return [((), problem_at((), message, document))]
    for detail in details:
        if detail["type"] == "conflicts":
            section = plain_route(detail, document.data)
            for conflict in detail["ctx"]["conflicts"]:
                route = (*section, *conflict.keys[0])
                found.append((route, problem_at(route, conflict.message, document)))
            continue
        route = plain_route(detail, document.data)
        found.append((route, problem_at(route, _message(detail, route, document, model), document)))
    return found


def _short_lists(details: list[ErrorDetails]) -> list[ErrorDetails]:
    """Return one complaint per list that is too short, where pydantic has one per missing item."""
    result: dict[tuple[int | str, ...], ErrorDetails] = {}
    for index, detail in enumerate(details):
        last = detail["loc"][-1] if detail["loc"] else ""
        if detail["type"] == "missing" and isinstance(last, int):
            short: ErrorDetails = {
                **detail,
                "type": "too_short",
                "loc": detail["loc"][:-1],
                "ctx": {"length": last + 1},
            }
            result[short["loc"]] = short
        else:
            result[(*detail["loc"], index, detail["type"])] = detail
    return list(result.values())


def problem_at(route: Route, message: str, document: Document) -> Problem:
    """Return a problem at the value of a route; a missing key points at the section it is missing in."""
    unknown = message.startswith("unknown key")
    place = document.keys.get(route) if unknown else document.values.get(route)
    above = route
    while place is None and above:
        above = above[:-1]
        place = document.keys.get(above) or document.values.get(above)
    place = place or YamlPlace("")
    return Problem(message, place.file, place.line, place.column, spell(route))


def plain_route(detail: ErrorDetails, data: Any) -> Route:
    """Return pydantic's location without the tags of unions, which are no keys of the file."""
    location = detail["loc"]
    route: list[str | int] = []
    for index, part in enumerate(location):
        missing = detail["type"] == "missing" and index == len(location) - 1
        inside = isinstance(data, Mapping) and part in data
        item = isinstance(data, (list, tuple)) and isinstance(part, int) and part < len(data)
        if missing or inside or item:
            route.append(part)
            data = None if missing else data[part]
    if detail["type"] in ("union_tag_invalid", "union_tag_not_found"):
        route.append(str(detail["ctx"]["discriminator"]).strip("'"))
    return tuple(route)


def _message(detail: ErrorDetails, route: Route, document: Document, model: type[BaseModel]) -> str:
    """Return the text for one complaint: what is wrong (got ...), what is allowed, did you mean ..."""
    kind, context = detail["type"], detail.get("ctx", {})
    got = shorten(detail["input"])
    if kind == "value_error":
        return str(context["error"])
    if kind == "extra_forbidden":
        return _unknown_key(route, document, model)
    if kind == "missing":
        return f"this key is missing, expected: {_field_text(route, document, model)}"
    if kind == "union_tag_not_found":
        return f"this key is missing, must be one of {_plain_list(context_tags(route, document, model))}"
    if kind in ("literal_error", "union_tag_invalid"):
        allowed = str(context.get("expected") or context.get("expected_tags")).replace(" or ", ", ")
        choices = [item.strip().strip("'") for item in allowed.split(",")]
        value = context.get("tag", detail["input"])
        sections = _known(_models_at(route, document.data, model)) if kind == "literal_error" else []
        section = f" or a mapping with the keys {', '.join(sections)}" if sections else ""
        hint = nearest(str(value), choices)
        return f"not allowed (got {shorten(value)}), must be {_plain_list(choices)}{section}{hint}"
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        keys = ", ".join(_known(_models_at(route, document.data, model)))
        return f"not a section (got {got}), expected a mapping with the keys {keys}"
    if kind in ("tuple_type", "list_type"):
        return f"not a list (got {got}), write [a, b, ...]: {_field_text(route, document, model)}"
    if kind in ("too_long", "too_short"):
        exact = context.get("length", context.get("max_length"))
        expected = f"at least {context['min_length']}" if exact is None else exact
        return f"wrong number of items (got {got}), expected {expected}"
    if kind in ("string_type", "string_too_short"):
        return f"not a text (got {got}), expected: {_field_text(route, document, model)}"
    return f"{detail['msg']} (got {got})"


def context_tags(route: Route, document: Document, model: type[BaseModel]) -> list[str]:
    """Return the values that the discriminating key at `route` may have."""
    return [tag for item in _models_at(route[:-1], document.data, model) for tag in _tags(item)]


def _unknown_key(route: Route, document: Document, model: type[BaseModel]) -> str:
    """Say that a key is unknown, which are allowed, and where a key of this name belongs."""
    key = str(route[-1])
    known = _known(_models_at(route[:-1], document.data, model))
    if len(route) == 1 and "motion" in known:
        known = [*known, "extends"]
    alike = difflib.get_close_matches(key, known, n=1, cutoff=0.75)
    homes = " or ".join(repr(spell(home)) for home in _homes(model).get(key, ()))
    hint = f", did you mean {homes}?" if homes and not alike else nearest(key, known)
    if key[:1].isdigit() and document.data and str(route[-1]) not in homes:
        hint = "; a decimal comma within braces begins a new key, write a point"
    return f"unknown key, allowed are {', '.join(known)}{hint}"


@lru_cache(maxsize=8)
def _homes(model: type[BaseModel]) -> dict[str, tuple[Route, ...]]:
    """Return the routes in the schema by the key they end with."""
    homes: dict[str, dict[Route, None]] = {}
    for route in _routes(model, ()):
        homes.setdefault(str(route[-1]), {})[route] = None
    return {key: tuple(routes) for key, routes in homes.items()}


def _routes(model: type[BaseModel], above: Route) -> Iterator[Route]:
    for name, info in model.model_fields.items():
        yield (*above, name)
        for inner in _models(info.annotation):
            yield from _routes(inner, (*above, name))


def _plain_list(items: list[str]) -> str:
    """Return `a, b or c`."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} or {items[-1]}"


def _known(models: list[type[BaseModel]]) -> list[str]:
    """Return the keys of some models, each once."""
    return list(dict.fromkeys(name for item in models for name in item.model_fields))


def _field_text(route: Route, document: Document, model: type[BaseModel]) -> str:
    """Return the description of the field at `route`."""
    names = [part for part in route if isinstance(part, str)]
    for owner in _models_at(tuple(names[:-1]), document.data, model):
        info = owner.model_fields.get(names[-1]) if names else None
        if info is not None and info.description:
            return info.description.rstrip(".")
    return "a value"


def _models_at(route: Route, data: Any, model: type[BaseModel]) -> list[type[BaseModel]]:
    """Return the models that may describe the section at `route` (several for a body of unknown type)."""
    models = [model]
    for part in route:
        data = _below(data, part)
        if isinstance(part, int):
            continue
        fields = [owner.model_fields[part] for owner in models if part in owner.model_fields]
        inner = [found for info in fields for found in _models(info.annotation)]
        tag = data.get("type") if isinstance(data, Mapping) else None
        models = [item for item in inner if tag in _tags(item)] or inner
    return models


def _below(data: Any, part: str | int) -> Any:
    """Return the item of a mapping or list, or None."""
    if isinstance(data, Mapping):
        return data.get(part)
    if isinstance(data, list) and isinstance(part, int) and part < len(data):
        return data[part]
    return None


def _models(annotation: Any) -> list[type[BaseModel]]:
    """Return the models inside an annotation such as `Sphere | Mesh | None` or `tuple[Effect, ...]`."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    if get_origin(annotation) in (Union, types.UnionType, tuple, list) or hasattr(annotation, "__metadata__"):
        return [found for item in get_args(annotation) for found in _models(item)]
    return []


def _tags(model: type[BaseModel]) -> tuple[str, ...]:
    """Return the values of a model's `type`, by which unions are told apart."""
    info = model.model_fields.get("type")
    return tuple(get_args(info.annotation)) if info is not None else ()
