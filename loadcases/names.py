"""Names in a case that must exist: fabric sets, wire materials, mesh files, criteria, solvers, effects.

Registries are imported only when a case names something else than the defaults, which keeps reading a case fast.
"""

from __future__ import annotations

import hashlib
import importlib
from collections.abc import Callable, Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from etextile.errors import BadInput, Problem, nearest
from etextile.units import shorten, to_number
from loadcases import catalogue
from loadcases.conflicts_worn import limb_conflicts
from loadcases.diaphragm import with_diaphragm
from loadcases.fabric import load_fabric
from loadcases.history import with_history
from loadcases.messages import problem_at
from loadcases.schema import Case
from loadcases.schema_body import Body, LimbMesh, Mesh, Own
from loadcases.schema_parts import Effect, Failure
from loadcases.schema_wires import Wires
from loadcases.wire_material import load_wire_material
from loadcases.yaml_text import Document, Route


EFFECTS = "etextile.effects.registry"
"""Module with `check_effect(id, parameters)`: converted parameters, or BadInput with parameters as keys."""
NONLINEAR_SOLVERS = ("newton",)


def resolve_names(case: Case, document: Document) -> tuple[Case, list[Problem]]:
    """Return the case with the numbers of criteria and effects converted, and a problem for every unusable name."""
    problems = [*_file_problems(case, document), *_solver_problems(case, document)]
    failure, found = _resolved_failure(case.failure, document)
    problems += found
    motion, found = with_history(case.motion, document)
    problems += found
    motion, found = with_diaphragm(motion, document)
    problems += found
    effects, found = resolve_effects(case.effects, document)
    body, measured = _measured(case, document)
    problems += [*found, *measured]
    return case.model_copy(update={"failure": failure, "motion": motion, "effects": effects, "body": body}), problems


def resolve_effects(effects: tuple[Effect, ...], document: Document) -> tuple[tuple[Effect, ...], list[Problem]]:
    """Return effects with their parameters as numbers, and a problem for everything unusable in them."""
    resolved: list[Effect] = []
    problems: list[Problem] = []
    for index, effect in enumerate(effects):
        item, found = _resolved_effect(effect, ("effects", index), document)
        resolved.append(item)
        problems += found
    return tuple(resolved), problems


def code_files(data: Mapping[str, Any]) -> tuple[tuple[Route, str], ...]:
    """Return the Python files that the keys of a case name, with the routes of these keys."""
    sections: list[tuple[Route, Any]] = [((name,), data.get(name)) for name in ("body", "failure")]
    effects = data.get("effects")
    sections += [
        (("effects", index), item) for index, item in enumerate(effects if isinstance(effects, list | tuple) else ())
    ]
    found = [
        ((*route, "file"), section["file"])
        for route, section in sections
        if isinstance(section, Mapping) and isinstance(section.get("file"), str)
    ]
    return tuple((route, name) for route, name in found if name.endswith(".py"))


def by_content(case: Case) -> Case:
    """Return a case in which every path is replaced by the hash of the file's content (equal wherever files lie)."""
    fabric, wires, body = case.fabric, case.wires, case.body
    if catalogue.is_path(fabric.set):
        fabric = fabric.model_copy(update={"set": _file_hash(fabric.set)})
    if wires is not None:
        wires = _wires_by_content(wires)
    if isinstance(body, (Mesh, Own)) and body.file is not None:
        body = body.model_copy(update={"file": _file_hash(body.file)})
    if isinstance(body, LimbMesh):
        body = body.model_copy(update={key: _file_hash(getattr(body, key)) for key in ("file", "rig", "weights")})
    effects = tuple(
        effect.model_copy(update={"file": _file_hash(effect.parameters["file"])})
        if "file" in effect.parameters
        else effect
        for effect in case.effects
    )
    motion, failure = case.motion.model_copy(update={"path_from": None}), case.failure
    if failure.file is not None:
        failure = failure.model_copy(update={"file": _file_hash(failure.file)})
    changed = {"fabric": fabric, "wires": wires, "body": body, "motion": motion, "effects": effects, "failure": failure}
    return case.model_copy(update=changed)


def _wires_by_content(wires: Wires) -> Wires:
    """Return wires whose material files and drawing are replaced by the hash of what they hold."""

    def hashed(material: str | None) -> str | None:
        return _file_hash(material) if material is not None and catalogue.is_path(material) else material

    drawn = wires.layout is not None and Path(wires.layout).is_file()
    paths = tuple(path.model_copy(update={"material": hashed(path.material)}) for path in wires.paths)
    layout = _file_hash(str(wires.layout)) if drawn else wires.layout
    return wires.model_copy(update={"material": hashed(wires.material), "layout": layout, "paths": paths})


def _file_hash(path: str) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


def _file_problems(case: Case, document: Document) -> Iterator[Problem]:
    """Yield what is wrong with the fabric, the wire material and the mesh file."""
    yield from _loads(lambda: load_fabric(case.fabric.set), ("fabric", "set"), document)
    wires = case.wires
    if wires is not None:
        yield from _loads(lambda: load_wire_material(wires.material), ("wires", "material"), document)
    if isinstance(case.body, Mesh) and not Path(case.body.file).is_file():
        message = f"no such file (got {case.body.file!r}), give an STL, OBJ, PLY or 3MF file"
        yield problem_at(("body", "file"), message, document)
    if isinstance(case.body, Own):
        yield from _own_body_problems(case.body, document)


