"""YAML text to plain values with the place of every key: strict YAML 1.2, duplicate keys are problems.

The node tree of ruamel.yaml is read instead of its round-trip dictionaries because that gives all duplicate keys at
once, with both places, and no YAML type beyond mapping, list, text, number, true/false and null.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import accumulate
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.reader import ReaderError

from etextile.errors import BadInput, Problem
from etextile.files import read_bounded, short
from etextile.importers.foreign import what_it_is
from etextile.visible import visible


Key = str | int
Route = tuple[Key, ...]
MAX_BYTES = 1_000_000
MAX_VALUES = 20_000
MAX_DEPTH = 30
ENTRY = re.compile(r"^[ ]*(?:- |[^#\s][^\n]*:(?=[ \n]))|,", re.MULTILINE)
"""What begins a value, nearly: the parser takes a second for some thousands."""
MAX_BRACKETS = 200
"""Open brackets, quoted ones counted too, that no text has whose nesting could be read."""
MAX_KEY = 1024
"""Characters of a key of YAML."""
MAX_DIGITS = 400
"""Digits of a whole number; the largest number of a computer has 309."""
_PLAIN = tuple(f"tag:yaml.org,2002:{name}" for name in ("str", "int", "float", "bool", "null"))


@dataclass(frozen=True)
class YamlPlace:
    """Where a key or value stands; line and column count from 1. `file` may name an option such as `--set x=1`."""

    file: str
    line: int | None = None
    column: int | None = None


@dataclass
class Document:
    """Plain data with the places of keys and values by route, and what was wrong while reading."""

    data: dict[str, Any]
    keys: dict[Route, YamlPlace] = field(default_factory=dict)
    values: dict[Route, YamlPlace] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)


def read_document(path: Path) -> tuple[Document, str]:
    """Read a YAML file whose top level is a mapping; returns it and its text, raises BadInput when it cannot."""
    text = read_text(path)
    return parse_document(text, shown(path)), text


def shown(path: Path) -> str:
    """Return a path as shown in messages: relative to the working folder when it lies inside it."""
    try:
        return short(path.resolve().relative_to(Path.cwd()))
    except (ValueError, OSError):
        return short(path)


def read_text(path: Path) -> str:
    """Return the text of a UTF-8 file; raises BadInput that says where the encoding breaks."""
    file = shown(path)
    raw = read_bounded(path, MAX_BYTES, shown=file)
    foreign = what_it_is(raw[:1024])
    if foreign and not foreign.startswith("a JSON document"):  # which is YAML too
        raise BadInput.of(f"this is {foreign}, not a YAML file", file=file, line=1)
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")) or 4 * raw[:200].count(0) > len(raw[:200]):
        raise BadInput.of("saved as UTF-16 or UTF-32, save the file with encoding UTF-8", file=file, line=1)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        column = error.start - (raw.rfind(b"\n", 0, error.start) + 1) + 1
        message = f"not UTF-8 text (got byte 0x{raw[error.start]:02x}), save the file with encoding UTF-8"
        raise BadInput.of(message, file=file, line=line, column=column) from error


def parse_document(text: str, file: str) -> Document:
    """Parse YAML text whose top level is a mapping; raises BadInput on syntax errors and on empty text."""
    node = compose(text, file)
    if node is None:
        message = "the file is empty, expected a mapping of keys such as 'title: ...'"
        raise BadInput.of(message, file=file, line=1, column=1)
    if not isinstance(node, MappingNode):
        kind = "a list" if isinstance(node, SequenceNode) else "plain text"
        message = f"the file holds {kind}, expected a mapping of keys such as 'title: ...'"
        raise BadInput.of(message, file=file, line=node.start_mark.line + 1, column=node.start_mark.column + 1)
    document = Document({})
    document.values[()] = _place(node, file)
    document.data = _mapping(node, (), file, document, (node,))
    return document


def parse_value(text: str, route: Route, file: str) -> Document:
    """Parse a YAML value given on the command line; places carry `route` and the option as file."""
    node = compose(text, file)
    if node is None:
        raise BadInput.of("no value given, write null to switch something off", file=file)
    document = Document({})
    document.data = {"value": _value(node, route, file, document, ())}
    for places in (document.keys, document.values):
        for here in places:
            places[here] = YamlPlace(file)
    document.problems = [replace(problem, line=None, column=None) for problem in document.problems]
    return document


def compose(text: str, file: str) -> Node | None:
    """Return the node tree of YAML text; raises BadInput with the place of a syntax error."""
    if _open_brackets(text) > MAX_BRACKETS:
        raise BadInput.of(f"nested too deeply, at most {MAX_DEPTH} levels are read", file=file)
    if (count := len(ENTRY.findall(text))) > 2 * MAX_VALUES:
        raise BadInput.of(f"some {count} values are too many, at most {MAX_VALUES} are read", file=file)
    yaml = YAML(typ="safe", pure=True)
    try:
        node: Node | None = yaml.compose(text)
    except MarkedYAMLError as error:
        unclosed = "flow" in str(error.context) and error.context_mark is not None
        mark = error.context_mark if unclosed else error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark is not None else (None, None)
        raise BadInput.of(_syntax_message(error, text, line), file=file, line=line, column=column) from error
    except RecursionError as error:
        raise BadInput.of(f"nested too deeply, at most {MAX_DEPTH} levels are read", file=file) from error
    except ReaderError as error:
        before = text[: error.position]
        place = {"line": before.count("\n") + 1, "column": error.position - before.rfind("\n")}
        message = f"a character that no text file holds (U+{ord(text[error.position]):04X}), remove it"
        raise BadInput.of(message, file=file, **place) from error
    except (YAMLError, ValueError) as error:
        message = f"not YAML text ({str(error).splitlines()[0]}), expected lines 'key: value'"
        raise BadInput.of(message, file=file) from error
    return node


def _open_brackets(text: str) -> int:
    """Return how many brackets are open at once; the parser takes the square of that in time."""
    signs = (1 if sign in "[{" else -1 for sign in re.findall(r"[\[{}\]]", text))
    return max(accumulate(signs), default=0)


def _syntax_message(error: MarkedYAMLError, text: str, line: int | None) -> str:
    """Turn the parser's complaint into what a person can do about it."""
    problem = str(error.problem or error.context or "syntax error")
    lines = text.splitlines()
    found = lines[line - 1].strip() if line is not None and 0 < line <= len(lines) else ""
    got = f" (got {found[:60]!r})" if found else ""
    if "flow" in str(error.context):
        return f"not YAML: the bracket opened here is not closed properly{got}, check commas and the closing bracket"
    if "'\\t'" in problem:
        indented = line is not None and lines[line - 1].startswith((" ", "\t"))
        return f"a tab in the indentation{got}, indent with spaces" if indented else f"a tab{got}, write spaces"
    if problem == "could not find expected ':'" and len(found) > MAX_KEY:
        return f"not YAML: a key of more than {MAX_KEY} characters{got}, write ': ' behind a short one"
    if "mapping values are not allowed" in problem:
        return f"not YAML: a colon where no key can stand{got}, check the indentation and quote text that holds ': '"
    if "another document" in problem:
        return f"more than one YAML document{got}, keep one and remove the line '---'"
    if "undefined alias" in problem:
        return f"not YAML: {problem}{got}, define the anchor with & first or quote text that starts with *"
    return f"not YAML: {problem}{got}, check brackets, quotes and indentation"


