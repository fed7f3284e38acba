"""House rules that neither ruff nor mypy can check."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest


ROOT = Path(__file__).parents[2]
MODULES = sorted(path for top in ("etextile", "wires", "loadcases", "viz") for path in (ROOT / top).rglob("*.py"))
TEXTS = sorted(
    path
    for pattern in ("*", ".ci/*", "etextile/**/*", "wires/**/*", "loadcases/**/*", "viz/**/*", "tests/**/*")
    for path in ROOT.glob(pattern)
    if "html" not in path.parts
    and path.name != ".git"  # a file in a linked work tree
    and path.is_file()
    and path.suffix in {"", ".py", ".md", ".yaml", ".toml", ".txt", ".csv", ".cff", ".html", ".svg"}
)
# homes, scratch folders, and package registries
FOREIGN = re.compile(r"/(?:home|root|Users|work|tmp)/\w+/|[A-Z]:\\Users|://[^\s/]*/(?:simple|packages)/")
FRONT_DOOR = ROOT / "etextile" / "__init__.py"
"""The one package file with names in it; `test_front_door` says which."""
MAX_FILE_LINES, MAX_FUNCTION_LINES = 420, 80


def relative(paths: list[Path]) -> list[str]:
    return [str(path.relative_to(ROOT)) for path in paths]


@pytest.mark.parametrize(
    "path",
    [path for path in MODULES if path.name == "__init__.py" and path != FRONT_DOOR],
    ids=lambda path: ".".join(path.parent.relative_to(ROOT).parts),
)
def test_package_file_holds_a_docstring_only(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"))
    assert ast.get_docstring(tree)
    assert len(tree.body) == 1


def test_no_file_is_too_long() -> None:
    lines = {path: len(path.read_text(encoding="utf-8").splitlines()) for path in MODULES}
    assert relative([path for path, count in lines.items() if count > MAX_FILE_LINES]) == []


def test_no_function_is_too_long() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{node.lineno}: {node.name}"
        for path in MODULES
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        and (node.end_lineno or node.lineno) - node.lineno + 1 > MAX_FUNCTION_LINES
    ]
    assert found == []


def test_no_path_of_a_machine_and_no_registry_in_the_repository() -> None:
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()[:80]}"
        for path in TEXTS
        if path != Path(__file__)
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1)
        if FOREIGN.search(line)
    ]
    assert found == []


def test_constraints_carry_names_versions_and_hashes_only() -> None:
    allowed = re.compile(r"[\w.-]+==[\w.]+(?: ; [\w .'()=<>!]+)? \\|    --hash=sha256:[0-9a-f]{64}(?: \\)?")
    lines = (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if not allowed.fullmatch(line)] == []


TWINS = {"Band", "Capsule", "Contact", "Effect", "Ellipsoid", "Limb", "Net", "Sphere"}
"""A thing as a case file says it (`loadcases`) and the same thing as it acts: the only names that stand twice."""


def test_no_two_classes_have_one_name() -> None:
    found: dict[str, list[Path]] = {}
    for path in MODULES:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef):
                found.setdefault(node.name, []).append(path.relative_to(ROOT))
    double = {name: paths for name, paths in found.items() if len(paths) > 1 and not name.startswith("_")}
    assert set(double) == TWINS, {name: paths for name, paths in double.items() if name not in TWINS}
    assert all(
        sum(path.parts[0] == "loadcases" for path in double[name]) == 1 == len(double[name]) - 1 for name in TWINS
    )
