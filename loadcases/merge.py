"""`extends` and `--set`: several sources laid over each other, each value keeping the place it came from."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from etextile.errors import BadInput, Problem
from etextile.units import shorten
from loadcases import catalogue
from loadcases.arcs import ARCS
from loadcases.yaml_text import Document, Key, Route, YamlPlace, parse_value, read_document, shown, spell


# A section that names another kind than its parent replaces it instead of mixing the keys of both.
KINDS: dict[Route, str] = {("body",): "type", ("failure",): "criterion"}
NAME_OR_PATH: tuple[Route, ...] = (("fabric", "set"), ("wires", "material"))
PATHS: tuple[Route, ...] = (
    ("body", "file"),
    ("body", "rig"),
    ("body", "weights"),
    ("failure", "file"),
    ("wires", "layout"),
    ("motion", "history"),
    ("motion", "diaphragm"),
)


def read_extended(path: Path, *, seen: tuple[Path, ...] = ()) -> tuple[Document, str]:
    """Read a case file with all it extends; returns the merged document and the text of the file itself."""
    document, text = read_document(path)
    _absolute_paths(document, path.resolve().parent)
    if "extends" not in document.data:
        return document, text
    place = document.values[("extends",)]
    parent = _parent(document.data.pop("extends"), place, path, seen=(*seen, path.resolve()))
    document.keys.pop(("extends",))
    if parent is None:
        return document, text
    base, _ = read_extended(parent, seen=(*seen, path.resolve()))
    base.data.pop("description", None)  # it describes the other case
    base.keys.pop(("description",), None)
    base.values.pop(("description",), None)
    return _merged(base, document), text


def _parent(name: Any, place: YamlPlace, path: Path, *, seen: tuple[Path, ...]) -> Path | None:
    """Return the file that `extends` names; raises BadInput at its place, also when files extend each other."""
    if name is None:
        return None
    message = ""
    if not isinstance(name, str):
        message = f"not a path or shipped case (got {shorten(name)}), write one name or path"
    else:
        try:
            found = catalogue.find("case", name, folder=path.resolve().parent)
        except BadInput as error:
            message = str(error)
        else:
            if found.resolve() not in seen:
                return found
            chain = " -> ".join(shown(file) for file in (*seen, found.resolve()))
            message = f"the files extend each other in a circle ({chain}), remove one extends"
    raise BadInput.of(message, file=place.file, line=place.line, column=place.column, key="extends")


def _names_a_file(name: str, route: Route) -> bool:
    """Tell a file from a shipped name."""
    return (route in PATHS and name not in ARCS) or catalogue.is_path(name)


def _absolute_paths(document: Document, folder: Path) -> None:
    """Make the file paths in a document absolute, so that they survive merging and dumping."""
    for route in (*NAME_OR_PATH, *PATHS):
        section = document.data.get(str(route[0]))
        name = section.get(str(route[1])) if isinstance(section, dict) else None
        if isinstance(section, dict) and isinstance(name, str) and _names_a_file(name, route):
            section[str(route[1])] = str(folder / Path(name).expanduser()) if name else name
    effects = document.data.get("effects")
    for effect in effects if isinstance(effects, list) else ():
        if isinstance(effect, dict) and isinstance(effect.get("file"), str):
            effect["file"] = str(folder / Path(effect["file"]).expanduser())


def _merged(base: Document, over: Document) -> Document:
    """Lay one document over another: mappings key by key, everything else replaced."""
    keys, values = dict(base.keys), dict(base.values)
    data = _merge_mapping(base.data, over.data, (), (keys, values))
    return Document(data, {**keys, **over.keys}, {**values, **over.values}, [*base.problems, *over.problems])


def _merge_mapping(
    base: Mapping[str, Any], over: Mapping[str, Any], route: Route, places: tuple[dict[Route, YamlPlace], ...]
) -> dict[str, Any]:
    """Return `base` with `over` laid over it; drops the places of what is replaced."""
    result = dict(base)
    for key, value in over.items():
        here = (*route, key)
        old = result.get(key)
        if isinstance(old, dict) and isinstance(value, dict) and not _another_kind(old, value, here):
            result[key] = _merge_mapping(old, value, here, places)
        else:
            _forget(here, places)
            result[key] = value
    return result


def _another_kind(old: Mapping[str, Any], new: Mapping[str, Any], route: Route) -> bool:
    """Tell whether `new` is a section of another kind (another body type, another criterion)."""
    kind = KINDS.get(route)
    return kind is not None and kind in new and old.get(kind) != new[kind]


def _forget(route: Route, places: tuple[dict[Route, YamlPlace], ...]) -> None:
    """Drop the places of a route and of all below it."""
    for known in places:
        for other in [item for item in known if item[: len(route)] == route]:
            del known[other]


def said(option: str) -> str:
    """Return an option as messages name it, cut when it is long."""
    return f"--set {option if len(option) <= 120 else option[:117] + '...'}"


def override(document: Document, option: str) -> None:
    """Apply one `key.path=value` to a document in place; raises BadInput that names the option."""
    file = said(option)
    path, equals, text = option.partition("=")
    parts = path.strip().split(".")
    if not equals or not all(parts):
        raise BadInput.of("not an override, write --set key.path=value such as --set contact.friction=0.3", file=file)
    if parts == ["extends"]:
        raise BadInput.of("extends cannot be set, give the other case itself", file=file, key="extends")
    target, route = _descend(document, parts[:-1], file)
    last = _step(target, parts[-1], route, file)
    here = (*route, last)
    value = parse_value(text, here, file)
    if isinstance(target, list) and last == len(target):
        target.append(None)
        document.values[route] = YamlPlace(file)
    target[last] = value.data["value"]
    _forget(here, (document.keys, document.values))
    document.keys.update({here: YamlPlace(file), **value.keys})
    document.values.update(value.values)
    document.problems.extend(value.problems)
    if any(other[: len(here)] == here for other in (*PATHS, *NAME_OR_PATH)):
        _absolute_paths(document, Path.cwd())


def _descend(document: Document, parts: list[str], file: str) -> tuple[Any, Route]:
    """Return the container that `parts` lead to, making mappings where nothing (or null) stands."""
    target: Any = document.data
    route: Route = ()
    for part in parts:
        step = _step(target, part, route, file)
        if isinstance(target, dict) and target.get(str(step)) is None:
            target[str(step)] = {}
            document.keys.setdefault((*route, step), YamlPlace(file))
            document.values[(*route, step)] = YamlPlace(file)
        if isinstance(target, list) and step == len(target):
            raise BadInput.of(f"the list has {len(target)} items, counted from 0", file=file, key=spell((*route, step)))
        target, route = target[step], (*route, step)
    return target, route


def _step(target: Any, part: str, route: Route, file: str) -> Key:
    """Return the key or index that `part` means in `target`; raises BadInput when there can be none."""
    if isinstance(target, dict):
        return part
    if not isinstance(target, list):
        message = f"there are no keys below it (it is {shorten(target)}), set {spell(route)} itself"
        raise BadInput([Problem(message, file, key=spell(route))])
    if not part.isdecimal() or int(part) > len(target):
        message = f"not an item of the list (got {part!r}), it has {len(target)} items, counted from 0"
        raise BadInput([Problem(message, file, key=spell(route))])
    return int(part)