def _place(node: Node, file: str) -> YamlPlace:
    """Return where a node starts."""
    return YamlPlace(file, node.start_mark.line + 1, node.start_mark.column + 1)


def _value(node: Node, route: Route, file: str, document: Document, above: tuple[Node, ...]) -> Any:
    """Return the plain value of a node and note its place; `above` holds the nodes it is nested in."""
    document.values[route] = _place(node, file)
    if len(document.values) > MAX_VALUES or len(above) > MAX_DEPTH:
        message = f"too much nested data, at most {MAX_VALUES} values and {MAX_DEPTH} levels are read"
        raise BadInput([_problem(message, node, route, file)])
    if any(node is other for other in above):
        document.problems.append(_problem("this alias holds itself, write the value out", node, route, file))
        return None
    if isinstance(node, MappingNode):
        return _mapping(node, route, file, document, (*above, node))
    if isinstance(node, SequenceNode):
        items = enumerate(node.value)
        return [_value(item, (*route, index), file, document, (*above, node)) for index, item in items]
    return _scalar(node, route, file, document)


def _mapping(node: MappingNode, route: Route, file: str, document: Document, above: tuple[Node, ...]) -> dict[str, Any]:
    """Return a mapping as a dictionary; keys that are not text or stand twice become problems."""
    result: dict[str, Any] = {}
    for key_node, value_node in node.value:
        key = visible(str(key_node.value)) if isinstance(key_node, ScalarNode) else ""
        here = (*route, key)
        if key_node.tag == "tag:yaml.org,2002:merge" and key == "<<":
            document.problems.append(_problem("merge keys are not part of YAML 1.2, use extends", key_node, here, file))
        elif not isinstance(key_node, ScalarNode):
            document.problems.append(_problem("a list or mapping cannot be a key, write text", key_node, route, file))
        elif key in result:
            first = document.keys[here]
            message = f"this key stands twice, first in line {first.line}, keep one of them"
            document.problems.append(_problem(message, key_node, here, file))
        else:
            document.keys[here] = _place(key_node, file)
            result[key] = _value(value_node, here, file, document, above)
    return result


def _scalar(node: Node, route: Route, file: str, document: Document) -> Any:
    """Return text, number, boolean or null; dates stay text, other tags become problems."""
    if node.tag == "tag:yaml.org,2002:timestamp":
        return visible(str(node.value))
    if node.tag not in _PLAIN:
        message = f"the tag {node.tag} is not allowed, write a plain value"
        document.problems.append(_problem(message, node, route, file))
        return None
    digits = len(node.value) if node.tag == _PLAIN[1] else 0
    if digits > MAX_DIGITS:
        message = f"a number of {digits} digits, at most {MAX_DIGITS} are read (got {str(node.value)[:20]}...)"
        document.problems.append(_problem(message, node, route, file))
        return None
    if node.tag in _PLAIN[1:3] and "_" in str(node.value):
        message = f"underscores in a number (got {str(node.value)!r}), write the digits alone"
        document.problems.append(_problem(message, node, route, file))
        return None
    try:
        value = _constructor().construct_object(node, deep=True)
    except (ValueError, KeyError):
        message = f"the tag {node.tag} does not fit (got {str(node.value)[:60]!r}), write a plain value"
        document.problems.append(_problem(message, node, route, file))
        return None
    return visible(value) if isinstance(value, str) else value


@lru_cache(maxsize=1)
def _constructor() -> Any:
    """Return the constructor of plain YAML 1.2 scalars."""
    return YAML(typ="safe", pure=True).constructor


def _problem(message: str, node: Node, route: Route, file: str) -> Problem:
    """Return a problem at the place of a node."""
    place = _place(node, file)
    return Problem(message, file, place.line, place.column, spell(route))


def spell(route: Route) -> str:
    """Write a route as a person does: ('effects', 0, 'limit') is 'effects.0.limit'."""
    return ".".join(str(part) for part in route)
