"""Names in a case that must exist: fabric sets, wire materials, mesh files, criteria, solvers, effects."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from etextile.errors import BadInput, Problem
from loadcases import catalogue
from loadcases.fabric import load_fabric
from loadcases.messages import problem_at
from loadcases.schema import Case
from loadcases.schema_body import Mesh
from loadcases.wire_material import load_wire_material
from loadcases.yaml_text import Document, Route


def name_problems(case: Case, document: Document) -> Iterator[Problem]:
    """Yield a problem for every name in the case behind which there is nothing usable."""
    yield from _loads(lambda: load_fabric(case.fabric.set), ("fabric", "set"), document)
    wires = case.wires
    if wires is not None:
        yield from _loads(lambda: load_wire_material(wires.material), ("wires", "material"), document)
    if isinstance(case.body, Mesh) and not Path(case.body.file).is_file():
        yield problem_at(
            ("body", "file"), f"no such file (got {case.body.file!r}), give an STL, OBJ or PLY file", document
        )


def by_content(case: Case) -> Case:
    """Return a case in which every path is replaced by the hash of the file's content (equal wherever files lie)."""
    fabric, wires, body = case.fabric, case.wires, case.body
    if catalogue.is_path(fabric.set):
        fabric = fabric.model_copy(update={"set": _file_hash(fabric.set)})
    if wires is not None and catalogue.is_path(wires.material):
        wires = wires.model_copy(update={"material": _file_hash(wires.material)})
    if isinstance(body, Mesh):
        body = body.model_copy(update={"file": _file_hash(body.file)})
    return case.model_copy(update={"fabric": fabric, "wires": wires, "body": body})


def _file_hash(path: str) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def _loads(load: Callable[[], Any], route: Route, document: Document) -> Iterator[Problem]:
    """Yield what is wrong with a named thing: problems inside its file as they are, others at the key."""
    try:
        load()
    except BadInput as error:
        for problem in error.problems:
            yield problem if problem.file else problem_at(route, problem.message, document)
