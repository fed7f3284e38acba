"""Imports point one way only, and heavy libraries stay in the packages that own them."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest


ROOT = Path(__file__).parents[2]
LAYERS = (
    (
        "etextile.errors",
        "etextile.collisions",
        "etextile.plugins",
        "etextile.registry",
        "etextile.units",
        "etextile.types",
        "etextile.compiled",
        "etextile.process",
        "etextile.files",
        "etextile.foreign_code",
        "etextile.kept",
        "etextile.environment",
        "etextile.vocabulary",
        "etextile.visible",
    ),
    ("etextile.importers",),
    ("etextile.lattice", "etextile.laws"),
    ("etextile.mechanics",),
    ("etextile.motion", "etextile.contact", "etextile.effects", "etextile.solve"),
    ("etextile.results", "etextile.identify", "etextile.diagnose", "etextile.ensemble", "etextile.life"),
    ("wires",),
    ("loadcases",),
    ("viz",),
    ("etextile.studies",),
    ("etextile.text",),
    ("etextile.app", "etextile.manual", "etextile.__main__", "etextile"),
)
LEVEL = {package: level for level, packages in enumerate(LAYERS) for package in packages}
OWNERS = {
    "h5py": ("etextile.results",),
    "trimesh": ("etextile.contact",),
    "pyvista": ("viz",),
    "vtk": ("viz",),
    "vtkmodules": ("viz",),
    "yaml": ("loadcases", "etextile.effects"),
    "ruamel": ("loadcases", "etextile.effects"),
    "pydantic": ("loadcases", "etextile.effects"),
}
HEAVY = ("numba", "pyvista", "vtkmodules", "scipy", "h5py", "trimesh", "dask", "distributed", "matplotlib")


def modules() -> Iterator[tuple[str, Path]]:
    for top in ("etextile", "wires", "loadcases", "viz"):
        for path in sorted((ROOT / top).rglob("*.py")):
            yield ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"), path


def imports(path: Path) -> Iterator[tuple[int, str]]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            # `from etextile import units` names the module in its second half
            base = "." * node.level + (node.module or "")
            yield from ((node.lineno, f"{base}.{alias.name}" if base == "etextile" else base) for alias in node.names)


def package_of(name: str) -> str | None:
    parts = name.split(".")
    return next((known for known in (".".join(parts[:2]), parts[0]) if known in LEVEL), None)


def breaches(module: str, path: Path) -> Iterator[str]:
    package = package_of(module)
    for line, name in imports(path):
        place = f"{path.relative_to(ROOT)}:{line}: {module} imports {name}"
        target = package_of(name)
        if name.startswith("."):
            yield f"{place}: imports are absolute"
        elif target and package and LEVEL[target] > LEVEL[package]:
            yield f"{place}: {target} stands above {package}"
        elif (package, target) == ("viz", "loadcases"):
            yield f"{place}: viz reads etextile and wires only"
        elif package not in OWNERS.get(name.split(".")[0], (package,)):
            yield f"{place}: belongs in {' or '.join(OWNERS[name.split('.')[0]])}"


def test_every_module_has_a_place_in_the_import_order() -> None:
    assert [name for name, _ in modules() if name != "etextile" and package_of(name) in (None, "etextile")] == []


def test_imports_follow_the_order_of_the_packages() -> None:
    assert [breach for name, path in modules() for breach in breaches(name, path)] == []


def imported_modules(path: Path, known: frozenset[str]) -> set[str]:
    """Return the modules of ours that a file imports, also late or for types alone."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names} & known
        elif isinstance(node, ast.ImportFrom) and node.module:
            inner = {f"{node.module}.{alias.name}" for alias in node.names} & known
            found |= inner or ({node.module} & known)
    return found


def circle(graph: Mapping[str, set[str]]) -> list[str]:
    """Return modules that import one another in a circle, none when there is no circle."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_modules_import_one_another_in_a_circle() -> None:
    files = dict(modules())
    known = frozenset(files)
    assert circle({name: imported_modules(path, known) - {name} for name, path in files.items()}) == []


def test_a_circle_is_found_whether_late_or_for_types(tmp_path: Path) -> None:
    known = frozenset({"wires.a", "wires.b"})
    (tmp_path / "a.py").write_text("from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from wires.b import B\n")
    (tmp_path / "b.py").write_text("def late():\n    from wires import a\n")
    graph = {f"wires.{name}": imported_modules(tmp_path / f"{name}.py", known) for name in "ab"}
    assert set(circle(graph)) == known


@pytest.mark.parametrize(
    ("module", "line"),
    [
        ("etextile.laws.truss", "from etextile.solve import newton"),
        ("etextile.solve.path", "from etextile import app"),
        ("etextile.solve.path", "from etextile import run"),
        ("etextile.studies.table", "import etextile as et"),
        ("etextile.text.plain", "from etextile.app.show import show"),
        ("wires.layout", "import h5py"),
        ("viz.maps", "from loadcases.schema import Case"),
        ("etextile.lattice.weave", "from .piece import Piece"),
        ("etextile.results.store", "def late():\n    import pyvista.plotting"),
    ],
)
def test_a_breach_is_found(module: str, line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(globals(), "ROOT", tmp_path)
    (tmp_path / "module.py").write_text(line)
    assert len(list(breaches(module, tmp_path / "module.py"))) == 1


@pytest.mark.parametrize(
    ("arguments", "banned"),
    [(["--help"], HEAVY), (["check", "punch"], ("vtkmodules", "pyvista"))],
    ids=["help", "check"],
)
def test_verbs_load_only_what_they_need(arguments: list[str], banned: tuple[str, ...]) -> None:
    code = (
        f"import sys; sys.argv = ['etextile', *{arguments}]\n"
        "from etextile.app.cli import main\n"
        "try:\n    main()\nexcept SystemExit as end:\n    assert not end.code, end.code\n"
        f"print('loaded:', *sorted(set({banned}) & set(sys.modules)))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=ROOT)
    assert run.returncode == 0, run.stderr
    assert run.stdout.splitlines()[-1].strip() == "loaded:"
