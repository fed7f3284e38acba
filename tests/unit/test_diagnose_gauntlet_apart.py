"""The hidden data of the gauntlet and the diagnosis know nothing of each other."""

from __future__ import annotations

import ast
from pathlib import Path


ROOT = Path(__file__).parents[2]
GAUNTLET = ROOT / "tests" / "workflow" / "gauntlet"
MAKERS = ("solver", "mechanisms", "measure", "truths", "generate")
PRODUCT = ("etextile", "wires", "loadcases", "viz")


def imported(path: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names.add((node.module or "").split(".")[0])
    return names


def test_makers_of_hidden_data_use_nothing_of_the_product() -> None:
    for name in MAKERS:
        assert not imported(GAUNTLET / f"{name}.py") & set(PRODUCT), name


def test_the_product_uses_nothing_of_the_makers_of_hidden_data() -> None:
    for package in PRODUCT:
        for path in (ROOT / package).rglob("*.py"):
            assert not imported(path) & {*MAKERS, "gauntlet", "tests"}, path


def test_the_score_sees_answers_only_after_the_diagnosis() -> None:
    """Who diagnoses reads no answers."""
    assert "answers" not in (GAUNTLET / "judge.py").read_text(encoding="utf-8")
