"""Names in a case that must exist: fabric sets, wire materials, mesh files, criteria, solvers, effects."""

from __future__ import annotations

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


def referenced_files(case: Case) -> tuple[str, ...]:
    """Return the paths of all files that a case names."""
    paths = [case.fabric.set] if catalogue.is_path(case.fabric.set) else []
    if case.wires is not None and catalogue.is_path(case.wires.material):
        paths.append(case.wires.material)
    if isinstance(case.body, Mesh):
        paths.append(case.body.file)
    return tuple(paths)


def _loads(load: Callable[[], Any], route: Route, document: Document) -> Iterator[Problem]:
    """Yield what is wrong with a named thing: problems inside its file as they are, others at the key."""
    try:
        load()
    except BadInput as error:
        for problem in error.problems:
            yield problem if problem.file else problem_at(route, problem.message, document)