def _measured(case: Case, document: Document) -> tuple[Body | None, list[Problem]]:
    """Return the body, that of a limb's mesh with the girth and the length that its files give, and what is wrong.

    A result file holds these numbers, so that it can be read without the mesh.
    """
    body = case.body
    if not isinstance(body, LimbMesh):
        return body, []
    try:
        found = body.measured()
    except BadInput as error:
        return body, [_placed(problem, document) for problem in error.problems]
    body = body.model_copy(update={"joint_girth": body.joint_girth or found.girth, "segment_length": found.length})
    conflicts = [problem_at(conflict.keys[0], conflict.message, document) for conflict in limb_conflicts(case, body)]
    return body, conflicts


def _placed(problem: Problem, document: Document) -> Problem:
    """Return a problem at its key, unless it names a file of its own."""
    return problem if problem.file else problem_at(tuple(problem.key.split(".")), problem.message, document)


def _own_body_problems(body: Own, document: Document) -> Iterator[Problem]:
    """Yield what is wrong with the file, the function or the dimensions of a body of the user's own."""
    own = importlib.import_module("etextile.contact.own")

    def check() -> None:
        own.checked_dimensions(own.body_function(body.shape, body.file), body.shape, body.dimensions)

    try:
        check()
    except BadInput as error:
        for problem in error.problems:
            yield _placed(problem, document)


def _loads(load: Callable[[], Any], route: Route, document: Document) -> Iterator[Problem]:
    """Yield what is wrong with a named thing: problems inside its file as they are, others at the key."""
    try:
        load()
    except BadInput as error:
        for problem in error.problems:
            yield problem if problem.file else problem_at(route, problem.message, document)


def _solver_problems(case: Case, document: Document) -> Iterator[Problem]:
    """Yield unknown linear and nonlinear solvers."""
    chosen = case.solver.linear
    if chosen != "auto":  # the default asks for no import of the solver
        known = ("auto", *importlib.import_module("etextile.solve.linear").LINEAR_SOLVERS)
        if chosen not in known:
            yield problem_at(("solver", "linear"), unknown(chosen, known), document)
    if case.solver.nonlinear not in NONLINEAR_SOLVERS:
        message = unknown(case.solver.nonlinear, NONLINEAR_SOLVERS)
        yield problem_at(("solver", "nonlinear"), message, document)


def unknown(name: str, known: tuple[str, ...]) -> str:
    """Say that a name is not among the known ones."""
    return f"unknown name (got {shorten(name)}), known are {', '.join(known) or 'none'}{nearest(name, known)}"


def _resolved_failure(failure: Failure, document: Document) -> tuple[Failure, list[Problem]]:
    """Return the failure section with plain numbers, and what its criterion says against it."""
    default = type(failure).model_fields["criterion"].default
    level = type(failure).model_fields["onset"].default
    if failure.criterion == default and failure.onset == level and not failure.model_extra and failure.file is None:
        return failure, []
    wires_failure = importlib.import_module("wires.failure")
    criteria = wires_failure.CRITERIA
    if failure.file is None and failure.criterion not in criteria:
        return failure, [problem_at(("failure", "criterion"), unknown(failure.criterion, tuple(criteria)), document)]
    try:
        criterion = criteria.load(failure.criterion, failure.file)
    except BadInput as error:
        return failure, [_at_key(problem, "failure.", document, ("failure",)) for problem in error.problems]
    specified = {item.name: item for item in criterion.parameters}
    problems: list[Problem] = []
    numbers = {"onset": failure.onset}
    if "onset" in specified and "onset" not in failure.model_fields_set:
        numbers = {"onset": specified["onset"].default}
    if "onset" not in specified and failure.onset == level:
        numbers = {}  # the level that maps mark; such a criterion does not know it
    for name, value in (failure.model_extra or {}).items():
        if name not in specified:
            allowed = ("criterion", "file", "cyclic", *specified)
            message = f"unknown key for {failure.criterion}, allowed are {', '.join(allowed)}{nearest(name, allowed)}"
            problems.append(problem_at(("failure", name), message, document))
            continue
        try:
            numbers[name] = to_number(value, specified[name].unit)
        except ValueError as error:
            problems.append(problem_at(("failure", name), str(error), document))
    resolve = wires_failure.resolve
    problems += _problems_of(lambda: resolve(failure.criterion, numbers), "failure.", document, ("failure",))
    return failure.model_copy(update=numbers), problems


def _resolved_effect(effect: Effect, route: Route, document: Document) -> tuple[Effect, list[Problem]]:
    """Return an effect with plain numbers, and what the effect registry says against it."""
    if find_spec(EFFECTS) is None:
        return effect, [problem_at((*route, "id"), unknown(effect.id, ()), document)]
    check: Callable[[str, Mapping[str, Any]], Mapping[str, Any]] = importlib.import_module(EFFECTS).check_effect
    numbers: dict[str, Any] = {}
    problems = _problems_of(lambda: numbers.update(check(effect.id, effect.parameters)), "", document, route)
    return effect.model_copy(update=numbers), problems


def _problems_of(check: Callable[[], Any], prefix: str, document: Document, route: Route) -> list[Problem]:
    """Run a check and return its problems at the places of the keys they name (the id of an effect without one)."""
    try:
        check()
    except BadInput as error:
        return [_at_key(problem, prefix, document, route) for problem in error.problems]
    return []


def _at_key(problem: Problem, prefix: str, document: Document, route: Route) -> Problem:
    """Return a problem at the place of the key it names; one inside another file stays there."""
    key = problem.key.removeprefix(prefix) or "id"
    return problem if problem.file else problem_at((*route, key), problem.message, document)
